// Scenes that must rest because their objects stand on one another.
#include "compiler/analysis/standing.h"

#include <gtest/gtest.h>

#include <string>

#include "compiler/analysis/expectation.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

/// The expectation of a stack of four cubes of 1 m, whose top is at 0, beside further groups.
std::string ExpectationWith(const std::string& groups, const std::string& stack = "stack(gap: 0)") {
  const compiler::Compilation result = CompileText(
      "benchmark b {\n world.side 8\n objects boxes { quantity 4\n type cuboid\n size 1\n "
      "location " +
      stack + " }\n" + groups + "\n}");
  EXPECT_EQ(result.plans.size(), 1u) << groups;
  if (result.plans.empty()) return "";
  return std::string(
      analysis::ExpectationName(analysis::ExpectationOf(result.plans[0].runs.at(0).scene)));
}

TEST(Standing, OnAStackRests) {
  EXPECT_EQ(ExpectationWith(""), "rest");
  for (const char* group : {
           "objects top { quantity 1\n type cuboid\n size 2\n location at(0, 1, 0) }",
           "objects top { quantity 1\n type cylinder\n size 1\n location at(0.4, 0.51, 0.4) }",
           "objects top { type cuboid\n size 1\n location at((0, 0.5, 0), (0, 1.5, 0)) }",
           "objects top { quantity 1\n type cuboid\n size 1\n aspect 1 : 0.5 : 1\n location at(0, "
           "0.26, 0) }",
           "objects beside { quantity 1\n type cuboid\n size 1\n location at(3, -3.5, 0) }",
       })
    EXPECT_EQ(ExpectationWith(group), "rest") << group;
  EXPECT_EQ(ExpectationWith("objects top { quantity 1\n type cuboid\n size 1\n location at(0.75, "
                            "-1.49, -0.75) }",
                            "stack(height: 2, gap: 0)"),
            "rest")
      << "on a column";
}

TEST(Standing, CountsTheLoad) {
  const auto tower = [](const char* third) {
    return ExpectationWith(std::string("objects top { type cuboid\n size 1\n location at((0, 0.5, "
                                       "0), (0.3, 1.5, 0), (") +
                           third + ", 2.5, 0)) }");
  };
  EXPECT_EQ(tower("0.65"), "rest");
  // The upper two have their centre of mass beyond the edge of the first, or the third that of the
  // second.
  EXPECT_EQ(tower("0.75"), "anything");
  EXPECT_EQ(tower("0.9"), "anything");
  EXPECT_EQ(ExpectationWith("objects beam { quantity 1\n type cuboid\n size 5\n aspect 1 : 0.2 : "
                            "0.2\n location at(0, 0.5, 0) }\n"
                            "objects weight { quantity 1\n type cuboid\n size 1\n mass 5\n "
                            "location at(2, 1.5, 0) }"),
            "anything")
      << "a seesaw";
}

TEST(Standing, IsNotInferredForWhatFallsOrTips) {
  for (const char* group : {
           "objects top { quantity 1\n type cuboid\n size 1\n location at(0, 0.6, 0) }",
           "objects top { quantity 1\n type cuboid\n size 1\n location at(0.6, 0.5, 0) }",
           "objects top { quantity 1\n type sphere\n size 1\n location at(0, 0.5, 0) }",
           "objects top { quantity 1\n type cuboid\n size uniform(0.9, 1)\n location at(0, 0.5, 0) "
           "}",
           "objects top { quantity 1\n type cuboid\n size 1\n linear_velocity (1, 0, 0)\n location "
           "at(0, 0.5, 0) }",
       })
    EXPECT_EQ(ExpectationWith(group), "anything") << group;
}

}  // namespace
}  // namespace cdb::tests
