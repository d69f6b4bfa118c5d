#include "library/distributions/draw.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "library/layouts/initial_state.h"
#include "tests/library/test_scene.h"

namespace cdb::library {
namespace {

using compiler::Distribution;
using compiler::DistributionKind;
using compiler::Value;
using Eigen::Vector3d;
using test::DefaultScene;
using test::SetGroup;
using test::SetWorld;

Draw GroupDraw(const compiler::Scene& scene, std::string_view name) {
  return Draw(scene, &scene.groups[0], name);
}

TEST(Draw, ConstantsGiveThemselves) {
  const compiler::Scene scene = DefaultScene(1, 500);
  EXPECT_EQ(GroupDraw(scene, "size").Real(), 50);
  EXPECT_EQ(GroupDraw(scene, "type").Choice(), test::Word("sphere"));
  EXPECT_FALSE(GroupDraw(scene, "ccd").On());
  EXPECT_EQ(Draw(scene, nullptr, "acceleration").Vector(), Vector3d(0, -9.8, 0));
  std::string_view word;
  EXPECT_FALSE(GroupDraw(scene, "contact_stiffness").RealOrWord(&word).has_value());
  EXPECT_EQ(word, "rigid");
}

TEST(Draw, NormalHasItsMeanAndStandardDeviation) {
  compiler::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "friction", test::Normal(275.0, 75.0));
  Draw draw = GroupDraw(scene, "friction");
  constexpr int kDraws = 100000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw.Real();
    sum += x;
    squares += (x - 275) * (x - 275);
  }
  // Five standard deviations; 275/75 leaves 1.2e-4 of the distribution out, which moves the mean by
  // less than 75 phi(3.67) = 0.04.
  EXPECT_NEAR(sum / kDraws, 275, 5 * 75 / std::sqrt(1.0 * kDraws) + 0.04);
  EXPECT_NEAR(std::sqrt(squares / kDraws), 75, 5 * 75 / std::sqrt(2.0 * kDraws) + 0.1);
}

TEST(Draw, WhatIsOutsideTheDomainIsDrawnAgain) {
  compiler::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", test::Normal(1.0, 10.0));
  SetGroup(scene, "restitution", test::Uniform(-1.0, 2.0));
  Draw size = GroupDraw(scene, "size"), restitution = GroupDraw(scene, "restitution");
  for (int i = 0; i < 10000; ++i) {
    EXPECT_GT(size.Real(), 0);
    const double kept = restitution.Real();
    EXPECT_GE(kept, 0);
    EXPECT_LE(kept, 1);
  }
}

TEST(Draw, GivesUpWhereNothingIsInTheDomain) {
  compiler::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", test::Normal(-500.0, 1.0));
  try {
    GroupDraw(scene, "size").Real();
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("objects.size normal(-500, 1)"), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("more than 0"), std::string::npos) << error.what();
  }
}

TEST(Draw, AnyKeepsToItsWeights) {
  compiler::Scene scene = DefaultScene(1, 500);
  SetGroup(
      scene, "type",
      Distribution{DistributionKind::kAny, {test::Word("sphere"), test::Word("cone")}, {3, 1}});
  Draw draw = GroupDraw(scene, "type");
  constexpr int kDraws = 100000;
  int spheres = 0;
  for (int i = 0; i < kDraws; ++i) spheres += draw.Choice() == test::Word("sphere");
  EXPECT_NEAR(spheres, 0.75 * kDraws, 5 * std::sqrt(0.75 * 0.25 * kDraws));
}

TEST(Draw, VectorsAreDrawnComponentByComponent) {
  compiler::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "linear_velocity", test::Uniform(Vector3d(-1, 10, 100), Vector3d(1, 20, 200)));
  SetGroup(scene, "angular_velocity", test::Uniform(5.0, 6.0));
  Draw linear = GroupDraw(scene, "linear_velocity");
  Draw angular = GroupDraw(scene, "angular_velocity");
  for (int i = 0; i < 1000; ++i) {
    const Vector3d v = linear.Vector(), w = angular.Vector();
    EXPECT_TRUE((v.array() >= Vector3d(-1, 10, 100).array()).all());
    EXPECT_TRUE((v.array() < Vector3d(1, 20, 200).array()).all());
    EXPECT_TRUE((w.array() >= 5).all() && (w.array() < 6).all());
    EXPECT_NE(w.x(), w.y());
  }
}

TEST(Draw, AScheduleDrawsOnAndOn) {
  using compiler::Call;
  compiler::Scene scene = DefaultScene(1, 500);
  const Value range = test::Uniform(Vector3d(-1, 10, 100), Vector3d(1, 20, 200));
  SetGroup(scene, "linear_velocity", range);
  Draw plain = GroupDraw(scene, "linear_velocity");
  const Vector3d first = plain.Vector(), second = plain.Vector();
  SetGroup(scene, "linear_velocity", Call{"every", {std::uint64_t{60}, range}});
  Draw scheduled = GroupDraw(scene, "linear_velocity");
  EXPECT_EQ(scheduled.Vector(), first);
  EXPECT_EQ(scheduled.Vector(), second);

  SetGroup(scene, "angular_velocity",
           Call{"rotating", {Vector3d(1, 2, 3), Vector3d(0, 0, 1), 4.0}});
  EXPECT_EQ(GroupDraw(scene, "angular_velocity").Vector(), Vector3d(1, 2, 3));
  SetWorld(scene, "acceleration", Call{"every", {std::uint64_t{1}, Vector3d(4, 5, 6)}});
  EXPECT_EQ(Draw(scene, nullptr, "acceleration").Vector(), Vector3d(4, 5, 6));
}

TEST(Draw, AChoiceIsAWordOrAModel) {
  compiler::Scene scene = DefaultScene(1, 500);
  EXPECT_EQ(GroupDraw(scene, "type").Choice(), test::Word("sphere"));
  const Value rock = compiler::Call{"mesh", {compiler::Text{"rock.obj"}, compiler::Text{"00"}}};
  SetGroup(scene, "type", rock);
  EXPECT_EQ(GroupDraw(scene, "type").Choice(), rock);
  SetGroup(scene, "type", Distribution{DistributionKind::kAny, {test::Word("cone"), rock}, {1, 1}});
  Draw draw = GroupDraw(scene, "type");
  int rocks = 0;
  for (int i = 0; i < 1000; ++i) rocks += draw.Choice() == rock;
  EXPECT_NEAR(rocks, 500, 80);  // five standard deviations
}

TEST(Draw, EveryParameterHasAStreamOfItsOwn) {
  compiler::Scene scene = DefaultScene(50, 5000);
  const auto sizes = [&] {
    std::vector<double> all;
    for (const ObjectState& object : DrawObjects(scene).objects)
      all.push_back(object.solid.sides.x());
    return all;
  };
  SetGroup(scene, "size", test::Uniform(10.0, 50.0));
  const auto before = sizes();
  SetGroup(scene, "mass", test::Uniform(1.0, 2.0));
  SetGroup(scene, "linear_velocity", test::Normal(0.0, 1.0));
  EXPECT_EQ(sizes(), before);
  test::SeedStreams(scene, 1);
  EXPECT_NE(sizes(), before);
}

TEST(Draw, NeedsTheSeedOfItsStream) {
  compiler::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", test::Uniform(10.0, 50.0));
  scene.seeds.erase("objects.size");
  EXPECT_THROW(GroupDraw(scene, "size"), SceneError);
}

TEST(DrawObjects, SidesAreSizeTimesAspect) {
  compiler::Scene scene = DefaultScene(20, 5000);
  SetGroup(scene, "aspect", compiler::Ratio{Vector3d(1, 2, 5)});
  for (const ObjectState& object : DrawObjects(scene).objects)
    EXPECT_EQ(object.solid.sides, Vector3d(50, 100, 250));
  // A distribution draws each side by itself.
  SetGroup(scene, "size", test::Uniform(10.0, 20.0));
  for (const ObjectState& object : DrawObjects(scene).objects) {
    EXPECT_NE(object.solid.sides.x() * 2, object.solid.sides.y());
    EXPECT_GE(object.solid.sides.z(), 50);
    EXPECT_LT(object.solid.sides.z(), 100);
  }
}

TEST(DrawObjects, FixedMassesAndMixedWords) {
  compiler::Scene scene = DefaultScene(1000, 500000);
  SetGroup(scene, "mass",
           Distribution{DistributionKind::kAny, {test::Word("fixed"), Value(3.0)}, {1, 1}});
  SetGroup(scene, "orientation",
           Distribution{
               DistributionKind::kAny, {test::Word("random"), Value(Vector3d(0, 1, 0))}, {1, 1}});
  std::map<bool, int> fixed;
  int turned = 0;
  for (const ObjectState& object : DrawObjects(scene).objects) {
    ++fixed[object.IsFixed()];
    EXPECT_TRUE(object.mass == 0 || object.mass == 3);
    turned += object.pose.orientation.isApprox(TurnAbout({0, 1, 0}));
  }
  // Five standard deviations of 1000 fair coins.
  EXPECT_NEAR(fixed[true], 500, 80);
  EXPECT_NEAR(turned, 500, 80);
}

TEST(DrawObjects, AccelerationIsDrawnOnceForTheWorld) {
  compiler::Scene scene = DefaultScene(1, 500);
  SetWorld(scene, "acceleration",
           test::Uniform(Vector3d(-250, -250, -250), Vector3d(250, 250, 250)));
  const Vector3d first = DrawObjects(scene).acceleration;
  EXPECT_LT(first.cwiseAbs().maxCoeff(), 250);
  EXPECT_NE(first, Vector3d::Zero());
  EXPECT_EQ(DrawObjects(scene).acceleration, first);
}

TEST(TurnAbout, IsTheRotationVector) {
  const Vector3d v(0.3, -0.7, 1.1);
  const Eigen::AngleAxisd expected(v.norm(), v.normalized());
  EXPECT_TRUE(TurnAbout(v).isApprox(Eigen::Quaterniond(expected), 1e-15));
  EXPECT_TRUE(TurnAbout(Vector3d::Zero()).isApprox(Eigen::Quaterniond::Identity(), 0));
}

}  // namespace
}  // namespace cdb::library
