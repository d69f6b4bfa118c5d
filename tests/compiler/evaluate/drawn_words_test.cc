// `same( )` and `density( )` in scenarios and plans.
#include <gtest/gtest.h>

#include <algorithm>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/catalogue_table.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

TEST(DrawnWords, PlansHoldThemAndReadThemBack) {
  const compiler::Compilation result = CompileText(
      "benchmark b { objects { size same(uniform(1, sweep(5, 6)) cm); mass density(2.7 g/cm^3) }\n"
      "objects sand { size same(any(1, 2)); mass density(normal(2000, 100)) } }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  const plan::Plan& plan = result.plans[0];
  const plan::GroupSettings& settings = plan.runs[0].scene.groups[0].settings;
  EXPECT_EQ(schema::ToText(settings.Get("size")), "same(uniform(0.01, 0.05))");
  EXPECT_EQ(schema::ToText(settings.Get("mass")), "density(2700)");
  EXPECT_TRUE(plan.runs[0].scene.seeds.contains("objects.size"));
  EXPECT_TRUE(plan.runs[0].scene.seeds.contains("sand.mass"));
  EXPECT_FALSE(plan.runs[0].scene.seeds.contains("objects.mass"));
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(plan), "plan"), plan);
}

// One draw for all sides does not make thin shapes.
TEST(DrawnWords, SameIsNoElongation) {
  const auto thin_shapes = [](const std::string& size) {
    const compiler::Compilation result =
        CompileText("benchmark b { timestep 1e-6; objects { type cuboid; size " + size + " } }");
    return dsl::Render(result.diagnostics).find(" thin-shape]") != std::string::npos;
  };
  EXPECT_TRUE(thin_shapes("log_uniform(1, 100)"));
  EXPECT_FALSE(thin_shapes("same(log_uniform(1, 100))"));
}

std::ptrdiff_t EllipsoidWarnings(const std::string& objects) {
  const compiler::Compilation result =
      CompileText("benchmark b { world.side 1000; objects { " + objects + " } }");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return std::ranges::count_if(result.diagnostics.all(), [](const dsl::Diagnostic& diagnostic) {
    return diagnostic.kind == &scenario::kEllipsoids;
  });
}

TEST(DrawnWords, SpheresThatBecomeEllipsoidsAreWarnedOf) {
  EXPECT_EQ(EllipsoidWarnings("size uniform(1, 5)"), 1);
  EXPECT_EQ(
      EllipsoidWarnings("type sweep(sphere, cuboid); size sweep(normal(5, 1), uniform(1, 5))"), 2);
  EXPECT_EQ(EllipsoidWarnings("size same(uniform(1, 5))"), 0);
  EXPECT_EQ(EllipsoidWarnings("size 5"), 0);
  EXPECT_EQ(EllipsoidWarnings("type cuboid; size uniform(1, 5)"), 0);
  EXPECT_EQ(EllipsoidWarnings("type any(sphere, cuboid); size uniform(1, 5)"), 0);
}

// Golden files would change with each new type.
TEST(Types, AreListedFromTheTableWhereAnotherKindIsWritten) {
  for (const auto& [value, help] : {std::pair("normal(0, 1)", "any(…) draws from a list"),
                                    {"\"rock.obj\"", "write mesh(\"rock.obj\")"}}) {
    const compiler::Compilation result =
        CompileText(std::string("benchmark b { objects.type ") + value + " }");
    const std::string text = dsl::Render(result.diagnostics);
    for (const schema::ObjectType& type : schema::kObjectTypeTable)
      EXPECT_NE(text.find(" " + std::string(type.name) + ","), std::string::npos) << text;
    EXPECT_NE(text.find(help), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace cdb::tests
