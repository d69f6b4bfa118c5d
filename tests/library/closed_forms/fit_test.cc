// Scenes that each closed form rejects, with the reason.
#include "library/closed_forms/fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/library/closed_forms/closed_form_scenes.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using Change = std::function<void(plan::Scene&)>;

const schema::Value kUp = Vector3d(0, 9.8, 0), kNone = Vector3d(0, 0, 0), kX = Vector3d(1, 0, 0),
                    kOblique = Vector3d(1, 1, 0);
const schema::Value kEvery =
    schema::Call{"every", {schema::Value(std::uint64_t{5}), Vector3d(0, -9.8, 0)}};

Change Group(schema::GroupParameter name, schema::Value value, std::size_t at = 0) {
  return [=](plan::Scene& scene) { SetGroup(scene, name, value, at); };
}
Change World(schema::WorldParameter name, schema::Value value) {
  return [=](plan::Scene& scene) { SetWorld(scene, name, value); };
}
Change Slope(double angle) {
  return [angle](plan::Scene& scene) {
    SetWorld(scene, "acceleration", Vector3d(9.8 * std::sin(angle), -9.8 * std::cos(angle), 0));
  };
}

/// A scene that the form accepts, and a change after which it rejects the scene.
struct RefusedScene {
  const char* form;
  plan::Scene scene;
  Change change;
  const char* message;  ///< part of the message
};

void ExpectRefusals(const std::vector<RefusedScene>& refusals) {
  for (const RefusedScene& refusal : refusals) {
    EXPECT_NO_THROW(FormOf(refusal.form, refusal.scene)) << refusal.form;
    plan::Scene scene = refusal.scene;
    refusal.change(scene);
    try {
      FormOf(refusal.form, scene);
      ADD_FAILURE() << refusal.form << " takes: " << refusal.message;
    } catch (const library::SceneError& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.find(std::string("closed form `") + refusal.form + "`"), 0u) << text;
      EXPECT_NE(text.find(refusal.message), std::string::npos)
          << text << "\nshould say: " << refusal.message;
    }
  }
}

TEST(Fit, FlightRefusesScenesWithoutFreeFlight) {
  ExpectRefusals({
      {"flight", FlightScene(), Group("quantity", std::uint64_t{0}), "there is no object"},
      {"flight", FlightScene(), World("acceleration", kEvery), "acceleration is on a schedule"},
      {"flight", FlightScene(), Group("linear_velocity", kEvery), "objects.linear_velocity is on"},
      {"flight", FlightScene(), Group("mass", Word("fixed")), "is fixed; give it a mass"},
      {"flight", FlightScene(), Group("linear_damping", 0.1),
       "objects.linear_damping is 0.1; make it 0"},
      {"flight", FlightScene(), Group("contact_stiffness", 100.0),
       "objects.contact_stiffness is 100; make it rigid"},
      {"flight", FlightScene(),
       [](plan::Scene& scene) {
         SetWorld(scene, "world.walls", Word("floor"));
         SetTime(scene, 1.0 / 60, 3);
       },
       "object 1 of 1 (group `objects`) reaches the wall -y before the end; make the run shorter"},
      {"flight", FlightScene(),
       [](plan::Scene& scene) {
         SetGroup(scene, "location", At(-3, 0, 0));
         SetGroup(scene, "linear_velocity", Vector3d(0, 0, 0),
                  AddGroup(scene, "other", 1, At(-1.2, 2, 0)));
       },
       "object 2 of 2 (group `other`) comes so close to object 1 of 2 (group `objects`) that they "
       "may touch"},
      {"flight", FlightScene(),
       [](plan::Scene& scene) {
         SetWorld(scene, "acceleration", kNone);
         SetGroup(scene, "linear_velocity", kNone);
       },
       "nothing moves"},
  });
}

TEST(Fit, BounceRefusesScenesWithoutASingleBallBetweenWalls) {
  ExpectRefusals({
      {"bounce", BounceScene(), Group("type", Word("cuboid")), "is not a ball"},
      {"bounce", BounceScene(), Group("aspect", schema::Ratio{{1, 2, 1}}), "is not a ball"},
      {"bounce", BounceScene(), Group("angular_velocity", kX), "spins"},
      {"bounce", BounceScene(), Group("linear_velocity", kX), "not both along one axis"},
      {"bounce", BounceScene(), World("acceleration", kOblique), "not both along one axis"},
      {"bounce", BounceScene(), World("world.walls", Word("none")),
       "there is no wall in the path of"},
      {"bounce", BounceScene(), World("acceleration", kUp), "falls to a side without a wall"},
      {"bounce", BounceScene(), World("acceleration", kNone), "nothing moves"},
      {"bounce", BounceScene(),
       [](plan::Scene& scene) { AddGroup(scene, "other", 1, At(3, 0, 0)); },
       "there are 2 objects; the closed form has one"},
  });
}

TEST(Fit, SlideAndStickRefuseScenesWithoutACuboidOnASlope) {
  ExpectRefusals({
      {"slide", SlopeScene(0.5, 0.4), World("world.walls", Word("none")), "there is no floor"},
      {"slide", SlopeScene(0.5, 0.4), World("acceleration", kUp), "does not press onto the floor"},
      {"slide", SlopeScene(0.5, 0.4), Group("type", Word("cylinder")), "is not a cuboid"},
      {"slide", SlopeScene(0.5, 0.4), Group("orientation", Vector3d(0.1, 0, 0)), "is not level"},
      {"slide", SlopeScene(0.5, 0.4), Group("location", At(0, -4.7, 0)),
       "is 0.05 m above what it should stand on; a gap of at most 0.005 m"},
      {"slide", SlopeScene(0.5, 0.4), Group("linear_velocity", kX), "moves at the start"},
      {"slide", SlopeScene(0.5, 0.4), Slope(0.1), "use `stick`"},
      {"stick", SlopeScene(0.3, 1), Slope(0.6), "use `slide`"},
      {"stick", SlopeScene(0.3, 10),
       [](plan::Scene& scene) {
         Slope(0.6)(scene);
         SetGroup(scene, "aspect", schema::Ratio{{1, 3, 1}});
       },
       "would tip over"},
  });
}

TEST(Fit, SpinRefusesScenesWithAccelerationOrWalls) {
  ExpectRefusals({
      {"spin", SpinScene(), World("acceleration", kUp), "there is an acceleration; make it 0"},
      {"spin", SpinScene(), Group("angular_velocity", kNone), "does not spin"},
      {"spin", SpinScene(),
       [](plan::Scene& scene) {
         SetWorld(scene, "world.walls", Word("all"));
         SetGroup(scene, "linear_velocity", Vector3d(0, 0, 9));
       },
       "reaches the wall +z"},
  });
}

TEST(Fit, HeadOnRefusesScenesWithoutTwoBallsThatMeet) {
  ExpectRefusals({
      {"head_on", HeadOnScene(1, 1), World("acceleration", kUp), "there is an acceleration"},
      {"head_on", HeadOnScene(1, 1), Group("quantity", std::uint64_t{0}), "there are 1 objects"},
      {"head_on", HeadOnScene(1, 1), Group("linear_velocity", kOblique), "along the line of their"},
      {"head_on", HeadOnScene(1, 1), Group("linear_velocity", Vector3d(-2, 0, 0)),
       "do not come towards each other"},
      {"head_on", HeadOnScene(1, 1), [](plan::Scene& scene) { SetTime(scene, 0.1, 0.4); },
       "they meet after 0.5 s, and the run ends after 0.4 s"},
      {"head_on", HeadOnScene(1, 1),
       [](plan::Scene& scene) {
         SetWorld(scene, "world.walls", Word("all"));
         SetTime(scene, 1.0 / 60, 4);
       },
       "reaches the wall"},
  });
}

TEST(Fit, RollingRefusesScenesWithoutAPlateOnBalls) {
  ExpectRefusals({
      {"rolling", RollingScene(0.1), Group("type", Word("sphere"), 1), "there is no cuboid"},
      {"rolling", RollingScene(0.1), Group("quantity", std::uint64_t{0}), "there are no balls"},
      {"rolling", RollingScene(0.1), Group("rolling_friction", 0.1), "has rolling friction"},
      {"rolling", RollingScene(0.1), Group("type", Word("cone")), "is not a ball"},
      {"rolling", RollingScene(0.1), Group("mass", Uniform(1.0, 2.0)),
       "differs from the other balls"},
      {"rolling", RollingScene(0.1), Slope(0), "straight down; tilt it"},
      {"rolling", RollingScene(0.1), Group("friction", 0.0), "slip on the plate"},
      {"rolling", RollingScene(0.1), Group("friction", 0.01), "slip on the plate"},
      {"rolling", RollingScene(0.1),
       [](plan::Scene& scene) {
         SetGroup(scene, "friction", 0.05);
         SetGroup(scene, "friction", 100.0, 1);
         Slope(0.2)(scene);
       },
       "slip on the floor"},
      {"rolling", RollingScene(0.1), [](plan::Scene& scene) { SetTime(scene, 1.0 / 60, 10); },
       "is not under the plate from start to end"},
      {"rolling", RollingScene(0.1),
       [](plan::Scene& scene) {
         SetGroup(scene, "location", At(-5, -19.5 + kHair, 0));
         SetGroup(scene, "quantity", std::uint64_t{1});
       },
       "would tip off the balls"},
  });
}

TEST(Fit, StackRefusesScenesWithoutAColumn) {
  ExpectRefusals({
      {"stack", StackScene(3), Slope(0.1), "not straight down"},
      {"stack", StackScene(4),
       Group("location", Layout("stack", {{"height", std::uint64_t{2}}, {"gap", kHair}})),
       "not in one column"},
      {"stack", StackScene(3), Group("location", Layout("stack", {{"gap", 0.1}})),
       "is 0.1 m above what it should stand on"},
      {"stack", StackScene(3), Group("angular_velocity", kX), "spins"},
  });
}

TEST(Fit, LinksAreOfSpringAndPendulum) {
  ExpectRefusals({
      {"flight", FlightScene(), Group("links.type", Word("ball")), "the objects are linked"},
      {"spring", SpringScene(0), Group("links.type", Word("none")),
       "links.type of the objects is none; make it spring"},
      {"spring", SpringScene(0), World("acceleration", Vector3d(1, -9.8, 0)), "not both along"},
      {"spring", SpringScene(0), World("acceleration", kNone), "nothing swings"},
      {"spring", SpringScene(0),
       [](plan::Scene& scene) {
         SetWorld(scene, "world.walls", Word("floor"));
         SetWorld(scene, "world.side", 0.9);
       },
       "reaches the wall -y"},
      {"pendulum", PendulumScene(1), Group("links.type", Word("spring")), "make it ball or hinge"},
      {"pendulum", PendulumScene(1), Group("links.anchor", false), "hangs from nothing"},
      {"pendulum", PendulumScene(1), Slope(0), "hangs at rest"},
      {"pendulum", PendulumScene(1), Group("linear_velocity", kX), "moves at the start"},
      {"pendulum", PendulumScene(1),
       [](plan::Scene& scene) {
         SetGroup(scene, "aspect", schema::Ratio{{1, 10, 2}});
         SetWorld(scene, "acceleration", Vector3d(3, -9, 2));
       },
       "its own axes"},
  });
}

TEST(Fit, BrakingRefusesScenesWithoutABoxThatSlides) {
  ExpectRefusals({
      {"braking", BrakingScene(), Slope(0.1), "not straight down"},
      {"braking", BrakingScene(), Group("friction", 0.0), "nothing stops the box"},
      {"braking", BrakingScene(), Group("linear_velocity", kNone), "does not move"},
      {"braking", BrakingScene(), Group("linear_velocity", kOblique), "not move along the floor"},
      {"braking", BrakingScene(), Group("friction", 8.0), "would tip over"},
      {"braking", BrakingScene(), Group("location", At(0, 0, 0)), "above what it should stand on"},
  });
}

TEST(Fit, RollAndBowlRefuseScenesWithoutABallOnTheFloor) {
  ExpectRefusals({
      {"roll", RollScene(0.5, 1), Slope(0), "straight down; tilt it"},
      {"roll", RollScene(0.5, 1), Group("type", Word("cone")), "is not a ball"},
      {"roll", RollScene(0.5, 1), Group("rolling_friction", 0.1), "has rolling friction"},
      {"roll", RollScene(0.5, 1), Group("angular_velocity", kX), "spins"},
      {"bowl", BowlScene(), Slope(0.1), "not straight down"},
      {"bowl", BowlScene(), Group("angular_velocity", kUp), "spins about the vertical"},
      {"bowl", BowlScene(), Group("friction", 0.0), "never begins to roll"},
      {"bowl", BowlScene(), [](plan::Scene& scene) { SetTime(scene, 0.1, 1); },
       "rolls after 1.02 s, and the run ends after 1 s"},
  });
}

TEST(Fit, ObliqueAndFlipRefuseWhatNeverHappens) {
  ExpectRefusals({
      {"oblique", ObliqueScene(1), World("acceleration", kUp), "there is an acceleration"},
      {"oblique", ObliqueScene(1), Group("linear_velocity", kX), "there is no wall in the path of"},
      {"oblique", ObliqueScene(1), [](plan::Scene& scene) { SetTime(scene, 0.1, 0.4); },
       "meets a wall after 0.5 s, and the run ends after 0.4 s"},
      {"oblique", ObliqueScene(1),
       [](plan::Scene& scene) {
         SetWorld(scene, "world.walls", Word("all"));
         SetTime(scene, 0.1, 3);
       },
       "reaches the wall +x"},
      {"flip", FlipScene(), Group("angular_velocity", Vector3d(3, 0.1, 0)), "its middle axis"},
      {"flip", FlipScene(), Group("angular_velocity", Vector3d(0, 3, 0)), "never turns over"},
      {"flip", FlipScene(), Group("aspect", schema::Ratio{{1, 1, 2}}), "its middle axis"},
      {"flip", FlipScene(), [](plan::Scene& scene) { SetTime(scene, 0.1, 1); },
       "and the run ends after 1 s"},
  });
}

}  // namespace
}  // namespace cdb::tests
