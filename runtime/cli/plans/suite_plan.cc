#include "runtime/cli/plans/suite_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "compiler/analysis/reference.h"
#include "compiler/plan/input_file.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/points.h"
#include "runtime/pages/page/page.h"
#include "runtime/printers/json_points.h"
#include "runtime/printers/results_document.h"
#include "runtime/results/files/safe_file.h"

namespace cdb::plans {
namespace {

using plan::Plan;

void SetSeed(std::uint64_t seed, plan::Scene& scene) {
  scene.world.Set("seed", seed);
  for (auto& [name, stream] : scene.seeds) stream = plan::StreamSeed(seed, name);
}

/// The first repeat of each point, changed by `change`, once for each new repeat.
template <typename Change>
std::vector<plan::Run> Repeated(const Plan& plan, std::uint64_t repeats, Change change) {
  std::vector<plan::Run> runs;
  for (const plan::Run& first : plan.runs) {
    if (first.rep != 0) continue;
    plan::Run run = first;
    run.scene.world.Set("repeats", repeats);
    change(run);
    for (run.rep = 0; run.rep < repeats; ++run.rep) {
      run.id = plan::RunId(run.scene, run.rep);
      runs.push_back(run);
    }
  }
  return runs;
}

/// Puts an axis of seeds in front.
Plan MakeLong(const Plan& plan) {
  Plan made = plan;
  plan::Axis axis{"seed", "seed", "", {}};
  made.repeats = kLongRepeats;
  made.runs.clear();
  made.skipped.clear();
  for (const std::uint64_t seed : kLongSeeds) {
    const std::size_t place = axis.values.size();
    axis.values.emplace_back(static_cast<double>(seed));
    for (plan::Run& run : Repeated(plan, kLongRepeats, [&](plan::Run& of) {
           SetSeed(seed, of.scene);
           of.at.insert(of.at.begin(), place);
         }))
      made.runs.push_back(std::move(run));
    for (std::vector<std::size_t> at : plan.skipped) {
      at.insert(at.begin(), place);
      made.skipped.push_back(std::move(at));
    }
  }
  made.axes.insert(made.axes.begin(), std::move(axis));
  return made;
}

Plan WithSeed(const Plan& plan, std::uint64_t seed) {
  Plan made = plan;
  made.runs = Repeated(plan, plan.repeats, [&](plan::Run& run) { SetSeed(seed, run.scene); });
  return made;
}

/// Adds runs of these detectors, like those of the baseline's detector.
void AddDetectors(const std::vector<std::string>& names,
                  const std::vector<schema::PluginDetector>& plugins, Plan& plan) {
  const auto axis = std::ranges::find(plan.axes, "detector", &plan::Axis::parameter);
  if (axis == plan.axes.end()) return;
  const auto place = static_cast<std::size_t>(axis - plan.axes.begin());
  for (const std::string& name : names) {
    if (std::ranges::find(axis->values, plan::Coordinate(name)) != axis->values.end())
      throw options::CommandError(fmt::format("--detector {}: it is already in the suite", name));
    // They have no narrow phase beside their own or Bullet's either.
    const std::vector<std::vector<std::size_t>> skipped = plan.skipped;
    for (std::vector<std::size_t> at : skipped) {
      if (at[place] != 0) continue;
      at[place] = axis->values.size();
      plan.skipped.push_back(std::move(at));
    }
    const std::vector<plan::Run> before = plan.runs;
    for (plan::Run run : before) {
      if (run.at[place] != 0) continue;
      run.at[place] = axis->values.size();
      run.scene.world.Set("detector", schema::Word{name});
      for (const schema::PluginDetector& plugin : plugins)
        if (plugin.name == name) run.scene.plugins.push_back(plugin);
      run.id = plan::RunId(run.scene, run.rep);
      plan.runs.push_back(std::move(run));
    }
    axis->values.emplace_back(name);
  }
  std::ranges::sort(plan.runs, {}, [](const plan::Run& run) { return std::tie(run.at, run.rep); });
  std::ranges::sort(plan.skipped);
}

}  // namespace

Plan StandardPlan(const figures::StandardScene& scene, const SuiteChoice& choice) {
  const std::filesystem::path library = options::ScenarioLibrary();
  const std::filesystem::path file = library / (scene.File() + ".cdb");
  std::error_code error;
  if (library.empty() || !std::filesystem::is_regular_file(file, error))
    throw options::CommandError(fmt::format(
        "the scene {} of the standard suite is not installed beside this program; install cdb",
        scene.Id()));
  std::vector<schema::PluginDetector> named;
  // No lints: the suite measures these weaknesses of Bullet on purpose.
  auto plans =
      options::LoadPlans(file.string(), {}, options::LintText::kNone, choice.plugins, &named);
  if (plans.size() != 1 || plans[0].benchmark + ".h5" != scene.ResultName())
    throw options::CommandError(
        fmt::format("'{}' is not the scene {} of the standard suite; install cdb "
                    "again",
                    file.string(), scene.Id()));
  options::CheckWords("detector", choice.detectors, named);
  Plan plan = std::move(plans[0]);
  if (choice.is_long) plan = MakeLong(plan);
  if (choice.seed) plan = WithSeed(plan, *choice.seed);
  AddDetectors(choice.detectors, named, plan);
  analysis::AddReferences(plan);
  return plan;
}

namespace fs = std::filesystem;

namespace {

bool IsLong(const results::ResultFile& file) {
  return std::ranges::any_of(file.axes(),
                             [](const plan::Axis& axis) { return axis.parameter == "seed"; });
}

}  // namespace

std::string FileSha256(const fs::path& file) {
  std::string why;
  const auto bytes = plan::ReadInputFile(file.string(), why);
  if (!bytes) throw options::CommandError(fmt::format("{}: {}", file.string(), why));
  return plan::Sha256Hex(*bytes);
}

std::optional<int> VersionOf(const std::string& summary) {
  const auto json = printers::Json::parse(summary, nullptr, false);
  const auto version = json.is_object() ? json.find("suite") : json.end();
  if (version == json.end() || !version->is_number_integer()) return std::nullopt;
  return version->get<int>();
}

namespace {

/// Members whose values are sentences.
bool IsProse(const std::string& member) {
  return member == "defaults" || member == "answer" || member == "what" || member == "doc" ||
         member == "fault" || member == "faults";
}
/// Members that summaries of earlier cdbs of this version of the suite do not have.
bool IsNew(const std::string& member) { return member == "measured"; }

bool IsEmpty(const printers::Json& value) {
  return value.is_null() || (value.is_array() && value.empty()) || value == "";
}

/// Of sentences, only whether there are any.
bool HaveSameFigures(const printers::Json& a, const printers::Json& b) {
  if (a.is_object() && b.is_object()) {
    const auto has_those_of = [](const printers::Json& one, const printers::Json& other) {
      return std::ranges::all_of(other.items(), [&](const auto& member) {
        return one.contains(member.key()) || IsNew(member.key());
      });
    };
    if (!has_those_of(a, b) || !has_those_of(b, a)) return false;
    for (const auto& [name, value] : a.items()) {
      const auto other = b.find(name);
      if (other == b.end()) continue;
      if (IsProse(name) ? IsEmpty(value) != IsEmpty(*other) : !HaveSameFigures(value, *other))
        return false;
    }
    return true;
  }
  if (!a.is_array() || !b.is_array()) return a == b;
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), HaveSameFigures);
}

}  // namespace

bool HasFiguresOf(const std::string& summary, const std::string& other) {
  const auto a = printers::Json::parse(summary, nullptr, false),
             b = printers::Json::parse(other, nullptr, false);
  for (const char* member : {"suite", "kinds", "scenes"})
    if (!a.is_object() || !b.is_object() || !a.contains(member) || !b.contains(member))
      return false;
  return HaveSameFigures(a, b);
}

SuiteFolder ReadSuiteFolder(const fs::path& folder) {
  SuiteFolder read;
  std::error_code error;
  for (const figures::StandardScene& scene : figures::StandardScenes()) {
    const fs::path file = folder / scene.ResultName();
    if (!fs::exists(file, error)) {
      read.facts.missing.push_back(scene.Id());
      continue;
    }
    auto of = std::make_unique<figures::ComparedFile>(file, file.string());
    read.scenes.push_back(figures::CollectScene(scene, of->model));
    read.facts.sha256[scene.ResultName()] = FileSha256(file);
    read.files.push_back(std::move(of));
  }
  if (read.files.empty())
    throw options::CommandError(
        fmt::format("'{}' has no results of the standard suite; `cdb suite -o {}` makes them",
                    folder.string(), folder.string()));
  const figures::ComparedFile& first = *read.files[0];
  read.facts.is_long = IsLong(first.file);
  if (!read.facts.is_long && first.plan && !first.plan->runs.empty()) {
    const std::uint64_t seed = first.plan->runs[0].scene.world.Count("seed");
    if (seed != kLongSeeds[0]) read.facts.seed = seed;
  }
  return read;
}

void RequireThisVersion(const fs::path& folder) {
  std::string why;
  const auto text = plan::ReadInputFile((folder / kSuiteSummary).string(), why);
  const auto version = text ? VersionOf(*text) : std::nullopt;
  if (version && *version != figures::kSuiteVersion)
    throw options::CommandError(
        fmt::format("the results in '{}' are of version {} of the suite, and this cdb has version "
                    "{}: scenes and settings differ; run both with one cdb",
                    folder.string(), *version, figures::kSuiteVersion));
}

std::string SuiteSummary(const SuiteFolder& read) {
  std::vector<const results::ResultFile*> files;
  for (const auto& of : read.files) files.push_back(&of->file);
  return printers::SuiteJson(read.scenes, files, read.facts);
}

void WriteSuiteSummary(const SuiteFolder& read, const fs::path& folder) {
  const std::string summary = SuiteSummary(read);
  files::WriteWhole(summary, folder / kSuiteSummary);
  std::string documents;
  for (const auto& of : read.files) {
    if (!documents.empty()) documents += ',';
    documents += printers::ResultsDocument(
                     of->file, {.file = fs::path(of->name).filename().string(), .for_page = true})
                     .text;
  }
  files::WriteWhole(
      page::Assemble(page::ReportTemplate(), "The standard suite of cdb",
                     fmt::format("{{\"suite\":{},\"documents\":[{}]}}", summary, documents)),
      folder / kSuitePage);
}

// Checks whether results of the standard suite are complete and comparable (`cdb suite --check`).

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
    else if (const auto version = VersionOf(*text).value_or(figures::kSuiteVersion);
             version != figures::kSuiteVersion)
      Fault("{}: it is of version {} of the suite, and this cdb has version {}", kSuiteSummary,
            version, figures::kSuiteVersion);
    else if (const std::string own = SuiteSummary(read_); !HasFiguresOf(*text, own))
      Fault("{}: it is not the summary of these results", kSuiteSummary);
    else if (*text != own)
      made_.facts.push_back(fmt::format(
          "{}: the figures are those of these results; its sentences are of another version of cdb",
          kSuiteSummary));
  }

  const SuiteFolder& read_;
  SuiteFaults made_;
};

}  // namespace

SuiteFaults CheckSuite(const SuiteFolder& read, const std::filesystem::path& folder) {
  return Checker(read).All(folder);
}

}  // namespace cdb::plans
