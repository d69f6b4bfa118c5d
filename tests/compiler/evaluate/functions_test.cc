#include <gtest/gtest.h>

#include <cmath>

#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

/// `world.side` of the only run.
double SideOf(const std::string& value) {
  const compiler::Compilation result =
      CompileText("let n = 7 / 2; benchmark b { world.side " + value + " }");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.empty() ? -1 : result.plans[0].runs[0].scene.world.Real("world.side");
}

TEST(Functions, HaveTheirUsualValues) {
  EXPECT_EQ(SideOf("round(n)"), 4);
  EXPECT_EQ(SideOf("floor(n)"), 3);
  EXPECT_EQ(SideOf("ceil(n + 0.1)"), 4);
  EXPECT_EQ(SideOf("abs(-n)"), 3.5);
  EXPECT_EQ(SideOf("min(9, n, 4)"), 3.5);
  EXPECT_EQ(SideOf("max(1, n, 3)"), 3.5);
  EXPECT_EQ(SideOf("sqrt(2)"), std::sqrt(2.0));
  EXPECT_EQ(SideOf("10 * sin(pi / 6)"), 10 * std::sin(3.141592653589793 / 6));
  EXPECT_EQ(SideOf("2 + cos(180 deg)"), 1);
  EXPECT_EQ(SideOf("exp(2)"), std::exp(2.0));
  EXPECT_EQ(SideOf("log(exp(2))"), 2);
  EXPECT_EQ(SideOf("sqrt(4 m * 1 m)"), 2);
  EXPECT_EQ(SideOf("max(5 cm, 2 mm)"), 0.05);
}

TEST(Functions, RoundedNumbersAreCounts) {
  const compiler::Compilation result = CompileText(
      "benchmark b { objects.quantity round(10 ^ sweep(1 .. 3 count 5)); seed max(0, "
      "0xFFFFFFFFFFFFFFFF)\n"
      "skip when quantity > 100 * sqrt(pi) }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans[0].axes[0].values,
            (std::vector<plan::Coordinate>{10.0, 32.0, 100.0, 316.0, 1000.0}));
  EXPECT_EQ(result.plans[0].runs.size(), 3u);
  EXPECT_EQ(result.plans[0].runs[0].scene.world.Count("seed"), ~std::uint64_t{0});
}

TEST(Functions, LetsMayHaveTheirNames) {
  const compiler::Compilation result = CompileText(
      "let pi = 3; let max = 4; let gamma = 2\n"
      "benchmark b { world.side max(pi, max) + gamma }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans[0].runs[0].scene.world.Real("world.side"), 6);
}

}  // namespace
}  // namespace cdb::tests
