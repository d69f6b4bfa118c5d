#include <gtest/gtest.h>

#include "compiler/analysis/trace.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

plan::Plan TracedPlan(const std::string& text) {
  compiler::Compilation result = CompileText(text);
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans.size(), 1u);
  return result.plans.empty() ? plan::Plan() : result.plans[0];
}

TEST(TracedScene, IsAsTheTraceSays) {
  const plan::Plan plan = TracedPlan("benchmark b { trace \"crowd.trace.h5\" }");
  ASSERT_EQ(plan.runs.size(), 1u);
  const plan::Scene& scene = plan.runs[0].scene;
  EXPECT_EQ(analysis::TraceOf(scene),
            (analysis::TraceName{"crowd.trace.h5", std::string(64, 'c')}));
  EXPECT_EQ(scene.ObjectCount(), 1000u);
  EXPECT_EQ(scene.world.Count("cycles"), 100u);
  EXPECT_EQ(scene.world.WordOr("precision"), "single");
  EXPECT_EQ(scene.world.Get("record"), schema::Value(schema::WordList{"counts", "timing"}));
  EXPECT_TRUE(scene.seeds.empty());
  EXPECT_FALSE(analysis::TraceOf(TracedPlan("benchmark b { }").runs.at(0).scene));
}

TEST(TracedScene, WarmupLeavesTheRest) {
  const plan::Plan plan = TracedPlan("benchmark b { trace \"crowd.trace.h5\"; warmup 30 }");
  EXPECT_EQ(plan.runs.at(0).scene.world.Count("cycles"), 70u);
  const plan::Plan few =
      TracedPlan("benchmark b { trace \"crowd.trace.h5\"; warmup 30; cycles 5 }");
  EXPECT_EQ(few.runs.at(0).scene.world.Count("cycles"), 5u);
}

TEST(TracedScene, SweepsTracesBesideLiveWorlds) {
  const plan::Plan plan = TracedPlan(
      "benchmark b { trace sweep(none, \"crowd.trace.h5\", \"large.trace.h5\")\n"
      "detector sweep(simple, dbvt) }");
  ASSERT_EQ(plan.axes.size(), 2u);
  EXPECT_EQ(plan.axes[0].name, "trace");
  EXPECT_EQ(plan.axes[0].values[1], plan::Coordinate("crowd.trace.h5"));
  ASSERT_EQ(plan.runs.size(), 6u);
  EXPECT_FALSE(analysis::TraceOf(plan.runs[0].scene));
  EXPECT_EQ(plan.runs[0].scene.ObjectCount(), 10u);
  EXPECT_EQ(plan.runs[2].scene.ObjectCount(), 1000u);
  EXPECT_EQ(plan.runs[4].scene.ObjectCount(), 100'000u);
  EXPECT_EQ(plan.runs[4].scene.world.WordOr("precision"), "double");
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(plan), "plan").runs, plan.runs);
}

TEST(TracedScene, IsNamedByItsHash) {
  const plan::Plan by_name = TracedPlan("benchmark b { trace \"crowd.trace.h5\" }");
  const std::string hash(64, 'c');
  const plan::Plan by_hash =
      TracedPlan("benchmark b { trace file(\"crowd.trace.h5\", sha256: \"" + hash + "\") }");
  EXPECT_EQ(by_name.runs.at(0).id, by_hash.runs.at(0).id);
}

TEST(TracedScene, OfPairsTimesANarrowPhaseAndIsNamedByThem) {
  const plan::Plan plan =
      TracedPlan("benchmark b { trace \"pairs.trace.h5\"; narrow_phase sweep(own, bullet) }");
  ASSERT_EQ(plan.runs.size(), 2u);
  EXPECT_FALSE(analysis::IsOnPairs(plan.runs[0].scene));
  EXPECT_TRUE(analysis::IsOnPairs(plan.runs[1].scene));
  EXPECT_EQ(analysis::TraceOf(plan.runs[0].scene)->sha256, std::string(64, 'c'));
  EXPECT_EQ(analysis::TraceOf(plan.runs[1].scene)->sha256, std::string(64, 'p'));
  EXPECT_EQ(plan.runs[0].id, TracedPlan("benchmark b { trace \"pairs.trace.h5\" }").runs.at(0).id);
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(plan), "plan").runs, plan.runs);
  EXPECT_FALSE(
      analysis::IsOnPairs(TracedPlan("benchmark b { narrow_phase bullet }").runs[0].scene));
}

TEST(TracedScene, StandsInCases) {
  const plan::Plan plan = TracedPlan(
      "benchmark b { detector sweep(simple, dbvt)\n"
      "cases where { live { objects.quantity 7 } traced { trace \"crowd.trace.h5\" } } }");
  ASSERT_EQ(plan.runs.size(), 4u);
  EXPECT_EQ(plan.runs[0].scene.ObjectCount() + plan.runs[3].scene.ObjectCount(), 1007u);
}

}  // namespace
}  // namespace cdb::tests
