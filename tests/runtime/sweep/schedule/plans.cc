#include "tests/runtime/sweep/schedule/plans.h"

#include "compiler/schema/schema.h"

namespace cdb::tests {
namespace {

using schema::Word;

plan::Run MakeRun(const PlanShape& shape, std::uint64_t quantity, const std::string& detector,
                  std::uint64_t seed, std::uint64_t rep) {
  plan::Run run;
  run.rep = rep;
  run.scene.world.Set("world.side", 500.0);
  run.scene.groups.push_back({"objects", {}});
  run.scene.groups[0].settings.Set("quantity", quantity);
  run.scene.world.Set("cycles", shape.cycles);
  run.scene.world.Set("warmup", std::uint64_t{0});
  run.scene.world.Set("seed", seed);
  run.scene.world.Set("detector", Word{detector});
  run.scene.world.Set("precision", Word{shape.precision});
  run.scene.world.Set("repeats", shape.repeats);
  run.scene.world.Set("record", schema::WordList(shape.record));
  if (shape.memory_bytes > 0) run.scene.world.Set("memory", shape.memory_bytes);
  if (shape.timeout_s > 0) run.scene.world.Set("timeout", shape.timeout_s);
  run.scene.seeds.emplace("objects.location", plan::StreamSeed(seed, "objects.location"));
  run.id = plan::RunId(run.scene, rep);
  return run;
}

plan::Plan NewPlan(std::uint64_t repeats) {
  plan::Plan plan;
  plan.benchmark = "study";
  plan.title = "a study";
  plan.source = "study.cdb";
  plan.scenario_text = "benchmark study { }\n";
  plan.repeats = repeats;
  return plan;
}

}  // namespace

plan::Plan MakePlan(const PlanShape& shape) {
  plan::Plan plan = NewPlan(shape.repeats);
  plan.axes.resize(2);
  plan.axes[0] = {"quantity", "objects.quantity", "", {}};
  plan.axes[1] = {"detector", "detector", "", {}};
  for (const std::uint64_t quantity : shape.quantities)
    plan.axes[0].values.emplace_back(static_cast<double>(quantity));
  for (const std::string& detector : shape.detectors) plan.axes[1].values.emplace_back(detector);
  for (std::size_t i = 0; i < shape.quantities.size(); ++i)
    for (std::size_t j = 0; j < shape.detectors.size(); ++j)
      for (std::uint64_t rep = 0; rep < shape.repeats; ++rep) {
        plan.runs.push_back(
            MakeRun(shape, shape.quantities[i], shape.detectors[j], shape.seed, rep));
        plan.runs.back().at = {i, j};
      }
  return plan;
}

plan::Plan MakeBehaviourPlan(const std::vector<std::uint64_t>& seeds, const PlanShape& shape) {
  plan::Plan plan = NewPlan(1);
  plan.axes.push_back({"seed", "seed", "", {}});
  for (const std::uint64_t seed : seeds) {
    plan.axes[0].values.emplace_back(static_cast<double>(seed));
    plan.runs.push_back(MakeRun(shape, 3, "dbvt", seed, 0));
    plan.runs.back().at = {plan.runs.size() - 1};
  }
  return plan;
}

std::vector<const plan::Run*> Pointers(const plan::Plan& plan) {
  std::vector<const plan::Run*> runs;
  for (const plan::Run& run : plan.runs) runs.push_back(&run);
  return runs;
}

}  // namespace cdb::tests
