// Distributions in scenarios: their arguments, limits and tables.
#include <gtest/gtest.h>

#include <cmath>

#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using Files = std::map<std::string, std::string>;

/// `objects.size` of the only run, or the error.
std::string SizeOf(const std::string& value, const Files& files = {}) {
  const compiler::Compilation result =
      CompileText("benchmark b { objects.size " + value + " }", files);
  if (result.plans.empty()) return dsl::Render(result.diagnostics);
  const plan::Plan& plan = result.plans[0];
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(plan), "plan"), plan);
  return schema::ToText(plan.runs[0].scene.groups[0].settings.Get("size"));
}

TEST(Distributions, TakeArgumentsByPositionAndByName) {
  EXPECT_EQ(SizeOf("lognormal(0, 0.5)"), "lognormal(0, 0.5)");
  EXPECT_EQ(SizeOf("lognormal(median: 1, sigma: 0.5)"), "lognormal(0, 0.5)");
  EXPECT_EQ(SizeOf("exponential(5 cm)"), "exponential(0.05)");
  EXPECT_EQ(SizeOf("gamma(2, 5) cm"), "gamma(2, 0.05)");
  EXPECT_EQ(SizeOf("weibull(scale: 5 cm, shape: 2)"), "weibull(2, 0.05)");
}

TEST(Distributions, HaveLimits) {
  EXPECT_EQ(SizeOf("normal(5, 1) in 2 .. 8"), "normal(5, 1) in 2 .. 8");
  EXPECT_EQ(SizeOf("(normal(5, 1) in 2 .. 8) cm"), "normal(0.05, 0.01) in 0.02 .. 0.08");
  EXPECT_EQ(SizeOf("normal(5 cm, 1 cm) in 2 cm .. 8 cm"), "normal(0.05, 0.01) in 0.02 .. 0.08");
  EXPECT_EQ(SizeOf("same(gamma(2, 3) in 1 .. 9)"), "same(gamma(2, 3) in 1 .. 9)");
  const compiler::Compilation result =
      CompileText("benchmark b { objects.size normal(5, 1) in 2 .. sweep(6, 8) }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans[0].axes[0].values, (std::vector<plan::Coordinate>{6.0, 8.0}));
}

TEST(Distributions, TablesAreReadFromFiles) {
  EXPECT_EQ(SizeOf("empirical(\"a.csv\")", {{"a.csv", "1\n2.5\r\n\n# measured\n4"}}),
            "empirical(\"a.csv\", 1, 2.5, 4)");
  EXPECT_EQ(SizeOf("empirical(\"a.csv\") mm in 1 mm .. 3 mm", {{"a.csv", "1\n2\n4"}}),
            SizeOf("empirical(\"a.csv\") mm in 1 mm .. 3 mm", {{"a.csv", "1\n2\n4"}}));
  EXPECT_EQ(SizeOf("empirical(\"t/a.csv\") cm", {{"t/a.csv", "\xEF\xBB\xBFsize,part\n1,3\n2,1\n"}}),
            "empirical(\"t/a.csv\", 0.01 3, 0.02)");
  // Weights of 0 leave values out; comments may follow the numbers.
  EXPECT_EQ(SizeOf("empirical(\"a.csv\")", {{"a.csv", "1.5,2 # two\n2,0\n3,4\n"}}),
            "empirical(\"a.csv\", 1.5 2, 3 4)");
  const std::map<std::string, std::string> grains = {
      {"a.csv", "Nr;d [mm];count\n1;2,5;3\n2;4;1\n"}};
  EXPECT_EQ(SizeOf("empirical(\"a.csv\", column: \"d\", weight: \"count\")", grains),
            "empirical(\"a.csv\", 0.0025 3, 0.004)");
  EXPECT_EQ(SizeOf("empirical(\"a.csv\", column: \"#3\") cm", grains),
            "empirical(\"a.csv\", 0.03, 0.01)");
  EXPECT_EQ(SizeOf("empirical(\"a.csv\", decimal: comma)", {{"a.csv", "1,5\n2\n"}}),
            "empirical(\"a.csv\", 1.5, 2)");
}

TEST(Distributions, DamagedTablesAreRefusedByLine) {
  const std::pair<const char*, const char*> faults[] = {
      {"1\n2\nx\n", "a.csv:3: the value is `x`, which is not a finite number"},
      {"1\n2,3\n", "a.csv:2: `2,3` may be one number with a decimal comma, or two numbers"},
      {"1.0,0\n", "a.csv: all weights are 0"},
      {"1.0,-1\n", "a.csv:1: the weight is -1, less than 0"},
      {"1,2,3\n", "a.csv: it has 3 columns, #1, #2, #3"},
      {"id,size\n1,2\n", "it has two columns, `id` and `size`, and the second may not be weights"},
      {"size [mm]\n1\n", "a.csv:1: the values are in mm"},
      {"size\nmass\n", "a.csv:2: the value is `mass`, which is not a finite number"},
      {"1\nnan\n", "a.csv:2: the value is `nan`, which is not a finite number"},
      {"1e999\n", "a.csv:1: the value is `1e999`, which is not a finite number"},
      {"1\n,\n", "a.csv:2:"},
      {"size\n\n", "'a.csv' contains no value"},
      {"1\n-2\n", "'size' must be more than 0, but 'a.csv' has -2"}};
  for (const auto& [text, message] : faults)
    EXPECT_NE(SizeOf("empirical(\"a.csv\")", {{"a.csv", text}}).find(message), std::string::npos)
        << SizeOf("empirical(\"a.csv\")", {{"a.csv", text}});
  std::string many;
  for (int i = 0; i < 10001; ++i) many += "1\n";
  EXPECT_NE(SizeOf("empirical(\"a.csv\")", {{"a.csv", many}}).find("a.csv:10001: more than 10000"),
            std::string::npos);
  EXPECT_NE(SizeOf("empirical(\"b.csv\")").find("cannot read 'b.csv'"), std::string::npos);
}

TEST(Distributions, WhatIsImpossibleIsOneError) {
  for (const char* value : {"gamma(0, 1)",
                            "gamma(1)",
                            "gamma(1, 2, 3)",
                            "gamma(1, 2, shape: 3)",
                            "weibull(1, -2)",
                            "exponential(0)",
                            "exponential(1, 2)",
                            "lognormal(1000, 1)",
                            "lognormal(0, -1)",
                            "lognormal(median: 0, sigma: 1)",
                            "lognormal(variance: 2)",
                            "gamma(2 cm, 1)",
                            "normal(5, 1) in 8 .. 2",
                            "normal(5, 1) in 50 .. 60",
                            "normal(5, 1) in 2",
                            "any(1, 2) in 1 .. 2",
                            "ring(3) in 1 .. 2",
                            "sweep(1, 2) in 1 .. 2",
                            "normal(5 cm, 1 cm) in 2 .. 8",
                            "empirical(5)",
                            "empirical()",
                            "gamma((1, 1, 1), 2)"}) {
    const compiler::Compilation result =
        CompileText(std::string("benchmark b { objects.size ") + value + " }");
    EXPECT_EQ(result.diagnostics.error_count(), 1) << value << "\n"
                                                   << dsl::Render(result.diagnostics);
  }
}

}  // namespace
}  // namespace cdb::tests
