#include "library/distributions/draw.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "library/layouts/initial_state.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::Distribution;
using schema::DistributionKind;
using schema::Value;

distributions::Draw GroupDraw(const plan::Scene& scene,
                              schema::ParameterRef<true, schema::ValueKind::kDrawn> parameter) {
  return distributions::Draw(scene, scene.groups[0], parameter);
}

TEST(Draw, ConstantsGiveThemselves) {
  const plan::Scene scene = DefaultScene(1, 500);
  EXPECT_EQ(GroupDraw(scene, "size").Real(), 50);
  EXPECT_EQ(GroupDraw(scene, "type").Choice(), Word("sphere"));
  EXPECT_FALSE(GroupDraw(scene, "ccd").On());
  EXPECT_EQ(distributions::Draw(scene, "acceleration").Vector(), Vector3d(0, -9.8, 0));
  std::string_view word;
  EXPECT_FALSE(GroupDraw(scene, "contact_stiffness").RealOrWord(&word).has_value());
  EXPECT_EQ(word, "rigid");
}

TEST(Draw, NormalHasItsMeanAndStandardDeviation) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "friction", Normal(275.0, 75.0));
  distributions::Draw draw = GroupDraw(scene, "friction");
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
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", Normal(1.0, 10.0));
  SetGroup(scene, "restitution", Uniform(-1.0, 2.0));
  distributions::Draw size = GroupDraw(scene, "size"),
                      restitution = GroupDraw(scene, "restitution");
  for (int i = 0; i < 10000; ++i) {
    EXPECT_GT(size.Real(), 0);
    const double kept = restitution.Real();
    EXPECT_GE(kept, 0);
    EXPECT_LE(kept, 1);
  }
}

TEST(Draw, GivesUpWhereNothingIsInTheDomain) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", Normal(-500.0, 1.0));
  try {
    GroupDraw(scene, "size").Real();
    FAIL();
  } catch (const library::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("objects.size normal(-500, 1)"), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("more than 0"), std::string::npos) << error.what();
  }
}

TEST(Draw, AnyKeepsToItsWeights) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "type",
           Distribution{DistributionKind::kAny, {Word("sphere"), Word("cone")}, {3, 1}});
  distributions::Draw draw = GroupDraw(scene, "type");
  constexpr int kDraws = 100000;
  int spheres = 0;
  for (int i = 0; i < kDraws; ++i) spheres += draw.Choice() == Word("sphere");
  EXPECT_NEAR(spheres, 0.75 * kDraws, 5 * std::sqrt(0.75 * 0.25 * kDraws));
}

TEST(Draw, VectorsAreDrawnComponentByComponent) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "linear_velocity", Uniform(Vector3d(-1, 10, 100), Vector3d(1, 20, 200)));
  SetGroup(scene, "angular_velocity", Uniform(5.0, 6.0));
  distributions::Draw linear = GroupDraw(scene, "linear_velocity");
  distributions::Draw angular = GroupDraw(scene, "angular_velocity");
  for (int i = 0; i < 1000; ++i) {
    const Vector3d v = linear.Vector(), w = angular.Vector();
    EXPECT_TRUE((v.array() >= Vector3d(-1, 10, 100).array()).all());
    EXPECT_TRUE((v.array() < Vector3d(1, 20, 200).array()).all());
    EXPECT_TRUE((w.array() >= 5).all() && (w.array() < 6).all());
    EXPECT_NE(w.x(), w.y());
  }
}

TEST(Draw, AScheduleDrawsOnAndOn) {
  using schema::Call;
  plan::Scene scene = DefaultScene(1, 500);
  const Value range = Uniform(Vector3d(-1, 10, 100), Vector3d(1, 20, 200));
  SetGroup(scene, "linear_velocity", range);
  distributions::Draw plain = GroupDraw(scene, "linear_velocity");
  const Vector3d first = plain.Vector(), second = plain.Vector();
  SetGroup(scene, "linear_velocity", Call{"every", {std::uint64_t{60}, range}});
  distributions::Draw scheduled = GroupDraw(scene, "linear_velocity");
  EXPECT_EQ(scheduled.Vector(), first);
  EXPECT_EQ(scheduled.Vector(), second);

  SetGroup(scene, "angular_velocity",
           Call{"rotating", {Vector3d(1, 2, 3), Vector3d(0, 0, 1), 4.0}});
  EXPECT_EQ(GroupDraw(scene, "angular_velocity").Vector(), Vector3d(1, 2, 3));
  SetWorld(scene, "acceleration", Call{"every", {std::uint64_t{1}, Vector3d(4, 5, 6)}});
  EXPECT_EQ(distributions::Draw(scene, "acceleration").Vector(), Vector3d(4, 5, 6));
}

TEST(Draw, AChoiceIsAWordOrAModel) {
  plan::Scene scene = DefaultScene(1, 500);
  EXPECT_EQ(GroupDraw(scene, "type").Choice(), Word("sphere"));
  const Value rock =
      Layout("mesh", {{"file", schema::Text{"rock.obj"}}, {"sha256", schema::Text{"00"}}});
  SetGroup(scene, "type", rock);
  EXPECT_EQ(GroupDraw(scene, "type").Choice(), rock);
  SetGroup(scene, "type", Distribution{DistributionKind::kAny, {Word("cone"), rock}, {1, 1}});
  distributions::Draw draw = GroupDraw(scene, "type");
  int rocks = 0;
  for (int i = 0; i < 1000; ++i) rocks += draw.Choice() == rock;
  EXPECT_NEAR(rocks, 500, 80);  // five standard deviations
}

TEST(Draw, EveryParameterHasAStreamOfItsOwn) {
  plan::Scene scene = DefaultScene(50, 5000);
  const auto sizes = [&] {
    std::vector<double> all;
    for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects)
      all.push_back(object.solid.sides.x());
    return all;
  };
  SetGroup(scene, "size", Uniform(10.0, 50.0));
  const auto before = sizes();
  SetGroup(scene, "mass", Uniform(1.0, 2.0));
  SetGroup(scene, "linear_velocity", Normal(0.0, 1.0));
  EXPECT_EQ(sizes(), before);
  SeedStreams(scene, 1);
  EXPECT_NE(sizes(), before);
}

TEST(Draw, NeedsTheSeedOfItsStream) {
  plan::Scene scene = DefaultScene(1, 500);
  SetGroup(scene, "size", Uniform(10.0, 50.0));
  scene.seeds.erase("objects.size");
  EXPECT_THROW(GroupDraw(scene, "size"), library::SceneError);
}

TEST(DrawObjects, SidesAreSizeTimesAspect) {
  plan::Scene scene = DefaultScene(20, 5000);
  SetGroup(scene, "aspect", schema::Ratio{Vector3d(1, 2, 5)});
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects)
    EXPECT_EQ(object.solid.sides, Vector3d(50, 100, 250));
  // A distribution draws each side independently.
  SetGroup(scene, "size", Uniform(10.0, 20.0));
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects) {
    EXPECT_NE(object.solid.sides.x() * 2, object.solid.sides.y());
    EXPECT_GE(object.solid.sides.z(), 50);
    EXPECT_LT(object.solid.sides.z(), 100);
  }
}

TEST(DrawObjects, FixedMassesAndMixedWords) {
  plan::Scene scene = DefaultScene(1000, 500000);
  SetGroup(scene, "mass",
           Distribution{DistributionKind::kAny, {Word("fixed"), Value(3.0)}, {1, 1}});
  SetGroup(
      scene, "orientation",
      Distribution{DistributionKind::kAny, {Word("random"), Value(Vector3d(0, 1, 0))}, {1, 1}});
  std::map<bool, int> fixed;
  int turned = 0;
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects) {
    ++fixed[object.IsFixed()];
    EXPECT_TRUE(object.mass == 0 || object.mass == 3);
    turned += object.pose.orientation.isApprox(layouts::TurnAbout({0, 1, 0}));
  }
  // Five standard deviations of 1000 fair coins.
  EXPECT_NEAR(fixed[true], 500, 80);
  EXPECT_NEAR(turned, 500, 80);
}

TEST(DrawObjects, AccelerationIsDrawnOnceForTheWorld) {
  plan::Scene scene = DefaultScene(1, 500);
  SetWorld(scene, "acceleration", Uniform(Vector3d(-250, -250, -250), Vector3d(250, 250, 250)));
  const Vector3d first = layouts::DrawObjects(scene).acceleration;
  EXPECT_LT(first.cwiseAbs().maxCoeff(), 250);
  EXPECT_NE(first, Vector3d::Zero());
  EXPECT_EQ(layouts::DrawObjects(scene).acceleration, first);
}

TEST(TurnAbout, IsTheRotationVector) {
  const Vector3d v(0.3, -0.7, 1.1);
  const Eigen::AngleAxisd expected(v.norm(), v.normalized());
  EXPECT_TRUE(layouts::TurnAbout(v).isApprox(Eigen::Quaterniond(expected), 1e-15));
  EXPECT_TRUE(layouts::TurnAbout(Vector3d::Zero()).isApprox(Eigen::Quaterniond::Identity(), 0));
}

}  // namespace
}  // namespace cdb::tests
