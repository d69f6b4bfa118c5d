// Closed forms compared with independent numerical integration, and with their limits.
#include "library/closed_forms/closed_form.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "compiler/schema/catalogue.h"
#include "tests/library/closed_forms/closed_form_scenes.h"

namespace cdb::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kExact = 1e-12;  // a few thousand roundings of numbers about 1

TEST(ClosedForms, FlightStartsAsTheSceneAndHasItsAcceleration) {
  plan::Scene scene = FlightScene();
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "aspect", schema::Ratio{{1, 2, 3}});
  SetGroup(scene, "angular_velocity", Vector3d(1, 2, 3));
  SetGroup(scene, "location", At(1, 2, 3));
  SetGroup(scene, "mass", 2.0);
  AddGroup(scene, "other", 1, At(-3, -2, 2));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const auto form = closed_forms::MakeClosedForm("flight", scene, state);
  const closed_forms::Truth start = form->At(0);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(start.positions[i], state.objects[i].pose.position);
    EXPECT_EQ(start.velocities[i], state.objects[i].linear_velocity);
  }
  // Differences of a parabola are exact but for rounding.
  const double h = 1.0 / 8;
  for (double t = h; t < 1; t += h) {
    const closed_forms::Truth before = form->At(t - h), now = form->At(t), after = form->At(t + h);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_LT(((after.positions[i] - before.positions[i]) / (2 * h) - now.velocities[i]).norm(),
                kExact);
      EXPECT_LT(
          ((after.velocities[i] - before.velocities[i]) / (2 * h) - state.acceleration).norm(),
          kExact);
    }
    EXPECT_EQ(now.energy, 0);
    EXPECT_LT((*now.momentum - 2 * (now.velocities[0] + now.velocities[1])).norm(), kExact);
    EXPECT_EQ(*now.angular_momentum, *start.angular_momentum);
  }
  // Both fly alike, so that what turns is all that there is: m (b² + c²)/12 and so on.
  EXPECT_LT((*start.angular_momentum - 2 * 2 * Vector3d(13, 10 * 2, 5 * 3) / 12).norm(), kExact);
  // At 1 s the speed is (3, 5 - 9.8, -1), below that at the start.
  EXPECT_NEAR(form->energy_scale(), 2 * (35 + Vector3d(13, 10, 5).dot(Vector3d(1, 4, 9)) / 12),
              1e-9);
}

/// The ball's height after `seconds`, in so many steps of which each that crosses a wall is cut
/// there by halving.
double BounceBySteps(double y, double v, double g, double low, double high, double restitution,
                     double seconds, int steps) {
  const double h = seconds / steps;
  const auto fly = [&](double& at, double& speed, double t) {
    at += speed * t + g * t * t / 2;
    speed += g * t;
  };
  for (int i = 0; i < steps; ++i) {
    double left = h;
    for (int bounces = 0; bounces < 4; ++bounces) {
      double to = y, speed = v;
      fly(to, speed, left);
      if (to >= low && to <= high) break;
      const double wall = to < low ? low : high;
      double inside = 0, outside = left;
      for (int k = 0; k < 60; ++k) {
        const double middle = (inside + outside) / 2;
        double at = y, unused = v;
        fly(at, unused, middle);
        (at >= low && at <= high ? inside : outside) = middle;
      }
      fly(y, v, inside);
      y = wall;
      v *= -restitution;
      left -= inside;
    }
    fly(y, v, left);
  }
  return y;
}

TEST(ClosedForms, BounceAgreesWithSteps) {
  for (const double restitution : {1.0, 0.8}) {
    for (const double g : {-9.8, 0.0, 3.0}) {
      for (const double speed : {-7.0, 12.0}) {
        plan::Scene scene = BounceScene(restitution);
        SetWorld(scene, "world.walls", Word("all"));
        SetWorld(scene, "acceleration", Vector3d(0, g, 0));
        SetGroup(scene, "linear_velocity", Vector3d(0, speed, 0));
        const auto form = FormOf("bounce", scene);
        for (const double t : {0.1, 0.5, 1.0, 1.9}) {
          EXPECT_NEAR(form->At(t).positions[0].y(),
                      BounceBySteps(0, speed, g, -4.5, 4.5, restitution, t, 1000), 1e-9)
              << "restitution " << restitution << " g " << g << " v " << speed << " t " << t;
          const double v = form->At(t).velocities[0].y(), y = form->At(t).positions[0].y();
          EXPECT_NEAR(*form->At(t).energy, (v * v - speed * speed) / 2 - g * y, 1e-9);
          if (restitution == 1) {
            EXPECT_NEAR(*form->At(t).energy, 0, 1e-9);
          }
        }
      }
    }
  }
}

TEST(ClosedForms, BounceIsPeriodicWhereElasticAndRestsInFiniteTimeWhereNot) {
  const double fall = std::sqrt(2 * 4.5 / 9.8);
  const auto elastic = FormOf("bounce", BounceScene());
  EXPECT_NEAR(elastic->At(2000 * fall).positions[0].y(), 0, 1e-9);
  EXPECT_NEAR(elastic->At(2001 * fall).positions[0].y(), -4.5, 1e-6);
  EXPECT_NEAR(elastic->energy_scale(), 9.8 * 4.5, kExact * 100);
  const auto half = FormOf("bounce", BounceScene(0.5));
  // Bounces last e, e² … times two falls.
  const double rests = fall * (1 + 2 * 0.5 / (1 - 0.5));
  EXPECT_GT(half->At(0.999 * rests).velocities[0].norm(), 0);
  EXPECT_EQ(half->At(rests).velocities[0].norm(), 0);
  EXPECT_EQ(half->At(1e6).positions[0].y(), -4.5);
  EXPECT_NEAR(*half->At(rests).energy, -9.8 * 4.5, 1e-9);
  const auto dead = FormOf("bounce", BounceScene(0));
  EXPECT_EQ(dead->At(1.001 * fall).velocities[0].norm(), 0);
}

TEST(ClosedForms, SlideIsWhatIsLeftOfTheSlopeAfterFriction) {
  const auto form = FormOf("slide", SlopeScene(0.5, 0.4));
  const double along = 9.8 * (std::sin(0.5) - 0.4 * 0.5 * std::cos(0.5));
  for (const double t : {0.0, 0.3, 1.0}) {
    const closed_forms::Truth truth = form->At(t);
    EXPECT_LT((truth.positions[0] - Vector3d(along * t * t / 2, -4.75, 0)).norm(), kExact);
    EXPECT_LT((truth.velocities[0] - Vector3d(along * t, 0, 0)).norm(), kExact);
    // What friction takes, and the hair that it settles by.
    EXPECT_NEAR(*truth.energy, -0.2 * 9.8 * std::cos(0.5) * (along * t * t / 2), 1e-4);
  }
  EXPECT_NEAR(form->energy_scale(), 9.8 * std::sin(0.5) * along / 2, kExact * 10);
  const auto frictionless = FormOf("slide", SlopeScene(0.5, 0));
  EXPECT_NEAR(frictionless->At(1).positions[0].x(), 9.8 * std::sin(0.5) / 2, kExact);
  EXPECT_NEAR(*frictionless->At(1).energy, 0, 1e-4);
}

TEST(ClosedForms, StickStaysWhereItStands) {
  const auto form = FormOf("stick", SlopeScene(0.3, 1));
  for (const double t : {0.0, 1.0}) {
    EXPECT_LT((form->At(t).positions[0] - Vector3d(0, -4.75, 0)).norm(), kExact);
    EXPECT_EQ(form->At(t).velocities[0], Vector3d::Zero());
    EXPECT_EQ(*form->At(t).momentum, Vector3d::Zero());
  }
}

/// Another way: in the world's axes, where the angular momentum stays, by Runge and Kutta.
Quaterniond TurnBySteps(Quaterniond turn, const Vector3d& inertia, const Vector3d& momentum,
                        double seconds, int steps) {
  const auto rate = [&](const Quaterniond& q) {
    const Matrix3d r = q.normalized().toRotationMatrix();
    const Vector3d spin = r * (r.transpose() * momentum).cwiseQuotient(inertia);
    return Eigen::Vector4d((Quaterniond(0, spin.x(), spin.y(), spin.z()) * q).coeffs() / 2);
  };
  const double h = seconds / steps;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector4d q = turn.coeffs();
    const Eigen::Vector4d k1 = rate(turn);
    const Eigen::Vector4d k2 = rate(Quaterniond(q + h / 2 * k1));
    const Eigen::Vector4d k3 = rate(Quaterniond(q + h / 2 * k2));
    const Eigen::Vector4d k4 = rate(Quaterniond(q + h * k3));
    turn = Quaterniond(q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)).normalized();
  }
  return turn;
}

TEST(ClosedForms, SpinAgreesWithStepsAndKeepsEnergyAndAngularMomentum) {
  plan::Scene scene = SpinScene();
  const Vector3d orientation(0.3, -0.4, 1);
  SetGroup(scene, "orientation", orientation);
  SetGroup(scene, "angular_velocity",
           Vector3d(layouts::TurnAbout(orientation) * Vector3d(0.2, 3, 0.1)));
  SetGroup(scene, "mass", 3.0);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const auto form = closed_forms::MakeClosedForm("spin", scene, state);
  const Vector3d inertia = 3 * state.objects[0].solid.InertiaPerMass();
  const Vector3d momentum = *form->At(0).angular_momentum;
  // The last time goes back.
  for (const double t : {0.0, 0.5, 3.0, 20.0, 1.0}) {
    const closed_forms::Truth truth = form->At(t);
    const Quaterniond stepped = TurnBySteps(state.objects[0].pose.orientation, inertia, momentum, t,
                                            1 + static_cast<int>(2000 * t));
    // h^4 of steps of 1.5e-3 rad, over 60 rad near the unstable axis, which spreads errors.
    EXPECT_LT(truth.orientations[0].angularDistance(stepped), 1e-6) << t;
    const Matrix3d r = truth.orientations[0].toRotationMatrix();
    const Vector3d body = r.transpose() * truth.spins[0];
    EXPECT_LT((r * inertia.cwiseProduct(body) - momentum).norm(), kExact * momentum.norm()) << t;
    EXPECT_NEAR(inertia.dot(body.cwiseAbs2()) / 2, form->energy_scale(),
                kExact * form->energy_scale());
  }
  // It tumbles: the unstable axis has turned over on the way.
  bool turned_over = false;
  for (double t = 0; t < 20; t += 0.1) {
    const closed_forms::Truth truth = form->At(t);
    turned_over |= (truth.orientations[0].conjugate() * truth.spins[0]).y() < -2.5;
  }
  EXPECT_TRUE(turned_over);
}

TEST(ClosedForms, SpinOfASymmetricTopPrecessesSteadily) {
  plan::Scene scene = SpinScene();
  SetGroup(scene, "aspect", schema::Ratio{{1, 3, 1}});
  SetGroup(scene, "angular_velocity", Vector3d(1, 2, 0));
  const auto form = FormOf("spin", scene);
  // About its axis of symmetry y: I = (10, 2, 10)/12; the spin goes round in the body at
  // (I1 - I2)/I1 w2, and the body about the angular momentum at L/I1.
  const double slip = (10.0 - 2) / 10 * 2;
  const Vector3d momentum(10.0 / 12, 2 * 2.0 / 12, 0);
  const double t = 1.7;
  const closed_forms::Truth truth = form->At(t);
  const Vector3d body = truth.orientations[0].conjugate() * truth.spins[0];
  EXPECT_LT((body - Vector3d(std::cos(slip * t), 2, std::sin(slip * t))).norm(), kExact);
  const Vector3d axis = truth.orientations[0] * Vector3d::UnitY();
  const Vector3d round = layouts::TurnAbout(momentum * (12.0 / 10) * t) * Vector3d::UnitY();
  EXPECT_LT((axis - round).norm(), kExact);
}

TEST(ClosedForms, HeadOnKeepsMomentumAndTheRestitutionsPartOfTheSpeed) {
  for (const double mass : {1.0, 5.0}) {
    for (const double restitution : {1.0, 0.5}) {
      const auto form = FormOf("head_on", HeadOnScene(mass, restitution));
      const closed_forms::Truth before = form->At(0.499),
                                after = form->At(0.75);  // they meet at 0.5 s
      EXPECT_EQ(before.velocities[0].x(), 3);
      EXPECT_NEAR(after.velocities[1].x() - after.velocities[0].x(), restitution * 4, kExact);
      EXPECT_NEAR(after.velocities[0].x() + mass * after.velocities[1].x(), 3 - mass, kExact);
      EXPECT_NEAR(after.positions[0].x(), 0 + 0.25 * after.velocities[0].x(), kExact);
      EXPECT_NEAR(after.positions[1].x(), 1 + 0.25 * after.velocities[1].x(), kExact);
      const auto kinetic = [&](const closed_forms::Truth& truth) {
        return truth.velocities[0].squaredNorm() / 2 + mass * truth.velocities[1].squaredNorm() / 2;
      };
      EXPECT_NEAR(*after.energy, kinetic(after) - kinetic(before), kExact);
      EXPECT_NEAR(after.momentum->x(), 3 - mass, kExact);
      EXPECT_NEAR(after.angular_momentum->norm(), 0, kExact);
      // With restitution 0 they would have this much less.
      EXPECT_NEAR(form->energy_scale(), mass / (1 + mass) / 2 * 16, kExact);
    }
  }
}

TEST(ClosedForms, RollingSolvesTheEquationsOfEachBody) {
  const double angle = 0.1, ax = 9.8 * std::sin(angle);
  const auto form = FormOf("rolling", RollingScene(angle));
  // Unknown: acceleration of plate and ball, the ball's about -z, friction of plate and floor on a
  // ball. 25 balls of 1 kg and a radius of 0.5 m, a plate of 10 kg.
  const double n = 25, m = 1, plate = 10, r = 0.5, moment = 0.4 * m * r * r;
  Eigen::Matrix<double, 5, 5> equations;
  equations << plate, 0, 0, n, 0,  // plate V' = plate a - n top
      0, m, 0, -1, -1,             // m v' = m a + top + floor
      0, 0, moment, -r, r,         // I w' = r top - r floor
      0, 1, -r, 0, 0,              // v = r w
      1, -2, 0, 0, 0;              // V = 2 v
  Eigen::Matrix<double, 5, 1> right;
  right << plate * ax, m * ax, 0, 0, 0;
  const Eigen::Matrix<double, 5, 1> solved = equations.fullPivLu().solve(right);
  const double t = 0.8;
  const closed_forms::Truth truth = form->At(t), start = form->At(0);
  EXPECT_NEAR(truth.velocities[25].x(), solved[0] * t, kExact);
  EXPECT_NEAR(truth.positions[25].x(), solved[0] * t * t / 2, kExact);
  for (std::size_t i = 0; i < 25; ++i) {
    EXPECT_NEAR(truth.velocities[i].x(), solved[1] * t, kExact);
    EXPECT_NEAR((truth.positions[i] - start.positions[i]).x(), solved[1] * t * t / 2, kExact);
    EXPECT_NEAR(truth.spins[i].z(), -solved[2] * t, kExact);
    EXPECT_EQ(truth.positions[i].y(), -19.5);
  }
  EXPECT_NEAR(truth.positions[25].y(), -18.5, kExact);
  EXPECT_NEAR(*truth.energy, 0, 1e-3);  // the hair that it settles by
  // The kinetic energy at the end, 1 s, is what was released.
  const double kinetic = plate * solved[0] * solved[0] / 2 +
                         n * (m * solved[1] * solved[1] + moment * solved[2] * solved[2]) / 2;
  EXPECT_NEAR(form->energy_scale(), kinetic, 1e-9);
  EXPECT_NEAR(truth.momentum->x(), (n * m * solved[1] + plate * solved[0]) * t, 1e-9);
}

TEST(ClosedForms, RollingUnderALightPlateIsThatOfBalls) {
  plan::Scene scene = RollingScene(0.1);
  SetGroup(scene, "mass", 1e-9, 1);
  const double t = 0.5, way = 9.8 * std::sin(0.1) * t * t / 2;
  EXPECT_NEAR(FormOf("rolling", scene)->At(t).positions[25].x(), 2 * way * 5 / 7, 1e-9);
  SetGroup(scene, "mass", 1e12, 1);
  EXPECT_NEAR(FormOf("rolling", scene)->At(t).positions[25].x(), way, 1e-9);
}

TEST(ClosedForms, StackIsAsHighAsItsBoxes) {
  const auto form = FormOf("stack", StackScene(20));
  const closed_forms::Truth truth = form->At(5);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(truth.positions[i].y(), -20 + static_cast<double>(i) + 0.5, kExact);
    EXPECT_EQ(truth.velocities[i], Vector3d::Zero());
  }
  // Each is a hair above the one below: together 1 + 2 + … of them.
  EXPECT_NEAR(*truth.energy, -9.8 * kHair * 20 * 21 / 2, 1e-9);
}

TEST(ClosedForms, AreAllInTheCatalogue) {
  const std::map<std::string_view, plan::Scene> scenes = {
      {"flight", FlightScene()},      {"bounce", BounceScene()}, {"slide", SlopeScene(0.5, 0.4)},
      {"stick", SlopeScene(0.3, 1)},  {"spin", SpinScene()},     {"head_on", HeadOnScene(2, 0.5)},
      {"rolling", RollingScene(0.1)}, {"stack", StackScene(5)},
  };
  EXPECT_EQ(schema::ClosedForms().size(), scenes.size());
  for (const schema::ClosedFormInfo& info : schema::ClosedForms()) {
    const auto form = FormOf(info.name, scenes.at(info.name));
    EXPECT_GT(form->energy_scale(), 0) << info.name;
  }
}

}  // namespace
}  // namespace cdb::tests
