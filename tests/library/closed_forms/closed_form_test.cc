// Closed forms compared with independent numerical integration, and with their limits.
#include "library/closed_forms/closed_form.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "tests/library/closed_forms/closed_form_scenes.h"

namespace cdb::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kExact = 1e-12;  // a few thousand rounding errors of numbers near 1

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
  // Differences of a parabola are exact up to rounding.
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
  // Both fly alike, so that only the rotation of each contributes: m (b² + c²)/12 and so on.
  EXPECT_LT((*start.angular_momentum - 2 * 2 * Vector3d(13, 10 * 2, 5 * 3) / 12).norm(), kExact);
  // At 1 s the velocity is (3, 5 - 9.8, -1); the speed is lower than at the start.
  EXPECT_NEAR(form->energy_scale(), 2 * (35 + Vector3d(13, 10, 5).dot(Vector3d(1, 4, 9)) / 12),
              1e-9);
}

/// The ball's height after `seconds`, computed in this number of steps. A step that crosses a wall
/// is divided there by bisection.
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
    // The energy lost to friction and to the gap by which it settles.
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

/// An independent solution by the Runge-Kutta method in the world's axes, where the angular
/// momentum is constant.
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
  // The last time is earlier than the one before.
  for (const double t : {0.0, 0.5, 3.0, 20.0, 1.0}) {
    const closed_forms::Truth truth = form->At(t);
    const Quaterniond stepped = TurnBySteps(state.objects[0].pose.orientation, inertia, momentum, t,
                                            1 + static_cast<int>(2000 * t));
    // The error is h^4 with steps of 1.5e-3 rad, over 60 rad near the unstable axis, where errors
    // grow.
    EXPECT_LT(truth.orientations[0].angularDistance(stepped), 1e-6) << t;
    const Matrix3d r = truth.orientations[0].toRotationMatrix();
    const Vector3d body = r.transpose() * truth.spins[0];
    EXPECT_LT((r * inertia.cwiseProduct(body) - momentum).norm(), kExact * momentum.norm()) << t;
    EXPECT_NEAR(inertia.dot(body.cwiseAbs2()) / 2, form->energy_scale(),
                kExact * form->energy_scale());
  }
  // It tumbles: the unstable axis turns over on the way.
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
                                after = form->At(0.75);  // they collide at 0.5 s
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
      // With restitution 0 they would lose this energy.
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
  EXPECT_NEAR(*truth.energy, 0, 1e-3);  // the gap by which it settles
  // The kinetic energy at the end, 1 s, is the energy released.
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
  // Each cube is a gap above the one below: together 1 + 2 + … gaps.
  EXPECT_NEAR(*truth.energy, -9.8 * kHair * 20 * 21 / 2, 1e-9);
}

/// Checks a form of one object: velocity and spin are the derivatives of positions and
/// orientations, and momentum, energy and angular momentum are those of the scene's bodies. Except
/// at `corners`, where velocities change instantly. `spring`: N/m.
void ExpectConsistent(const char* name, const plan::Scene& scene, double end,
                      const std::vector<double>& corners = {}, double spring = 0) {
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const layouts::ObjectState& object = state.objects[0];
  const auto form = closed_forms::MakeClosedForm(name, scene, state);
  const auto energy = [&](const closed_forms::Truth& truth) {
    const Quaterniond turn =
        truth.orientations.empty() ? object.pose.orientation : truth.orientations[0];
    const Vector3d body = turn.conjugate() * truth.spins[0];
    const Vector3d way = truth.positions[0] - object.pose.position;
    return object.mass * (truth.velocities[0].squaredNorm() / 2 - state.acceleration.dot(way) +
                          object.solid.InertiaPerMass().dot(body.cwiseAbs2()) / 2) +
           spring * way.squaredNorm() / 2;
  };
  closed_forms::Truth start = form->At(0);
  // Before it settles by the gap.
  start.positions[0] = object.pose.position;
  const double h = 1e-5;
  for (double t = h; t < end; t += end / 37) {
    if (std::ranges::any_of(corners, [&](double corner) { return std::abs(t - corner) < 2 * h; }))
      continue;
    const closed_forms::Truth before = form->At(t - h), now = form->At(t), after = form->At(t + h);
    const Vector3d moved = (after.positions[0] - before.positions[0]) / (2 * h);
    EXPECT_LT((moved - now.velocities[0]).norm(), 1e-6) << name << ' ' << t;
    EXPECT_NEAR(*now.energy, energy(now) - energy(start), 1e-9 * form->energy_scale())
        << name << ' ' << t;
    EXPECT_LT((*now.momentum - object.mass * now.velocities[0]).norm(), 1e-12);
    if (now.orientations.empty()) continue;
    const Quaterniond turned = after.orientations[0] * before.orientations[0].conjugate();
    const Eigen::AngleAxisd by(turned);
    EXPECT_LT((by.angle() / (2 * h) * by.axis() - now.spins[0]).norm(), 1e-4) << name << ' ' << t;
  }
}

TEST(ClosedForms, BrakingStopsAfterTheSquareOfTheSpeed) {
  const double mu = 0.4, stops = 3 / (mu * 9.8);
  ExpectConsistent("braking", BrakingScene(), 1, {stops});
  const auto form = FormOf("braking", BrakingScene());
  EXPECT_NEAR(form->At(stops).positions[0].x(), -2 + 9 / (2 * mu * 9.8), kExact);
  EXPECT_EQ(form->At(1).velocities[0], Vector3d::Zero());
  EXPECT_EQ(form->At(9).positions[0].x(), form->At(1).positions[0].x());
}

TEST(ClosedForms, RollIsFiveSeventhsWhereFrictionHoldsAndSlipsWhereNot) {
  const double a = 9.8 * std::sin(0.5), n = 9.8 * std::cos(0.5), r = 0.5, t = 0.8;
  ExpectConsistent("roll", RollScene(0.5, 0.4), 1);
  ExpectConsistent("roll", RollScene(0.5, 0.2), 1);
  const closed_forms::Truth rolls = FormOf("roll", RollScene(0.5, 0.4))->At(t);
  EXPECT_NEAR(rolls.velocities[0].x(), a * t * 5 / 7, kExact);
  EXPECT_NEAR(rolls.spins[0].z(), -a * t * 5 / 7 / r, kExact);
  EXPECT_NEAR(*rolls.energy, 0, 1e-4);  // the gap
  // The torque mu m n r over 2/5 m r^2.
  const closed_forms::Truth slips = FormOf("roll", RollScene(0.5, 0.2))->At(t);
  EXPECT_NEAR(slips.velocities[0].x(), (a - 0.1 * n) * t, kExact);
  EXPECT_NEAR(slips.spins[0].z(), -0.1 * n / (0.4 * r) * t, kExact);
  EXPECT_LT(*slips.energy, -0.1);
}

TEST(ClosedForms, BowlRollsAtFiveSeventhsOfItsSpeed) {
  const double rolls = 2.0 / 7 * 7 / (0.2 * 9.8);
  ExpectConsistent("bowl", BowlScene(), 2, {rolls});
  const closed_forms::Truth truth = FormOf("bowl", BowlScene())->At(1.5);
  EXPECT_NEAR(truth.velocities[0].x(), 5, kExact);
  EXPECT_NEAR(truth.spins[0].z(), -10, kExact);
  // It loses 2/7 of the energy.
  EXPECT_NEAR(*truth.energy, -2.0 / 7 * 7 * 49 / 2, 1e-3);
  // About the lowest point, the angular momentum is constant for any initial spin.
  plan::Scene spinning = BowlScene();
  SetGroup(spinning, "angular_velocity", Vector3d(3, 0, 20));
  SetTime(spinning, 1.0 / 60, 3);
  const auto form = FormOf("bowl", spinning);
  ExpectConsistent("bowl", spinning, 0.5);
  const auto about_lowest = [&](double t) {
    const closed_forms::Truth now = form->At(t);
    return Vector3d(*now.angular_momentum + 0.5 * Vector3d::UnitY().cross(*now.momentum));
  };
  for (const double t : {0.3, 1.0, 2.9})
    EXPECT_LT((about_lowest(t) - about_lowest(0)).norm(), 1e-9) << t;
  const closed_forms::Truth last = form->At(2.9);
  EXPECT_LT((last.velocities[0] - 0.5 * last.spins[0].cross(Vector3d::UnitY())).norm(), 1e-12);
}

TEST(ClosedForms, HaveTheCoefficientsOfTheWalls) {
  const auto walls = [](plan::Scene scene, double friction, double restitution) {
    SetWorld(scene, "world.wall_friction", friction);
    SetWorld(scene, "world.wall_restitution", restitution);
    return scene;
  };
  const auto same = [](std::string_view form, const plan::Scene& one, const plan::Scene& other) {
    const closed_forms::Truth a = FormOf(form, one)->At(1.2), b = FormOf(form, other)->At(1.2);
    return a.positions == b.positions && a.velocities == b.velocities;
  };
  EXPECT_TRUE(same("bounce", walls(BounceScene(1), 0.5, 0.5), BounceScene(0.5)));
  EXPECT_FALSE(same("bounce", walls(BounceScene(1), 0.5, 0.25), BounceScene(0.5)));
  EXPECT_TRUE(same("oblique", walls(ObliqueScene(0.1), 1, 1), ObliqueScene(0.2)));
  EXPECT_FALSE(same("oblique", ObliqueScene(0.1), ObliqueScene(0.2)));
}

TEST(ClosedForms, ObliqueSticksOrSlips) {
  for (const double friction : {0.2, 1.0}) {
    const double mu = friction / 2;
    ExpectConsistent("oblique", ObliqueScene(friction), 1, {0.5});
    const closed_forms::Truth after = FormOf("oblique", ObliqueScene(friction))->At(0.75);
    EXPECT_NEAR(after.velocities[0].y(), 0.8 * 3, kExact);
    // A ball that stops slipping keeps 5/7 of its speed along the wall.
    const double lost = std::min(mu * 1.8 * 3, 3 * 2.0 / 7);
    EXPECT_NEAR(after.velocities[0].x(), 3 - lost, kExact);
    EXPECT_NEAR(after.spins[0].z(), -lost / (0.4 * 0.5), kExact);
    EXPECT_NEAR(after.positions[0].x(), -1 + 3 * 0.5 + (3 - lost) * 0.25, kExact);
  }
}

TEST(ClosedForms, SpringHasItsPeriodAndItsDecay) {
  for (const double damping : {0.0, 0.5, 2 * std::sqrt(40.0), 40.0})
    ExpectConsistent("spring", SpringScene(damping), 1, {}, 40);
  const double period = 2 * std::numbers::pi / std::sqrt(40.0);
  const auto free = FormOf("spring", SpringScene(0));
  EXPECT_NEAR(free->At(7 * period).positions[0].y(), 0, 1e-9);
  EXPECT_NEAR(free->At(6.5 * period).positions[0].y(), -2 * 9.8 / 40, 1e-9);
  EXPECT_NEAR(*free->At(2.3).energy, 0, 1e-12);
  const auto damped = FormOf("spring", SpringScene(0.5));
  const double damped_period = 2 * std::numbers::pi / std::sqrt(40 - 0.25 * 0.25);
  const double hangs = -9.8 / 40;
  EXPECT_NEAR(damped->At(damped_period).positions[0].y() - hangs,
              -hangs * std::exp(-0.25 * damped_period), 1e-12);
  EXPECT_NEAR(damped->At(100).positions[0].y(), hangs, 1e-9);
}

TEST(ClosedForms, PendulumAgreesWithStepsAndHasItsPeriod) {
  // I + m l^2 of a rod of 1 m and 0.1 m: (1 + 0.01)/12 + 1/4.
  const double square = 0.5 * 9.8 / (1.01 / 12 + 0.25);
  for (const double angle : {0.2, 2.0, 3.1}) {
    ExpectConsistent("pendulum", PendulumScene(angle), 1);
    const auto form = FormOf("pendulum", PendulumScene(angle));
    const double period = 4 * std::comp_ellint_1(std::sin(angle / 2)) / std::sqrt(square);
    EXPECT_LT(form->At(3 * period).positions[0].norm(), 1e-9) << angle;
    EXPECT_LT(form->At(period / 2).velocities[0].norm(), 1e-6) << angle;
    // By the Runge-Kutta method.
    double q = angle, rate = 0;
    const int steps = 4000;
    const double h = 1.0 / steps;
    const auto pull = [&](double at) { return -square * std::sin(at); };
    for (int i = 0; i < steps; ++i) {
      const double k1 = rate, l1 = pull(q), k2 = rate + h / 2 * l1, l2 = pull(q + h / 2 * k1),
                   k3 = rate + h / 2 * l2, l3 = pull(q + h / 2 * k2), k4 = rate + h * l3,
                   l4 = pull(q + h * k3);
      q += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      rate += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
    const closed_forms::Truth truth = form->At(1);
    EXPECT_NEAR(truth.spins[0].z(), -rate, 1e-9) << angle;
    EXPECT_NEAR(truth.positions[0].x(), 0.5 * std::sin(angle - q), 1e-9) << angle;
    EXPECT_NEAR(truth.positions[0].y(), 0.5 - 0.5 * std::cos(angle - q), 1e-9) << angle;
  }
}

TEST(ClosedForms, FlipTurnsOverAtEvenTimes) {
  const auto form = FormOf("flip", FlipScene());
  std::vector<double> flips;
  const auto along_middle = [&](double t) {
    const closed_forms::Truth truth = form->At(t);
    return (truth.orientations[0].conjugate() * truth.spins[0]).y();
  };
  for (double t = 0; t < 12; t += 0.01) {
    double low = t, high = t + 0.01;
    if (along_middle(low) * along_middle(high) > 0) continue;
    for (int i = 0; i < 40; ++i) {
      const double middle = (low + high) / 2;
      (along_middle(middle) * along_middle(high) > 0 ? high : low) = middle;
    }
    flips.push_back(low);
  }
  ASSERT_GE(flips.size(), 3u);
  // By the formula, with I = (6.25, 5, 3.25)/12 and w = (0.5, 5, 0.25).
  const double i1 = 3.25, i2 = 5, i3 = 6.25;
  const double twice = i3 * 0.25 + i2 * 25 + i1 * 0.0625;
  const double square = i3 * i3 * 0.25 + i2 * i2 * 25 + i1 * i1 * 0.0625;
  const double a = square > twice * i2 ? i1 : i3, c = square > twice * i2 ? i3 : i1;
  const double rate = std::sqrt((c - i2) * (square - twice * a) / (i1 * i2 * i3));
  const double modulus = (i2 - a) * (twice * c - square) / ((c - i2) * (square - twice * a));
  const double period = 2 * std::comp_ellint_1(std::sqrt(modulus)) / rate;
  for (std::size_t i = 1; i < flips.size(); ++i) EXPECT_NEAR(flips[i] - flips[i - 1], period, 1e-6);
}

TEST(ClosedForms, AreAllInTheCatalogue) {
  const std::map<std::string_view, plan::Scene> scenes = {
      {"flight", FlightScene()},      {"bounce", BounceScene()}, {"slide", SlopeScene(0.5, 0.4)},
      {"stick", SlopeScene(0.3, 1)},  {"spin", SpinScene()},     {"head_on", HeadOnScene(2, 0.5)},
      {"rolling", RollingScene(0.1)}, {"stack", StackScene(5)},  {"braking", BrakingScene()},
      {"roll", RollScene(0.5, 0.4)},  {"bowl", BowlScene()},     {"oblique", ObliqueScene(1)},
      {"spring", SpringScene(0)},     {"flip", FlipScene()},     {"pendulum", PendulumScene(1)},
  };
  EXPECT_EQ(schema::ClosedForms().size(), scenes.size());
  for (const schema::ClosedFormInfo& info : schema::ClosedForms()) {
    const auto form = FormOf(info.name, scenes.at(info.name));
    EXPECT_GT(form->energy_scale(), 0) << info.name;
  }
}

}  // namespace
}  // namespace cdb::tests
