// Settings that refer to others which are drawn for each object: `mass 2 * size ^ 3`.
#include "compiler/evaluate/convert.h"

#include <gtest/gtest.h>

#include "compiler/schema/formula.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

/// `objects.NAME` of the only run, as in the plan and as read back from it; or the error.
std::string Setting(schema::GroupParameter parameter, const std::string& objects,
                    const std::string& lets = {}) {
  const compiler::Compilation result =
      CompileText(lets + "\nbenchmark b { timestep 1e-6; objects { " + objects + " } }");
  if (result.plans.empty()) return dsl::Render(result.diagnostics);
  const plan::Plan& plan = result.plans[0];
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(plan), "plan"), plan);
  return schema::ToText(plan.runs[0].scene.groups[0].settings.Get(parameter));
}

constexpr const char* kSize = "size same(uniform(1, 5)); ";

TEST(DrawnSettings, MakeFormulae) {
  const auto mass = [](const std::string& value) {
    return Setting("mass", kSize + ("mass " + value));
  };
  EXPECT_EQ(mass("2 * size ^ 3"), "2 * size ^ 3");
  EXPECT_EQ(mass("size"), "size");
  EXPECT_EQ(mass("2 * 3 * size"), "6 * size");
  EXPECT_EQ(mass("size * (2 + size) / (2 * size)"), "size * (2 + size) / (2 * size)");
  EXPECT_EQ(mass("5 - (size - 2)"), "5 - (size - 2)");
  EXPECT_EQ(mass("(size ^ 2) ^ size"), "(size ^ 2) ^ size");
  EXPECT_EQ(mass("max(0.1, sqrt(size) - 1)"), "max(0.1, sqrt(size) - 1)");
  EXPECT_EQ(mass("5 + -size"), "5 + -size");
  EXPECT_EQ(mass("objects.size"), "size");
  EXPECT_EQ(mass("density(1000 + 10 * size)"), "density(1000 + 10 * size)");
  EXPECT_EQ(Setting("mass", kSize + std::string("mass m"), "let k = 2\nlet m = k * 3"), "6");
  EXPECT_EQ(Setting("mass", kSize + std::string("let v = size ^ 3; mass 2 * v")), "2 * size ^ 3");
  EXPECT_EQ(Setting("friction", "mass uniform(1, 2); size mass; friction 0.1 * size"),
            "0.1 * size");
  EXPECT_EQ(Setting("size", "mass uniform(1, 2); size same(mass)"), "same(mass)");
}

TEST(DrawnSettings, AreConstantsWhereTheyNameConstants) {
  EXPECT_EQ(Setting("mass", "size 2; mass 2 * size ^ 3"), "16");
}

TEST(DrawnSettings, HaveNoStreamOfTheirOwn) {
  const compiler::Compilation result =
      CompileText("benchmark b { objects { size same(uniform(1, 5)); mass 2 * size } }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  EXPECT_FALSE(result.plans[0].runs[0].scene.seeds.contains("objects.mass"));
}

TEST(DrawnSettings, OfASweepTheAxisHasTheNumbers) {
  const compiler::Compilation result = CompileText(
      "benchmark b { objects { size same(uniform(1, 5)); mass sweep(2, 4) * size; "
      "friction sweep(0.1 * size, 0.2) } }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  const plan::Plan& plan = result.plans[0];
  ASSERT_EQ(plan.runs.size(), 4u);
  EXPECT_EQ(plan.axes[0].values, (std::vector<plan::Coordinate>{2.0, 4.0}));
  EXPECT_EQ(plan.axes[0].unit, "") << "factors, and no masses";
  EXPECT_EQ(plan.axes[1].values, (std::vector<plan::Coordinate>{"0.1 * size", "0.2"}));
  EXPECT_EQ(schema::ToText(plan.runs[2].scene.groups[0].settings.Get("mass")), "4 * size");
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(plan), "plan"), plan);
}

TEST(DrawnSettings, HaveUnits) {
  const auto mass = [](const std::string& value) {
    return Setting("mass", kSize + ("mass " + value));
  };
  EXPECT_EQ(mass("2.7 g/cm^3 * size ^ 3"), "2700 * size ^ 3");
  EXPECT_EQ(mass("pi / 6 * size ^ 3 * (2 kg/m^3)"), "0.5235987755982988 * size ^ 3 * 2");
  EXPECT_NE(mass("2 kg * size").find("'mass' is a mass, but this is in kg m"), std::string::npos);
  EXPECT_NE(mass("size + 1 kg").find("this is a length, but the value beside it is a mass"),
            std::string::npos);
  EXPECT_NE(mass("(2 * size) kg").find("this already has a unit: it is a length"),
            std::string::npos);
}

// Each name refers twice to the one before.
TEST(DrawnSettings, AreNotTooLong) {
  std::string lets = "let a0 = size";
  for (int i = 1; i <= 40; ++i) {
    const std::string before = "a" + std::to_string(i - 1);
    lets += "; let a" + std::to_string(i) + " = " + before + " + " + before;
  }
  EXPECT_NE(Setting("mass", kSize + lets + "; mass a40")
                .find("an expression of drawn values or variables has at most 200"),
            std::string::npos);
}

TEST(DrawnSettings, FormulaeOfPlansAreChecked) {
  const compiler::Compilation result =
      CompileText("benchmark b { objects { size same(uniform(1, 5)); mass 2 * size ^ 3 } }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  const std::string yaml = yaml::ToYaml(result.plans[0]);
  const std::string formula = "[\"*\", 2, [\"^\", size, 3]]";
  const std::size_t at = yaml.find(formula);
  ASSERT_NE(at, std::string::npos) << yaml;
  const auto refusal = [&](const std::string& other) -> std::string {
    std::string changed = yaml;
    changed.replace(at, formula.size(), other);
    try {
      yaml::FromYaml(changed, "plan");
    } catch (const yaml::PlanError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal("[\"%\", 2, size]").find("an operator or a function"), std::string::npos);
  EXPECT_NE(refusal("[\"*\", 2, type]").find("`type` is not a drawn number"), std::string::npos);
  EXPECT_NE(refusal("[\"*\", 2, nothing]").find("`nothing` is not a finite number"),
            std::string::npos);
  EXPECT_NE(refusal("[\"*\", 2, 3]").find("a formula must name"), std::string::npos);
  EXPECT_NE(refusal("[\"*\", 3, size]").find("was changed by hand"), std::string::npos);
}

// Lints consider the smallest and the largest object.
TEST(DrawnSettings, LintsKnowTheirBounds) {
  const auto warnings = [](const std::string& size) {
    return dsl::Render(CompileText("benchmark b { timestep 1e-3; cycles 10; world.side 1000\n"
                                   "objects { mass uniform(1, 2); size " +
                                   size + " } }")
                           .diagnostics);
  };
  EXPECT_EQ(warnings("0.05 * mass"), warnings("same(uniform(0.05, 0.1))"));
}

}  // namespace
}  // namespace cdb::tests
