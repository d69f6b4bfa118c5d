#include "compiler/analysis/reference.h"

#include <gtest/gtest.h>

#include <set>

#include "compiler/schema/metrics.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

plan::Plan PlanWith(const std::string& settings) {
  const compiler::Compilation result = CompileText("benchmark b { " + settings + " }");
  EXPECT_EQ(dsl::Render(result.diagnostics), "");
  return result.plans.at(0);
}

const char kSweep[] =
    "let hz = sweep(30, 60, 120); timestep 1 / hz; cycles 2 * hz\n"
    "solver.iterations sweep(5, 20); detector sweep(sap, dbvt); contact sweep(bullet, faithful)\n"
    "accuracy { metrics position; reference { contact faithful } }";

TEST(Reference, IsSharedByAllThatItStandsFor) {
  const plan::Plan plan = PlanWith(std::string("repeats 2\n") + kSweep);
  EXPECT_EQ(plan.runs.size(), 48u);
  ASSERT_EQ(plan.references.size(), 2u);
  EXPECT_EQ(plan.references[0].scene.role, plan::Role::kReference);
  EXPECT_EQ(plan.references[1].scene.role, plan::Role::kTwin);
  for (const plan::Run& run : plan.runs) {
    EXPECT_EQ(run.reference, plan.references[0].id);
    EXPECT_EQ(run.twin, plan.references[1].id);
  }
  const plan::WorldSettings& world = plan.references[0].scene.world;
  EXPECT_DOUBLE_EQ(world.Real("timestep"), 1.0 / 3840);
  EXPECT_EQ(world.Count("cycles"), 7680u);
  EXPECT_EQ(world.WordOr("precision"), "double");
  EXPECT_EQ(world.WordOr("detector"), "dbvt");
  EXPECT_EQ(world.WordOr("contact"), "faithful");
  EXPECT_EQ(world.Count("solver.iterations"), 100u);
  EXPECT_EQ(plan.references[0].scene.groups, plan.runs[0].scene.groups);
  EXPECT_EQ(
      PlanWith("narrow_phase sweep(own, bullet); threads sweep(1, 2); accuracy.metrics energy")
          .references.size(),
      2u);
  // By default, a reference has the contact settings of its run.
  EXPECT_EQ(PlanWith("contact sweep(bullet, faithful); accuracy.metrics energy").references.size(),
            4u);
}

TEST(Reference, IsCheckedByARunOfAnotherTimeStep) {
  const auto steps = [](const std::string& accuracy) {
    const plan::Plan plan = PlanWith("cycles 120; accuracy { metrics position; " + accuracy + " }");
    std::vector<double> cycles;
    for (const plan::Run& run : plan.references) {
      cycles.push_back(static_cast<double>(run.scene.world.Count("cycles")));
      EXPECT_NEAR(cycles.back() * run.scene.world.Real("timestep"), 2, 1e-12);
      EXPECT_EQ(analysis::SamplingOf(run.scene)->count, 31u);
    }
    return cycles;
  };
  EXPECT_EQ(steps("reference.timestep 1/3840"), (std::vector<double>{7680, 3840}));
  // An odd number of steps has no half.
  EXPECT_EQ(steps("reference.timestep 1/75"), (std::vector<double>{150, 300}));
  EXPECT_EQ(steps("reference.timestep 1/15"), (std::vector<double>{30, 60}));

  // Nor has a schedule that changes after each odd number of steps.
  const plan::Plan plan = PlanWith(
      "cycles 120; acceleration every(1, uniform((-1, -1, -1), (1, 1, 1)))\n"
      "accuracy { metrics position; reference.timestep 1/60 }");
  EXPECT_EQ(plan.references.at(1).scene.world.Count("cycles"), 240u);
}

TEST(Reference, DoesNotSleepAndHasAVerdict) {
  const auto of = [](const std::string& settings) {
    return PlanWith(settings + "; accuracy.metrics position").references;
  };
  const std::vector<plan::Run> references = of("sleeping on");
  for (const plan::Run& run : references) EXPECT_FALSE(run.scene.world.On("sleeping"));
  EXPECT_TRUE(references[0].scene.world.Lists("record", "stability"));
  EXPECT_FALSE(references[1].scene.world.Lists("record", "stability"));
  EXPECT_EQ(of("sleeping sweep(on, off)").size(), 2u);
  EXPECT_EQ(of("sleeping sweep(on, off); accuracy.reference.sleeping same").size(), 4u);
}

TEST(Reference, HasThePluginsOfItsOwnDetectorAlone) {
  const auto plan_of = [](const std::string& accuracy) {
    const compiler::Compilation result = CompileText(
        "use detector \"mine.so\"\nbenchmark b { detector sweep(mine, other)\n" + accuracy + " }",
        {{"mine.so", "mine 0 broad\nother 0 broad\ntruth 0 broad"}});
    EXPECT_EQ(dsl::Render(result.diagnostics), "");
    return result.plans.at(0);
  };
  const plan::Plan with_dbvt = plan_of("accuracy.metrics position");
  ASSERT_EQ(with_dbvt.references.size(), 2u);
  EXPECT_TRUE(with_dbvt.references[0].scene.plugins.empty());
  const plan::Plan with_truth =
      plan_of("accuracy { metrics position; reference { detector truth } }");
  ASSERT_EQ(with_truth.references.size(), 2u);
  ASSERT_EQ(with_truth.references[0].scene.plugins.size(), 1u);
  EXPECT_EQ(with_truth.references[0].scene.plugins[0].name, "truth");
  EXPECT_EQ(with_truth.runs[0].scene.plugins.size(), 2u);
}

TEST(Reference, IsAnotherForAnotherSceneOrTime) {
  EXPECT_EQ(PlanWith("seed sweep(1, 2); accuracy.metrics position").references.size(), 4u);
  EXPECT_EQ(PlanWith("cycles sweep(60, 120); accuracy.metrics position").references.size(), 4u);
  // Recording, omissions and the end of the warm-up do not affect the reference.
  EXPECT_EQ(PlanWith("omit sweep(none, auto); accuracy.metrics position").references.size(), 2u);
  EXPECT_EQ(
      PlanWith("cases { a { warmup 20; cycles 40 } b { cycles 60 } }\naccuracy.metrics position")
          .references.size(),
      2u);
}

TEST(Reference, IsMadeOnlyWhereErrorsNeedTheTruth) {
  EXPECT_TRUE(PlanWith("cycles 60").references.empty());
  EXPECT_TRUE(PlanWith("accuracy.metrics pairs, penetration").references.empty());
  EXPECT_TRUE(PlanWith("accuracy { metrics position; closed_form flight }").references.empty());
  EXPECT_FALSE(PlanWith("accuracy.metrics pairs, height").references.empty());
}

TEST(Reference, GoesIntoYamlAndBack) {
  const plan::Plan plan = PlanWith(kSweep);
  EXPECT_TRUE(yaml::FromYaml(yaml::ToYaml(plan), "plan") == plan);
  for (const plan::Run& run : plan.references)
    EXPECT_TRUE(yaml::RunFromYaml(yaml::RunToYaml(run), "run") == run);
}

TEST(Reference, StretchesSchedulesThatCountCycles) {
  const plan::Plan plan = PlanWith(
      "acceleration every(30, uniform((-1, -1, -1), (1, 1, 1))); accuracy.metrics position");
  const schema::Call* call = schema::AsCall(plan.references.at(0).scene.world.Get("acceleration"));
  ASSERT_NE(call, nullptr);
  EXPECT_EQ(std::get<schema::Number>(schema::ArgumentOf(*call, "cycles")).AsCount(), 30u * 64);
}

TEST(Sampling, CountsCyclesFromTheStart) {
  const plan::Plan plan = PlanWith("warmup 6; cycles 60; accuracy.metrics pairs");
  const auto sampling = analysis::SamplingOf(plan.runs[0].scene);
  ASSERT_TRUE(sampling);
  EXPECT_EQ(sampling->cycles, 4u);
  EXPECT_EQ(sampling->count, 17u);  // 66 cycles hold 16 intervals
  EXPECT_FALSE(analysis::SamplingOf(PlanWith("cycles 60").runs[0].scene));
}

TEST(Sampling, TakesWholeSteps) {
  EXPECT_EQ(analysis::WholeSteps(1.0 / 15, 1.0 / 60), 4u);
  EXPECT_EQ(analysis::WholeSteps(1.0 / 15, 1.0 / 3840), 256u);
  EXPECT_EQ(analysis::WholeSteps(1.0 / 3, 1.0 / 999), 333u);
  EXPECT_FALSE(analysis::WholeSteps(1.0 / 15, 1.0 / 100));
  EXPECT_FALSE(analysis::WholeSteps(1.0 / 15, 1.0 / 10));
}

TEST(Errors, HaveANameAndAWordEach) {
  std::set<std::string_view> names;
  for (const schema::ErrorInfo& error : schema::Errors()) {
    EXPECT_TRUE(names.insert(error.name).second) << error.name;
    EXPECT_EQ(error.series, "accuracy/" + std::string(error.name) + "_series");
    EXPECT_FALSE(error.doc.empty());
    // In a file, `position_floor` must not be mistaken for an error.
    EXPECT_FALSE(error.name.ends_with("_floor") || error.name.ends_with("_series"));
  }
  std::set<std::string_view> words;
  for (const schema::Metric& metric : schema::Metrics())
    EXPECT_TRUE(words.insert(metric.name).second);
}

}  // namespace
}  // namespace cdb::tests
