#include "runtime/compare/setup.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <set>
#include <utility>

#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"
#include "runtime/figures/points.h"

namespace cdb::compare {
namespace {

/// Facts of /provenance, with their names in the output.
constexpr std::pair<const char*, const char*> kFacts[] = {
    {"cdb_version", "cdb"},
    {"commit", "commit of cdb"},
    {"bullet_version", "Bullet"},
    {"build_type", "build"},
    {"compiler", "compiler"},
    {"compiler_flags", "compiler flags"},
    {"host", "host"},
    {"cpu", "CPU"},
    {"cpus", "processors"},
    {"memory", "memory"},
    {"cpu_governor", "CPU governor"},
    {"system", "system"},
    {"kernel", "kernel"},
    {"jobs", "runs at a time (jobs)"},
    {"plugins", "--plugin"},
};

/// False for parameters that control how a scene is run and measured, not its contents.
bool IsOfTheScene(std::string_view name) {
  const schema::Parameter* parameter = schema::FindParameter(name, false);
  return parameter == nullptr || parameter->concern != schema::Concern::kMeasurement;
}

/// The parameters that differ between the scenes, by name, with the distinct values of both files.
class SceneDifferences {
 public:
  void Add(const plan::Scene& a, const plan::Scene& b) {
    AddSettings("", a.world, b.world);
    const std::size_t groups = std::max(a.groups.size(), b.groups.size());
    for (std::size_t i = 0; i < groups; ++i) {
      const std::string name_a = i < a.groups.size() ? a.groups[i].name : "none",
                        name_b = i < b.groups.size() ? b.groups[i].name : "none";
      if (name_a != name_b) {
        AddTexts("group of objects", name_a, name_b);
      } else {
        AddSettings(name_a + ".", a.groups[i].settings, b.groups[i].settings);
      }
    }
    if (a.seeds != b.seeds) AddTexts("random streams", "other seeds", "other seeds");
    for (const schema::PluginDetector& plugin : a.plugins) {
      const auto other = std::ranges::find(b.plugins, plugin.name, &schema::PluginDetector::name);
      if (other != b.plugins.end() && other->sha256 != plugin.sha256)
        AddTexts("plug-in of " + plugin.name, plugin.sha256.substr(0, 12),
                 other->sha256.substr(0, 12));
    }
  }

  /// The differences in parameters of the scene, or in the others.
  std::vector<SetupDifference> List(bool of_the_scene) const {
    std::vector<SetupDifference> list;
    for (const auto& [name, texts] : found_) {
      const bool is_plugin = name.starts_with("plug-in of ");
      if ((!is_plugin && IsOfTheScene(name)) == of_the_scene)
        list.push_back({name, Joined(texts.first), Joined(texts.second)});
    }
    return list;
  }

 private:
  static constexpr std::size_t kMostTexts = 4;

  static std::string Joined(const std::vector<std::string>& texts) {
    std::string text;
    for (std::size_t i = 0; i < std::min(texts.size(), kMostTexts); ++i)
      text += (i == 0 ? "" : ", ") + texts[i];
    return texts.size() > kMostTexts ? text + ", …" : text;
  }

  void AddTexts(const std::string& name, const std::string& a, const std::string& b) {
    auto& [of_a, of_b] = found_[name];
    if (std::ranges::find(of_a, a) == of_a.end()) of_a.push_back(a);
    if (std::ranges::find(of_b, b) == of_b.end()) of_b.push_back(b);
  }

  void AddSettings(const std::string& group, const plan::Settings& a, const plan::Settings& b) {
    for (const schema::Parameter& parameter : schema::Schema()) {
      if (parameter.grouped == group.empty()) continue;
      const schema::Value &of_a = a.ValueOf(parameter), &of_b = b.ValueOf(parameter);
      if (of_a != of_b)
        AddTexts(group + std::string(parameter.name), schema::LabelOf(of_a), schema::LabelOf(of_b));
    }
  }

  std::map<std::string, std::pair<std::vector<std::string>, std::vector<std::string>>> found_;
};

/// The scene of each point, from the plan.
std::map<figures::Point, const plan::Scene*> ScenesOf(const plan::Plan& plan) {
  std::map<figures::Point, const plan::Scene*> scenes;
  for (const plan::Run& run : plan.runs) scenes.emplace(run.at, &run.scene);
  return scenes;
}

std::vector<SetupDifference> ComparePlans(const ComparedFile& a, const ComparedFile& b,
                                          const PointMatch& match,
                                          std::vector<std::string>& notes) {
  for (const ComparedFile* of : {&a, &b})
    if (!of->plan)
      notes.push_back(
          fmt::format("{} was written by a version of cdb with other plans, so that its scenes "
                      "cannot be compared: make sure that they are those of the other file",
                      of->name));
  if (!a.plan || !b.plan) return {};
  const auto scenes_a = ScenesOf(*a.plan), scenes_b = ScenesOf(*b.plan);
  SceneDifferences differences;
  for (const MatchedPoint& point : match.points) {
    const auto of_a = scenes_a.find(point.a), of_b = scenes_b.find(point.b);
    if (of_a != scenes_a.end() && of_b != scenes_b.end())
      differences.Add(*of_a->second, *of_b->second);
  }
  std::string unlike;
  for (const SetupDifference& of : differences.List(true))
    unlike += fmt::format("{}{} ({} in {}, {} in {})", unlike.empty() ? "" : "; ", of.name, of.a,
                          a.name, of.b, b.name);
  if (!unlike.empty())
    throw files::StoreError(
        fmt::format("{} and {} are of unlike scenes: {}; a difference between them would be that "
                    "of the scenes. Run the same scenario with both, or sweep the parameter in one "
                    "file and use `cdb show`",
                    a.name, b.name, unlike));
  return differences.List(false);
}

/// The start times of the runs of a file, s since 1970; sorted.
std::vector<double> StartsOf(const ComparedFile& of) {
  std::vector<double> starts;
  if (!of.file.Has("started")) return starts;
  for (const store::ResultFile::Cell& cell : figures::AllCells(of.file))
    if (const double started = of.file.ReadReal("started", cell); started > 0)
      starts.push_back(started);
  std::ranges::sort(starts);
  return starts;
}

/// Adds a note if the machine may have changed between the files. No note for two machines, or if
/// the times are unknown.
void CompareOccasions(const ComparedFile& a, const ComparedFile& b, SetupComparison& setup) {
  if (a.file.ReadProvenance("host") != b.file.ReadProvenance("host")) return;
  const std::vector<double> of_a = StartsOf(a), of_b = StartsOf(b);
  if (of_a.empty() || of_b.empty()) return;
  const double both = std::fmin(of_a.back(), of_b.back()) - std::fmax(of_a[0], of_b[0]);
  const double shorter = std::fmin(of_a.back() - of_a[0], of_b.back() - of_b[0]);
  setup.is_interleaved = both > shorter / 2;
  if (setup.is_interleaved) return;
  const bool a_first = of_a[0] < of_b[0];
  const double gap = a_first ? of_b[0] - of_a.back() : of_a[0] - of_b.back();
  setup.notes.push_back(fmt::format(
      "{} ran after {}, {} later: a change of the machine in between is in every ratio. Interleave "
      "the runs (cdb doc compare)",
      a_first ? b.name : a.name, a_first ? a.name : b.name,
      gap < 120    ? fmt::format("{:.0f} s", std::fmax(0, gap))
      : gap < 7200 ? fmt::format("{:.0f} min", gap / 60)
      : gap < 2e5  ? fmt::format("{:.0f} h", gap / 3600)
                   : fmt::format("{:.0f} days", gap / 86400)));
}

}  // namespace

SetupComparison CompareSetups(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match) {
  SetupComparison setup;
  setup.parameters = ComparePlans(a, b, match, setup.notes);
  if (a.file.benchmark() != b.file.benchmark())
    setup.parameters.insert(setup.parameters.begin(),
                            {"benchmark", a.file.benchmark(), b.file.benchmark()});
  for (const auto& [key, name] : kFacts) {
    const std::string of_a = a.file.ReadProvenance(key), of_b = b.file.ReadProvenance(key);
    if (of_a == of_b) continue;
    setup.machine.push_back({name, of_a.empty() ? "-" : of_a, of_b.empty() ? "-" : of_b});
  }
  for (const ComparedFile* of : {&a, &b})
    if (const std::string build = of->file.ReadProvenance("build_type"); build != "Release")
      setup.notes.push_back(
          fmt::format("{} was timed with a {} build of cdb: these are not timings to quote",
                      of->name, build.empty() ? "unknown" : build));
  CompareOccasions(a, b, setup);
  return setup;
}

}  // namespace cdb::compare
