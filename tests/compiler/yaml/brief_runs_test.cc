// The short summary of a plan agrees with the plan as read in full.
#include "compiler/yaml/short_plan.h"

#include <gtest/gtest.h>

#include <string>

#include "compiler/compile.h"
#include "compiler/yaml/plan_yaml.h"

namespace cdb::tests {
namespace {

plan::Plan PlanToLookAt(const std::string& text) {
  const auto read = [&](const std::string&, std::string&) { return std::optional(text); };
  return compiler::Compile("test.cdb", read).plans.at(0);
}

TEST(BriefRuns, AreThoseOfThePlan) {
  for (const char* text :
       {"benchmark b { }", "benchmark b { objects { quantity sweep(0, 3, 1000) } }",
        "# runs:\n#   - id: \"0\"\nbenchmark b { detector sweep(dbvt, sap); narrow_phase "
        "sweep(own, bullet); repeats 2\n"
        "seed sweep(1 .. 3); skip when seed == 2\n"
        "objects pebbles { quantity 4; size uniform(1, 2) }\n"
        "objects bricks { quantity sweep(1, 2); mass fixed } }"}) {
    SCOPED_TRACE(text);
    const plan::Plan plan = PlanToLookAt(text);
    const auto runs = yaml::FindBriefRuns(yaml::ToYaml(plan));
    ASSERT_TRUE(runs);
    ASSERT_EQ(runs->size(), plan.runs.size());
    for (std::size_t i = 0; i < plan.runs.size(); ++i) {
      EXPECT_EQ((*runs)[i].id, plan.runs[i].id);
      EXPECT_EQ((*runs)[i].at, plan.runs[i].at);
      EXPECT_EQ((*runs)[i].detector, plan.runs[i].scene.world.WordOr("detector"));
      EXPECT_EQ((*runs)[i].narrow_phase, plan.runs[i].scene.world.WordOr("narrow_phase"));
      EXPECT_EQ((*runs)[i].objects, plan.runs[i].scene.ObjectCount());
    }
  }
}

TEST(BriefRuns, OfOtherTextsAreNone) {
  const std::string yaml = yaml::ToYaml(PlanToLookAt("benchmark b { }"));
  std::string other = yaml;
  other.replace(other.find("cdb_plan: "), 11, "cdb_plan: 4");
  EXPECT_FALSE(yaml::FindBriefRuns(other)) << "another version";
  EXPECT_FALSE(yaml::FindBriefRuns(""));
  EXPECT_FALSE(yaml::FindBriefRuns("cdb_short_plan: 5\nruns: 7\n"));
  other = yaml;
  other.replace(other.find("    at: []"), 10, "    at: [x]");
  EXPECT_FALSE(yaml::FindBriefRuns(other));
}

}  // namespace
}  // namespace cdb::tests
