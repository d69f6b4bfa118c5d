// Measures of the box around the objects of a group: `part.extent.x`, and chains of settings of
// several groups.
#include <gtest/gtest.h>

#include <string>

#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// The velocity of `at`, a group of its own, whose expression is `text`.
Vector3d Measured(const std::string& part, const std::string& text) {
  const auto result =
      CompileText("benchmark b { objects part { quantity 1; " + part +
                      " } objects at { quantity 1; linear_velocity " + text + " } }",
                  {{"plate.obj", "v 0 0 0"}});
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  if (result.plans.empty()) return Vector3d::Zero();
  return std::get<Vector3d>(
      result.plans[0].runs[0].scene.groups[1].settings.Get("linear_velocity"));
}

TEST(Measures, OfClosedFormsAreThoseOfTheirBox) {
  EXPECT_EQ(Measured("size 4; aspect 1 : 2 : 3", "part.extent"), Vector3d(4, 8, 12));
  EXPECT_EQ(Measured("size 4", "(part.lower.x, part.upper.y, 2 * part.extent.z)"),
            Vector3d(-2, 2, 8));
  // The centre of mass of a cone is a quarter of its height above the base.
  EXPECT_EQ(Measured("size 4; type cone", "part.lower"), Vector3d(-2, -1, -2));
  EXPECT_EQ(Measured("size 4; type cone", "part.upper"), Vector3d(2, 3, 2));
  EXPECT_EQ(Measured("", "part.extent"), Vector3d(50, 50, 50)) << "the default size";
  EXPECT_EQ(Measured("size 5 cm", "part.extent"), Vector3d(0.05, 0.05, 0.05));
}

TEST(Measures, OfMeshesFollowTheirFile) {
  const std::string plate = "type mesh(\"plate.obj\"); ";
  EXPECT_EQ(Measured(plate + "size native", "part.extent"), Vector3d(2, 1, 0.5));
  EXPECT_EQ(Measured(plate + "size 6", "part.extent"), Vector3d(6, 3, 1.5)) << "its longest side";
  EXPECT_EQ(Measured(plate + "size 6; aspect 1 : 2 : 1", "part.extent"), Vector3d(6, 12, 6));
  EXPECT_EQ(Measured(plate + "size native", "part.lower"), Vector3d(0, 0, 0));
  EXPECT_EQ(Measured(plate + "size native", "part.upper"), Vector3d(2, 1, 0.5));
}

TEST(Measures, FollowSweepsAndNeedNoNameInTheirOwnGroup) {
  const auto result = CompileText(
      "benchmark b { objects { quantity 1; size sweep(1, 3); aspect sweep(1 : 1 : 1, 1 : 2 : 1)\n"
      "location at(0, lower.y, 0) } world.side 10 * extent.y }");
  ASSERT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  const auto& runs = result.plans.at(0).runs;
  ASSERT_EQ(runs.size(), 4u);
  const double heights[] = {1, 2, 3, 6};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const plan::GroupSettings& settings = runs[i].scene.groups[0].settings;
    const schema::Call* at = schema::AsCall(settings.Get("location"));
    EXPECT_EQ(schema::AsNumber(schema::ArgumentOf(*at, "y"))->AsReal(), -heights[i] / 2);
    EXPECT_EQ(runs[i].scene.world.Real("world.side"), 10 * heights[i]);
  }
}

TEST(Measures, ALetOrAGroupOfThatNameComesFirst) {
  EXPECT_EQ(Measured("let extent = 7; size 1; location at(0, extent, 0)", "(part.extent.x, 0, 0)"),
            Vector3d(1, 0, 0));
}

TEST(Settings, OfSeveralGroupsMayFollowOneAnother) {
  const auto result = CompileText(
      "benchmark b { objects a { size 2 * b.size } objects b { size 2 * c.size }\n"
      "objects c { size 3 } }");
  ASSERT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans[0].runs[0].scene.groups[0].settings.Real("size"), 12);
  const auto circle = CompileText(
      "benchmark b { objects a { size 2 * b.size } objects b { size 2 * c.size }\n"
      "objects c { size a.size } }");
  EXPECT_TRUE(circle.diagnostics.has_errors());
}

}  // namespace
}  // namespace cdb::tests
