// Checks whether results of the standard suite are complete and comparable (`cdb suite --check`).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "compiler/plan/input_file.h"
#include "runtime/cli/options/exit_status.h"
#include "runtime/cli/plans/suite_folder.h"
#include "runtime/cli/plans/suite_plan.h"
#include "runtime/figures/points.h"

namespace cdb::plans {
namespace {

using figures::ComparedFile;

/// For a run of an extra detector: the id that the run would have with the baseline.
std::string IdWithBaseline(const plan::Run& run, const plan::Plan& standard) {
  plan::Scene scene = run.scene;
  scene.world.Set("detector", standard.runs[0].scene.world.Get("detector"));
  scene.plugins.clear();
  return plan::RunId(scene, run.rep);
}

/// The reason why the plan of the results is not `standard`, with or without additional detectors;
/// empty if it is.
std::string FindForeign(plan::Plan of, const plan::Plan& standard) {
  of.Renew();
  std::set<std::string> ids, wanted;
  for (const plan::Run& run : standard.runs) wanted.insert(run.id);
  std::size_t foreign = 0;
  for (const plan::Run& run : of.runs) {
    ids.insert(run.id);
    foreign += !wanted.contains(run.id) && !wanted.contains(IdWithBaseline(run, standard));
  }
  std::size_t absent = 0;
  for (const std::string& id : wanted) absent += !ids.contains(id);
  if (foreign == 0 && absent == 0) return {};
  return fmt::format(
      "it is not of version {} of the suite: its plan lacks {} runs of the suite, and has {} "
      "others",
      figures::kSuiteVersion, absent, foreign);
}

class Checker {
 public:
  explicit Checker(const SuiteFolder& read) : read_(read) {}

  SuiteFaults All(const std::filesystem::path& folder) {
    for (const std::string& id : read_.facts.missing) Fault("{}: there are no results", id);
    for (std::size_t i = 0; i < read_.files.size(); ++i)
      CheckFile(read_.scenes[i], *read_.files[i]);
    for (const char* fact :
         {"cdb_version", "commit", "build_type", "bullet_version", "compiler", "cpu", "host"})
      CheckSame(fact);
    if (read_.files[0]->file.ReadProvenance("commit").ends_with("-dirty"))
      Fault("cdb was built from uncommitted sources");
    CheckNoise();
    CheckSummary(folder);
    return std::move(made_);
  }

 private:
  template <typename... Parts>
  void Fault(fmt::format_string<Parts...> text, Parts&&... parts) {
    made_.faults.push_back(fmt::format(text, std::forward<Parts>(parts)...));
  }

  void CheckFile(const figures::SceneFigures& scene, const ComparedFile& of) {
    const std::string id = scene.scene->Id();
    if (!of.file.has_digest()) Fault("{}: it has no digest that would reveal changed bytes", id);
    if (!of.plan) return Fault("{}: its plan is from another version of cdb", id);
    const plan::Plan standard =
        StandardPlan(*scene.scene, {.is_long = read_.facts.is_long, .seed = read_.facts.seed});
    if (const std::string why = FindForeign(*of.plan, standard); !why.empty())
      Fault("{}: {}", id, why);
    std::size_t missing = 0;
    for (const auto& cell : figures::AllCells(of.file))
      missing += of.file.ReadStatus(cell) == results::Status::kMissing;
    if (missing > 0) Fault("{}: {} runs are missing", id, missing);
    if (const std::string build = of.file.ReadProvenance("build_type"); build != "Release")
      Fault("{}: timed with a {} build", id, build.empty() ? "unknown" : build);
    if (const std::string jobs = of.file.ReadProvenance("jobs"); !jobs.empty() && jobs != "1")
      Fault("{}: {} runs were executed in parallel", id, jobs);
  }

  /// A fact of the provenance must be the same in all files.
  void CheckSame(const char* fact) {
    std::map<std::string, std::size_t> values;
    for (const auto& of : read_.files) ++values[of->file.ReadProvenance(fact)];
    std::vector<std::string> names;
    for (const auto& [value, count] : values)
      names.push_back(value.empty() ? std::string("unknown") : value);
    made_.facts.push_back(fmt::format("{}: {}", fact, fmt::join(names, ", ")));
    if (values.size() > 1)
      Fault("the scenes are not of one run of the suite: {} is {}", fact, fmt::join(names, ", "));
  }

  void CheckNoise() {
    std::size_t noisy = 0, runs = 0;
    std::vector<std::string> distrusted;
    for (const figures::SceneFigures& scene : read_.scenes)
      for (const figures::ConfigurationFigures& of : scene.configurations) {
        noisy += of.noisy;
        runs += of.repeats;
        if (of.IsNoisy()) distrusted.push_back(fmt::format("{} {}", scene.scene->Id(), of.name));
      }
    made_.facts.push_back(fmt::format("noisy: {} of {} runs", noisy, runs));
    if (distrusted.empty()) return;
    const std::size_t all = distrusted.size();
    if (all > 3) distrusted.resize(3);
    Fault("the machine was not quiet: most runs of {} configurations are noisy: {}{}", all,
          fmt::join(distrusted, ", "), all > 3 ? ", …" : "");
  }

  /// The summary must have been made from these files by this version.
  void CheckSummary(const std::filesystem::path& folder) {
    std::string why;
    const auto text = plan::ReadInputFile((folder / kSuiteSummary).string(), why);
    if (!text)
      Fault("{}: {}; `cdb suite` writes it", kSuiteSummary, why);
    else if (*text != SuiteSummary(read_))
      Fault("{}: it is not the summary of these results", kSuiteSummary);
  }

  const SuiteFolder& read_;
  SuiteFaults made_;
};

}  // namespace

SuiteFaults CheckSuite(const SuiteFolder& read, const std::filesystem::path& folder) {
  return Checker(read).All(folder);
}

}  // namespace cdb::plans
