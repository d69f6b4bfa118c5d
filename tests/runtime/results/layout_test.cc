// The names that an axis must not have are exactly those of the layout.
#include "compiler/schema/metrics.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "compiler/analysis/reference.h"
#include "runtime/results/layout.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

/// A plan whose results have every array that a file can hold, and an axis `x`.
plan::Plan PlanWithEverything() {
  schema::WordList metrics;
  for (const schema::Metric& metric : schema::Metrics()) metrics.emplace_back(metric.name);
  schema::WordList record;
  for (const schema::RecordWord& word : schema::kRecordWords) record.emplace_back(word.name);
  plan::Plan plan = MakePlan({NumberAxis("x", {1, 2})}, 1, {.record = record, .metrics = metrics});
  for (plan::Run& run : plan.runs) run.scene.queries.push_back({"sight", {}});
  plan.axes[0].sampled = {{"mu", 0, 1, false, {0.2, 0.7}}};
  plan.requirements = {{"verdict == stable", {}, plan::Comparison::kEqual, 1}};
  return plan;
}

/// Of a narrow phase on recorded pairs, which has series of its own.
plan::Plan PlanOnPairs() {
  plan::Plan plan = MakePlan({}, 1, {.record = {"counts"}});
  for (plan::Run& run : plan.runs) {
    run.scene.world.Set("trace", schema::Call{"file", {schema::Text{"t.h5"}, schema::Text{"0"}}});
    run.scene.world.Set("narrow_phase", schema::Word{"bullet"});
  }
  return plan;
}

/// Of a broad phase on the primitives of a deforming mesh, whose collisions are counted.
plan::Plan PlanOnBoxes() {
  plan::Plan plan = MakePlan({}, 1, {.record = {"pairs"}});
  for (plan::Run& run : plan.runs)
    run.scene.world.Set("trace", schema::Call{"file", {schema::Text{"t.h5"}, schema::Text{"0"}}});
  return plan;
}

/// Of configurations of joints, which have series of their own, too.
plan::Plan PlanOfConfigurations() {
  plan::Plan plan = MakePlan({}, 1, {.record = {"counts", "pairs"}});
  for (plan::Run& run : plan.runs)
    run.scene.world.Set("configurations.positions", schema::Word{"uniform"});
  return plan;
}

/// With soft bodies, which have series of their own, too.
plan::Plan PlanWithSoft() {
  plan::Plan plan = MakePlan({}, 1, {.record = {"stability", "vertices"}});
  for (plan::Run& run : plan.runs)
    run.scene.groups[0].settings.Set("type",
                                     schema::Call{"rope", {schema::Number(std::uint64_t{5})}});
  return plan;
}

/// With objects that come and go, which have series of their own, too.
plan::Plan PlanOfPopulation() {
  plan::Plan plan = MakePlan({}, 1, {.record = {"timing", "counts"}});
  for (plan::Run& run : plan.runs)
    run.scene.groups[0].settings.Set("spawn.batch", schema::Number(std::uint64_t{5}));
  return plan;
}

/// Names that share a group with the coordinates of axes: in the root, /run or /accuracy.
std::set<std::string> NamesBesideAxes(const plan::Plan& plan) {
  const results::PlanFacts facts(plan);
  const results::Layout layout = results::MakeLayout(plan, facts, 1);
  std::set<std::string> names = {"provenance"};
  const auto add = [&names](const std::string& path) {
    for (const std::string& group :
         {std::string(), std::string(results::kRunGroup), std::string(results::kAccuracyGroup)})
      if (path.starts_with(group) && path.find('/', group.size()) == std::string::npos)
        names.insert(path.substr(group.size()));
    if (const std::size_t slash = path.find('/'); slash != std::string::npos)
      names.insert(path.substr(0, slash));
  };
  for (const results::Dimension& dimension : layout.dimensions) add(dimension.name);
  for (const results::Array& array : layout.arrays) add(array.name);
  for (const results::Column& column : layout.columns) add(column.name);
  names.erase("x");
  return names;
}

TEST(ResultNames, AreThoseOfTheLayout) {
  const plan::Plan plan = PlanWithEverything();
  const auto errors = analysis::ErrorsOf(plan);
  ASSERT_EQ(errors.size(), schema::Errors().size());
  std::set<std::string> used = NamesBesideAxes(plan);
  used.merge(NamesBesideAxes(PlanOnPairs()));
  used.merge(NamesBesideAxes(PlanOnBoxes()));
  used.merge(NamesBesideAxes(PlanOfConfigurations()));
  used.merge(NamesBesideAxes(PlanWithSoft()));
  used.merge(NamesBesideAxes(PlanOfPopulation()));
  for (const std::string& name : used)
    EXPECT_TRUE(schema::FindNameClash(name, errors))
        << name << " is in the results and missing in compiler/schema/metrics.cc";
  std::set<std::string> listed;
  for (const schema::ResultNames& row : schema::ReservedNames()) {
    for (const std::string_view name : row.names) {
      EXPECT_TRUE(used.contains(std::string(name))) << name << " is not in the results";
      EXPECT_TRUE(listed.emplace(name).second) << name << " is listed twice";
    }
  }
  EXPECT_FALSE(schema::FindNameClash("x", errors));
  // The group of references has no axes, so its names are free.
  for (const char* name : {"reference", "state", "observable", "states", "role"})
    EXPECT_EQ(schema::FindNameClash(name, errors).has_value(), used.contains(name)) << name;
}

TEST(ResultNames, OfErrorsAreTakenOnlyByBenchmarksThatAskForThem) {
  const plan::Plan plan = MakePlan({}, 1, {.metrics = {"height"}});
  for (const char* name : {"height", "height_floor", "height_w1_series", "sample", "step_size"}) {
    EXPECT_FALSE(schema::FindNameClash(name, {})) << name;
    EXPECT_TRUE(schema::FindNameClash(name, analysis::ErrorsOf(plan))) << name;
  }
  EXPECT_FALSE(schema::FindNameClash("velocity", analysis::ErrorsOf(plan)));
}

}  // namespace
}  // namespace cdb::tests
