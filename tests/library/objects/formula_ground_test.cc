#include "library/objects/formula_ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "compiler/schema/formula.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/exact/signed_distance.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

std::string Scene(const std::string& type) {
  return "benchmark b { cycles 1; objects ground { quantity 1; size native; mass fixed; "
         "location at(1, 2, 3); type " +
         type + " } }\n";
}

/// The type as the plan has it; the diagnostics if there is none.
std::pair<schema::Value, std::string> TypeOf(const std::string& type) {
  compiler::Compilation compiled = CompileText(Scene(type));
  std::string messages;
  for (const auto& message : compiled.diagnostics.all()) messages += message.message + "\n";
  if (compiled.plans.empty()) return {schema::Word{"none"}, messages};
  return {compiled.plans[0].runs[0].scene.groups[0].settings.Get("type"), messages};
}

objects::Solid SolidOf(const std::string& type) {
  objects::SolidFactory solids;
  return solids.Make(TypeOf(type).first, Vector3d::Zero(), Vector3d::Ones());
}

/// The distance of a small ball from the ground, which is placed by its origin.
double GapAt(const objects::Solid& ground, const Vector3d& place) {
  const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(1e-3)};
  return exact::DistanceOf(ball, {place, Eigen::Quaterniond::Identity()}, ground,
                           objects::BodyOf(ground, {}))
             .gap +
         0.5e-3;
}

TEST(FormulaGround, HeightsAreThoseOfTheFormulaAtItsOrigin) {
  const objects::Solid ground = SolidOf("height(0.25 * x + 1, width: 4, depth: 6, cell: 0.5)");
  ASSERT_TRUE(ground.IsSurface());
  EXPECT_TRUE(ground.sides.isApprox(Vector3d(4, 1, 6), 1e-12));
  const double slope = 1 / std::hypot(1, 0.25);
  for (const double x : {-1.3, 0.0, 1.7})
    EXPECT_NEAR(GapAt(ground, Vector3d(x, 0.25 * x + 1 + 0.1, 0.7)), 0.1 * slope, 1e-9);
  EXPECT_EQ(ground.compound->form().points_compared, 8u * 12 * 2 * 7);
  EXPECT_LT(ground.compound->form().deviation, 1e-12);
}

TEST(FormulaGround, TheZeroSetIsThatOfTheFormulaAtItsOrigin) {
  const objects::Solid ground = SolidOf(
      "implicit(sqrt((x - 1)^2 + y^2 + z^2) - 1, lower: (-0.5, -1.2, -1.2), upper: (2.2, 1.2, "
      "1.2), cell: 0.15)");
  ASSERT_TRUE(ground.IsSurface());
  const double deviation = ground.compound->form().deviation;
  EXPECT_GT(deviation, 1e-4);
  EXPECT_LT(deviation, 0.01);
  for (const Vector3d& way : {Vector3d(1, 2, 3), Vector3d(-3, 1, 1), Vector3d(0, -1, 0.1)})
    EXPECT_NEAR(GapAt(ground, Vector3d(1, 0, 0) + 1.2 * way.normalized()), 0.2, deviation);
}

TEST(FormulaGround, TakesLetsAndSweepsInItsFormula) {
  const compiler::Compilation compiled = CompileText(
      "benchmark b { cycles 1; let high = sweep(0.1, 0.2); objects ground { quantity 1; size "
      "native; "
      "mass fixed; type height(high * sin(pi * x), width: 4, cell: 0.5) } }\n");
  ASSERT_EQ(compiled.plans.size(), 1u);
  ASSERT_EQ(compiled.plans[0].runs.size(), 2u);
  EXPECT_EQ(schema::ToText(compiled.plans[0].runs[1].scene.groups[0].settings.Get("type")),
            "height(0.2 * sin(3.141592653589793 * x), 4, 0.5)");
}

TEST(FormulaGround, StaysTheSameInAPlan) {
  const compiler::Compilation compiled = CompileText(Scene(
      "implicit(-max(x, y) ^ 2 + 1e-3 * z, lower: (-1, -1, -1), upper: (1, 1, 1), cell: 0.5)"));
  ASSERT_EQ(compiled.plans.size(), 1u);
  const plan::Plan read = yaml::FromYaml(yaml::ToYaml(compiled.plans[0]), "plan");
  EXPECT_EQ(read.runs[0].scene.groups[0].settings.Get("type"),
            compiled.plans[0].runs[0].scene.groups[0].settings.Get("type"));
}

TEST(FormulaGround, IsRefusedInWords) {
  const auto message = [](const std::string& type) { return TypeOf(type).second; };
  EXPECT_EQ(message("height(0.1 * y, width: 4, cell: 0.5)"), "no let is called 'y'\n");
  EXPECT_EQ(message("height(wave, width: 4, cell: 0.5)"), "'formula' cannot be 'wave'\n");
  EXPECT_EQ(message("height(uniform(0, 1), width: 4, cell: 0.5)"),
            "'formula' has one value in a run and cannot be drawn\n");
  const auto cause = [](const std::string& type) -> std::string {
    try {
      SolidOf(type);
    } catch (const library::SceneError& error) {
      return error.cause();
    }
    return "no error";
  };
  EXPECT_EQ(cause("implicit(y - 9, lower: (-1, -1, -1), upper: (1, 1, 1), cell: 1)"),
            "the formula is negative at all 27 points of its grid, so that it has no surface in "
            "the box");
  EXPECT_EQ(cause("implicit(y, lower: (-1, 1, -1), upper: (1, 1, 1), cell: 1)"),
            "lower is not below upper along each axis");
}

TEST(FormulaProgram, IsTheFormula) {
  const schema::Value type =
      TypeOf("height(-max(x, 2 * z - 1) ^ 2 / 3 + abs(z), width: 4, cell: 0.5)").first;
  const schema::Value& formula = schema::ArgumentOf(*schema::AsCall(type), "formula");
  constexpr std::array<std::string_view, 2> kNames = {"z", "x"};
  schema::FormulaProgram program(formula, kNames);
  for (const double x : {-2.0, 0.3, 5.0})
    for (const double z : {-1.0, 0.7}) {
      const double most = std::max(x, 2 * z - 1);
      const std::array<double, 2> values = {z, x};
      // A sign binds more tightly than a power.
      EXPECT_DOUBLE_EQ(program(values), most * most / 3 + std::abs(z));
    }
}

}  // namespace
}  // namespace cdb::tests
