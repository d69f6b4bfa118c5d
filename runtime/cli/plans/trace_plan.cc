#include "runtime/cli/plans/trace_plan.h"

#include <fmt/format.h>

#include <set>
#include <system_error>
#include <utility>
#include <variant>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/rounds.h"

namespace cdb::plans {
namespace {

namespace fs = std::filesystem;

/// `crowd`, `crowd_n-1000_detector-dbvt`: the name of a point as a file name.
std::string FileName(const plan::Plan& plan, const plan::Run& run) {
  std::string name = plan.benchmark;
  for (std::size_t i = 0; i < plan.axes.size(); ++i) {
    const plan::Coordinate& value = plan.axes[i].values[run.at[i]];
    const auto* number = std::get_if<double>(&value);
    name += fmt::format("_{}-{}", plan.axes[i].name,
                        number ? schema::FormatReal(*number) : std::get<std::string>(value));
  }
  for (char& c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '+';
    if (!is_plain) c = '_';
  }
  return name;
}

}  // namespace

plan::Plan MakeTracePlan(plan::Plan plan) {
  RunEachPointOnce(plan);
  for (plan::Run& run : plan.runs) {
    if (analysis::TraceOf(run.scene))
      throw options::CommandError(
          fmt::format("{}: {} already runs on a trace; trace a benchmark of a live world",
                      plan.benchmark, plan::Describe(plan, run)));
    if (analysis::HasConfigurations(run.scene))
      throw options::CommandError(
          fmt::format("{}: {} checks configurations, and nothing moves from one to the next; trace "
                      "a benchmark of a live world",
                      plan.benchmark, plan::Describe(plan, run)));
    if (analysis::HasSoft(run.scene))
      throw options::CommandError(
          fmt::format("{}: {} has soft bodies, which no recorded box or pose describes; trace a "
                      "benchmark of rigid bodies",
                      plan.benchmark, plan::Describe(plan, run)));
    if (const plan::Group* changing = analysis::FindChanging(run.scene))
      throw options::CommandError(
          fmt::format("{}: in {} the objects of {} come and go, and a trace has the same bodies in "
                      "every cycle; trace a benchmark without spawn and remove",
                      plan.benchmark, plan::Describe(plan, run), changing->name));
    const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
      run.scene.world.Set(parameter, std::move(value));
    };
    set("record", schema::WordList{"boxes", "poses"});
    set("pair_order", schema::Word{"sorted"});
    set("accuracy.metrics", schema::WordList{"none"});
    set("repeats", std::uint64_t{1});
    run.scene.DropQueries();
    run.id = plan::RunId(run.scene, 0);
  }
  plan.references.clear();
  return plan;
}

std::vector<fs::path> TraceFiles(const plan::Plan& plan, const std::string& out,
                                 std::size_t plan_count) {
  std::error_code error;
  const bool is_one = plan.runs.size() == 1 && plan_count == 1;
  if (is_one && !out.empty() && !fs::is_directory(out, error)) return {out};
  fs::path folder = out;
  if (folder.empty()) folder = plan.runs.size() == 1 ? "." : plan.benchmark + ".traces";
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error))
    throw options::CommandError(
        fmt::format("cannot make the folder '{}' for the traces: {}; choose another "
                    "place by -o",
                    folder.string(), error ? error.message() : "a file of this name exists"));
  std::vector<fs::path> files;
  std::set<std::string> taken;
  for (const plan::Run& run : plan.runs) {
    std::string name = FileName(plan, run);
    if (!taken.insert(name).second) name += "_" + run.id;
    fs::path file = folder / (name + ".trace.h5");
    files.push_back(out.empty() && plan.runs.size() == 1 ? file.lexically_normal()
                                                         : std::move(file));
  }
  return files;
}

}  // namespace cdb::plans
