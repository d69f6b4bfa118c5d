#include "runtime/cli/plans/verify_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "compiler/analysis/population.h"
#include "compiler/analysis/queries.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/compile.h"
#include "compiler/schema/catalogue.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/rounds.h"
#include "runtime/results/trace_file.h"

namespace cdb::plans {
namespace {

using plan::Plan;

/// Removes an axis and keeps one run of each remaining point. Any of them will do if they differ
/// only in the detector.
Plan WithoutAxis(const Plan& plan, std::size_t axis) {
  Plan rest = plan;
  rest.axes.erase(rest.axes.begin() + static_cast<std::ptrdiff_t>(axis));
  rest.runs.clear();
  rest.skipped.clear();
  std::set<std::vector<std::size_t>> there;
  const auto less = [&](std::vector<std::size_t> at) {
    at.erase(at.begin() + static_cast<std::ptrdiff_t>(axis));
    return at;
  };
  for (plan::Run run : plan.runs) {
    run.at = less(std::move(run.at));
    if (there.insert(run.at).second) rest.runs.push_back(std::move(run));
  }
  for (const auto& skipped : plan.skipped)
    if (auto at = less(skipped); there.insert(at).second) rest.skipped.push_back(std::move(at));
  return rest;
}

Plan WithDetectors(const Plan& plan, const std::vector<std::string>& detectors,
                   std::span<const schema::PluginDetector> plugins) {
  const auto axis = std::ranges::find(plan.axes, "detector", &plan::Axis::parameter);
  return compiler::Cross(
      axis == plan.axes.end()
          ? plan
          : WithoutAxis(plan, static_cast<std::size_t>(axis - plan.axes.begin())),
      "detector", detectors, plugins);
}

/// The reason why `all` excludes a detector, independent of the scene; empty if it does not.
std::string Absence(const schema::DetectorInfo& info) {
  if (info.family == "none") return "finds nothing, by design; name it to run it anyway";
  const schema::DetectorPart* part = schema::FindDetectorPart(info.part);
  if (part != nullptr && !part->is_built)
    return fmt::format("is not built; install {} and build again", part->package);
  return {};
}

/// The named detectors, or all with a broad phase; `left_out` receives those left out, with
/// reasons.
std::vector<schema::DetectorInfo> Chosen(const VerifyOptions& options,
                                         std::vector<std::string>& left_out) {
  std::vector<schema::DetectorInfo> chosen;
  if (!options.WantsAll()) {
    for (const std::string& name : options.detectors)
      chosen.push_back(*schema::FindDetector(name, options.plugins));
    return chosen;
  }
  const auto choose = [&](const schema::DetectorInfo& info) {
    if (!info.HasPhase("broad")) return;
    if (const std::string why = Absence(info); !why.empty())
      left_out.push_back(fmt::format("{} {}", info.name, why));
    else
      chosen.push_back(info);
  };
  for (const schema::DetectorInfo& info : schema::Detectors()) choose(info);
  for (const schema::PluginDetector& plugin : options.plugins)
    choose(*schema::FindDetector(plugin.name, options.plugins));
  return chosen;
}

/// `all` leaves out detectors that test all pairs of more bodies, which would take seconds a cycle.
constexpr std::uint64_t kMostForAllPairs = 20'000;

bool TestsAllPairs(const schema::DetectorInfo& info) { return info.family == "all pairs"; }

/// The bodies of scenes; those of a trace are in its file, which is read once.
class BodyCounts {
 public:
  /// Throws StoreError if a trace cannot be read.
  std::uint64_t Of(const plan::Scene& scene) {
    const auto trace = analysis::TraceOf(scene);
    if (!trace) return analysis::BodyCount(scene);
    const auto [at, is_new] = of_traces_.try_emplace(trace->path, 0);
    if (is_new) at->second = results::ReadTraceFacts(trace->path).bodies;
    return at->second;
  }

 private:
  std::map<std::string, std::uint64_t> of_traces_;
};

/// Points that a detector cannot handle are skipped; a detector that can handle none is left out.
VerifyPlan WithChosen(const Plan& plan, const VerifyOptions& options) {
  VerifyPlan every;
  std::vector<std::string> names;
  std::vector<std::uint64_t> limits;  // of bodies; 0: none
  BodyCounts bodies;
  const auto holds = [&](std::uint64_t limit, const plan::Run& run) {
    return limit == 0 || bodies.Of(run.scene) <= limit;
  };
  const bool comes_or_goes = std::ranges::any_of(
      plan.runs, [](const plan::Run& run) { return analysis::ComesOrGoes(run.scene); });
  for (const schema::DetectorInfo& info : Chosen(options, every.left_out)) {
    if (comes_or_goes && !analysis::KnowsChanges(info.name)) {
      every.left_out.push_back(
          fmt::format("{}, which is told of its bodies once, and objects come and go", info.name));
      continue;
    }
    const bool is_slow = options.WantsAll() && TestsAllPairs(info);
    const std::uint64_t limit = is_slow ? kMostForAllPairs : info.max_bodies;
    const auto held =
        std::ranges::count_if(plan.runs, [&](const plan::Run& run) { return holds(limit, run); });
    if (held < std::ssize(plan.runs))
      every.left_out.push_back(fmt::format(
          "{}, if there are more than {} bodies{}", info.name, limit,
          is_slow ? ", because it tests all pairs of them; name it to run it anyway" : ""));
    if (held == 0) continue;
    names.emplace_back(info.name);
    limits.push_back(limit);
  }
  if (names.empty()) return every;
  every.plan = WithDetectors(plan, names, options.plugins);
  std::erase_if(every.plan.runs, [&](const plan::Run& run) {
    const bool is_held = holds(limits[run.at[0]], run);
    if (!is_held) every.plan.skipped.push_back(run.at);
    return !is_held;
  });
  std::ranges::sort(every.plan.skipped);
  return every;
}

}  // namespace

VerifyPlan MakeVerifyPlan(const Plan& plan, const VerifyOptions& options) {
  Plan bare = plan;
  RunEachPointOnce(bare);
  for (plan::Run& run : bare.runs) {
    if (analysis::HasSoft(run.scene))
      throw options::CommandError(fmt::format(
          "{}: {} has soft bodies, whose pairs and contacts are not compared with exact "
          "ones; verify a benchmark of rigid bodies",
          plan.benchmark, plan::Describe(plan, run)));
    const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
      run.scene.world.Set(parameter, std::move(value));
    };
    set("record", analysis::HasQueries(run.scene) ? schema::WordList{"pairs", "query_errors"}
                                                  : schema::WordList{"pairs"});
    set("accuracy.metrics", schema::WordList{"none"});
    set("pair_order", schema::Word{"sorted"});
    set("repeats", std::uint64_t{1});
    if (options.cycles) set("cycles", *options.cycles);
    run.id = plan::RunId(run.scene, run.rep);
  }
  analysis::AddReferences(bare);
  VerifyPlan made;
  if (options.detectors.empty())
    made.plan = std::move(bare);
  else
    made = WithChosen(bare, options);
  if (made.plan.runs.empty())
    throw options::CommandError(
        fmt::format("{}: there is nothing to verify: {}", plan.benchmark,
                    made.left_out.empty() ? "every point is skipped"
                                          : fmt::format("{}", fmt::join(made.left_out, "; "))));
  return made;
}

}  // namespace cdb::plans
