#include "runtime/figures/compare.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <set>
#include <utility>

#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"
#include "runtime/figures/points.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// The selected part of a file. Axes that it does not have are ignored, values that it does not
/// have too if it has others of the selection.
results::ResultFile ReadSelected(const std::filesystem::path& path, const std::string& name,
                                 const std::vector<std::string>& selections) {
  results::ResultFile file(path);
  std::map<std::size_t, std::set<std::size_t>> selected;
  for (const std::string& word : selections) {
    const AxisSelection selection = ParseSelection(word);
    const auto axis = std::ranges::find(file.axes(), selection.axis, &plan::Axis::name);
    if (axis == file.axes().end()) continue;
    const NamedValues values = FindValues(*axis, selection.text);
    selected[static_cast<std::size_t>(axis - file.axes().begin())].insert(values.indices.begin(),
                                                                          values.indices.end());
  }
  for (const auto& [axis, values] : selected) {
    if (values.empty())
      throw files::StoreError(fmt::format("--select {}: {} has none of these values; it has {}",
                                          file.axes()[axis].name, name,
                                          ValuesText(file.axes()[axis])));
    file.Select(axis, {values.begin(), values.end()});
  }
  return file;
}

void CheckSelections(const std::vector<std::unique_ptr<ComparedFile>>& files,
                     const std::vector<std::string>& selections) {
  std::vector<std::string> names;
  for (const auto& of : files)
    for (const plan::Axis& axis : of->file.axes())
      if (std::ranges::find(names, axis.name) == names.end()) names.push_back(axis.name);
  for (const std::string& word : selections)
    if (const std::string axis = ParseSelection(word).axis;
        std::ranges::find(names, axis) == names.end())
      throw files::StoreError(
          fmt::format("--select: there is no axis '{}'{}", axis,
                      names.empty() ? std::string(": the files have none, only one point")
                                    : fmt::format("; there are {}", fmt::join(names, ", "))));
}

class Matcher {
 public:
  Matcher(const ComparedFile& a, const ComparedFile& b) : a_{a, {}}, b_{b, {}} {}

  PointMatch Match() {
    ChooseAxes();
    MatchPoints();
    if (match_.points.empty())
      throw UnlikeScenes(fmt::format("{} and {} have no point in common: {}; {}", a_.of.name,
                                     b_.of.name, FirstOf(a_, match_.only_a),
                                     FirstOf(b_, match_.only_b)));
    return std::move(match_);
  }

 private:
  struct Side {
    const ComparedFile& of;
    std::vector<std::size_t> axes;  ///< those of the match, in the order of the match
  };
  using Key = std::vector<plan::Coordinate>;

  static std::string FirstOf(const Side& side, const std::vector<std::string>& points) {
    return fmt::format("{} has {}{}", side.of.name, points.empty() ? "none" : points[0],
                       points.size() > 1 ? ", …" : "");
  }

  /// For an axis that the other file lacks.
  void IgnoreAxis(const ComparedFile& of, const plan::Axis& axis) {
    if (axis.values.size() > 1)
      throw UnlikeScenes(fmt::format(
          "only {} has the axis '{}' ({}): choose one of its values, such as --select {}={}",
          of.name, axis.name, ValuesText(axis), axis.name, terminal::CoordinateText(axis, 0)));
    match_.notes.push_back(fmt::format("only {} has the axis {}, with the value {}", of.name,
                                       axis.name, ValuesText(axis)));
  }

  void ChooseAxes() {
    const std::vector<plan::Axis>&axes_a = a_.of.file.axes(), &axes_b = b_.of.file.axes();
    bool group_is_detector = false;
    for (std::size_t i = 0; i < axes_a.size(); ++i) {
      const plan::Axis& axis = axes_a[i];
      const auto other = std::ranges::find(axes_b, axis.name, &plan::Axis::name);
      if (other == axes_b.end()) {
        IgnoreAxis(a_.of, axis);
        continue;
      }
      if (axis.values.size() == 1 && other->values.size() == 1 && axis.values != other->values) {
        match_.notes.push_back(fmt::format("{}: {} in {}, {} in {}", axis.name,
                                           terminal::CoordinateText(axis, 0), a_.of.name,
                                           terminal::CoordinateText(*other, 0), b_.of.name));
        continue;
      }
      if (axis.IsText() &&
          (!match_.group || (axis.parameter == "detector" && !group_is_detector))) {
        match_.group = match_.axes.size();
        group_is_detector = axis.parameter == "detector";
      }
      match_.axes.push_back(axis.name);
      match_.is_text.push_back(axis.IsText());
      a_.axes.push_back(i);
      b_.axes.push_back(static_cast<std::size_t>(other - axes_b.begin()));
    }
    std::map<std::string, const plan::Axis*> only_b;
    for (const plan::Axis& axis : axes_b)
      if (std::ranges::find(axes_a, axis.name, &plan::Axis::name) == axes_a.end())
        only_b[axis.name] = &axis;
    for (const auto& [name, axis] : only_b) IgnoreAxis(b_.of, *axis);
  }

  /// The points that ran, keyed by their values on the axes of the match.
  static std::vector<std::pair<Key, Point>> PointsOf(const Side& side) {
    std::vector<std::pair<Key, Point>> points;
    for (const GridPoint& point : side.of.model.grid()) {
      Key key;
      for (const std::size_t axis : side.axes)
        key.push_back(side.of.model.axis(axis).values[point.at[axis]]);
      points.emplace_back(std::move(key), point.at);
    }
    return points;
  }

  static std::vector<std::string> PlaceOf(const Side& side, const Point& at) {
    std::vector<std::string> place;
    for (const std::size_t axis : side.axes)
      place.push_back(terminal::CoordinateText(side.of.model.axis(axis), at[axis]));
    return place;
  }

  void MatchPoints() {
    const auto of_b = PointsOf(b_);
    std::map<Key, Point> left(of_b.begin(), of_b.end());
    for (const auto& [key, at] : PointsOf(a_)) {
      MatchedPoint point = {at, {}, PlaceOf(a_, at)};
      const auto found = left.find(key);
      if (found == left.end()) {
        match_.only_a.push_back(point.PlaceText(match_.axes));
        continue;
      }
      point.b = found->second;
      left.erase(found);
      match_.points.push_back(std::move(point));
    }
    for (const auto& [key, at] : of_b)
      if (left.contains(key))
        match_.only_b.push_back(MatchedPoint{{}, at, PlaceOf(b_, at)}.PlaceText(match_.axes));
  }

  Side a_, b_;
  PointMatch match_;
};

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
    {"settings", "--set"},
};

/// False for parameters that control how a scene is run and measured, not its contents.
bool IsOfTheScene(std::string_view name) {
  const schema::Parameter* parameter = schema::FindParameter(name, false);
  return parameter == nullptr || parameter->concern != schema::Concern::kMeasurement;
}

/// As a scenario writes it: `1/300` for a time step, `0xAAAAAAAAAA` for a large seed.
std::string SettingText(const schema::Parameter& parameter, const schema::Value& value) {
  if (const auto* number = std::get_if<schema::Number>(&value)) {
    const double inverse = 1 / number->AsReal();
    if (parameter.unit == "s" && inverse > 1.5 &&
        std::fabs(inverse - std::round(inverse)) < 1e-9 * inverse)
      return fmt::format("1/{:.0f}", inverse);
    if (parameter.name == "seed" && number->AsReal() >= 1e9)
      return fmt::format("{:#X}", number->AsCount()).replace(0, 2, "0x");
  }
  return schema::LabelOf(value);
}

/// The parameters that differ between the scenes, by name, with the distinct values of both files.
class SceneDifferences {
 public:
  void Add(const plan::Scene& a, const plan::Scene& b) {
    AddSettings("", a.world, b.world);
    AddNamed("group of objects", a.groups, b.groups);
    AddNamed("joint", a.joints, b.joints);
    AddNamed("queries", a.queries, b.queries);
    // The streams follow from the distributions, and their seeds from `seed`.
    if (a.seeds != b.seeds && a.world.Count("seed") == b.world.Count("seed"))
      AddTexts("random streams", StreamsOnlyIn(a, b), StreamsOnlyIn(b, a));
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
  /// Groups, joints or queries.
  template <typename Part>
  void AddNamed(const std::string& what, const std::vector<Part>& a, const std::vector<Part>& b) {
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
      const std::string name_a = i < a.size() ? a[i].name : "none",
                        name_b = i < b.size() ? b[i].name : "none";
      if (name_a != name_b) {
        AddTexts(what, name_a, name_b);
      } else {
        AddSettings(name_a + ".", a[i].settings, b[i].settings);
      }
    }
  }
  static constexpr std::size_t kMostTexts = 4;

  static std::string Joined(const std::vector<std::string>& texts) {
    std::string text;
    for (std::size_t i = 0; i < std::min(texts.size(), kMostTexts); ++i)
      text += (i == 0 ? "" : ", ") + texts[i];
    return texts.size() > kMostTexts ? text + ", …" : text;
  }

  /// `objects.size`; `-` if there is none.
  static std::string StreamsOnlyIn(const plan::Scene& scene, const plan::Scene& other) {
    std::string names;
    for (const auto& [name, seed] : scene.seeds)
      if (!other.seeds.contains(name)) names += (names.empty() ? "" : " ") + name;
    return names.empty() ? "-" : names;
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
        AddTexts(group + std::string(parameter.OwnName()), SettingText(parameter, of_a),
                 SettingText(parameter, of_b));
    }
  }

  std::map<std::string, std::pair<std::vector<std::string>, std::vector<std::string>>> found_;
};

/// The scene of each point, from the plan.
std::map<Point, const plan::Scene*> ScenesOf(const plan::Plan& plan) {
  std::map<Point, const plan::Scene*> scenes;
  for (const plan::Run& run : plan.runs) scenes.emplace(run.at, &run.scene);
  return scenes;
}

void ComparePlans(const ComparedFile& a, const ComparedFile& b, const PointMatch& match,
                  SetupComparison& setup) {
  for (const ComparedFile* of : {&a, &b})
    if (!of->plan)
      setup.notes.push_back(
          fmt::format("{} was written by a version of cdb with other plans, so its scenes cannot "
                      "be compared: make sure that they are the same as those of the other file",
                      of->name));
  if (!a.plan || !b.plan) return;
  const auto scenes_a = ScenesOf(*a.plan), scenes_b = ScenesOf(*b.plan);
  SceneDifferences differences;
  for (const MatchedPoint& point : match.points) {
    const auto of_a = scenes_a.find(point.a), of_b = scenes_b.find(point.b);
    if (of_a != scenes_a.end() && of_b != scenes_b.end())
      differences.Add(*of_a->second, *of_b->second);
  }
  setup.scenes = differences.List(true);
  setup.parameters = differences.List(false);
}

void RefuseUnlikeScenes(const ComparedFile& a, const ComparedFile& b,
                        const std::vector<SetupDifference>& scenes) {
  std::string unlike;
  for (const SetupDifference& of : scenes)
    unlike += fmt::format("{}{} ({} in {}, {} in {})", unlike.empty() ? "" : "; ", of.name, of.a,
                          a.name, of.b, b.name);
  if (!unlike.empty())
    throw UnlikeScenes(fmt::format("{} and {} have different scenes: {}", a.name, b.name, unlike),
                       scenes);
}

/// The start times of the runs of a file, s since 1970; sorted.
std::vector<double> StartsOf(const ComparedFile& of) {
  std::vector<double> starts;
  if (!of.file.Has("started")) return starts;
  for (const results::ResultFile::Cell& cell : AllCells(of.file))
    if (const double started = of.file.ReadReal("started", cell); started > 0)
      starts.push_back(started);
  std::ranges::sort(starts);
  return starts;
}

/// Adds a note if the machine may have changed between the files. No note for two machines, or if
/// the times are unknown.
void CompareOccasions(const ComparedFile& a, const ComparedFile& b, SetupComparison& setup) {
  if (a.CountsInstructions() && b.CountsInstructions()) {
    // Another model of processor has other instructions, and the C library chooses among them.
    if (a.file.ReadProvenance("cpu") != b.file.ReadProvenance("cpu"))
      setup.doubt = "the processors differ";
    return;
  }
  if (a.file.ReadProvenance("host") != b.file.ReadProvenance("host")) {
    setup.doubt = "the machines differ";
    return;
  }
  const std::vector<double> of_a = StartsOf(a), of_b = StartsOf(b);
  if (of_a.empty() || of_b.empty()) return;
  const double both = std::fmin(of_a.back(), of_b.back()) - std::fmax(of_a[0], of_b[0]);
  const double shorter = std::fmin(of_a.back() - of_a[0], of_b.back() - of_b[0]);
  setup.is_interleaved = both > shorter / 2;
  if (setup.is_interleaved) return;
  setup.doubt = "the runs were not interleaved";
  const bool a_first = of_a[0] < of_b[0];
  const double gap = a_first ? of_b[0] - of_a.back() : of_a[0] - of_b.back();
  setup.notes.push_back(
      fmt::format("{} ran after {}, {} later: a change of the machine in between affects every "
                  "ratio. Interleave the runs (cdb doc compare)",
                  a_first ? b.name : a.name, a_first ? a.name : b.name,
                  gap < 120    ? fmt::format("{:.0f} s", std::fmax(0, gap))
                  : gap < 7200 ? fmt::format("{:.0f} min", gap / 60)
                  : gap < 2e5  ? fmt::format("{:.0f} h", gap / 3600)
                               : fmt::format("{:.0f} days", gap / 86400)));
}

/// Throws UnlikeScenes as MatchPoints does; for different benchmarks, the message begins with that.
PointMatch MatchBenchmarks(const ComparedFile& a, const ComparedFile& b) {
  try {
    return MatchPoints(a, b);
  } catch (const UnlikeScenes& error) {
    if (a.file.benchmark() == b.file.benchmark()) throw;
    throw UnlikeScenes(fmt::format("{} has the benchmark '{}', but {} has '{}': {}", a.name,
                                   a.file.benchmark(), b.name, b.file.benchmark(), error.what()));
  }
}

}  // namespace

ComparedFile::ComparedFile(const std::filesystem::path& path, std::string name_of,
                           const std::vector<std::string>& selections)
    : name(std::move(name_of)),
      file(ReadSelected(path, name, selections)),
      plan(ReadPlan(file)),
      model(file) {}

std::string MatchedPoint::PlaceText(const std::vector<std::string>& axes) const {
  std::string text;
  for (std::size_t i = 0; i < axes.size(); ++i)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", axes[i], place[i]);
  return text.empty() ? "the only point" : text;
}

PointMatch MatchPoints(const ComparedFile& a, const ComparedFile& b) {
  return Matcher(a, b).Match();
}

SetupComparison CompareSetups(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match) {
  SetupComparison setup;
  ComparePlans(a, b, match, setup);
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
      setup.notes.push_back(fmt::format("{} was {} with a {} build of cdb: do not quote its {}",
                                        of->name, of->CountsInstructions() ? "counted" : "timed",
                                        build.empty() ? "unknown" : build,
                                        of->CountsInstructions() ? "counts" : "timings"));
  CompareOccasions(a, b, setup);
  return setup;
}

FileComparison CompareFiles(const ComparedFile& a, const ComparedFile& b,
                            const CompareOptions& options) {
  FileComparison made = {&a, &b, MatchBenchmarks(a, b), {}, {}, {}, {}};
  made.setup = CompareSetups(a, b, made.match);
  if (options.gate.Fails(Finding::kScenes)) RefuseUnlikeScenes(a, b, made.setup.scenes);
  made.states = CompareStates(a, b, made.match);
  made.facts = CompareFacts(a, b, made.match);
  made.times = CompareTimes(a, b, made.match, options.phase);
  if (options.is_relative && !made.times.common)
    throw files::StoreError(
        fmt::format("--relative needs {} detectors or more, whose median shows the common change; "
                    "{} and {} have {}",
                    TimeComparison::kLeastGroups, a.name, b.name, made.times.groups.size()));
  return made;
}

const JudgedChange& JudgementOf(const TimeChange& change, const CompareOptions& options) {
  return options.is_relative ? change.relative : change.absolute;
}

BenchmarkHistory MakeHistory(const std::vector<std::filesystem::path>& paths,
                             const std::vector<std::string>& names, const CompareOptions& options) {
  BenchmarkHistory made;
  for (std::size_t i = 0; i < paths.size(); ++i)
    made.files.push_back(std::make_unique<ComparedFile>(paths[i], names[i], options.select));
  CheckSelections(made.files, options.select);
  for (std::size_t i = 1; i < made.files.size(); ++i) {
    made.steps.push_back(CompareFiles(*made.files[i - 1], *made.files[i], options));
    if (i > 1) made.to_first.push_back(CompareFiles(*made.files[0], *made.files[i], options));
  }
  return made;
}

void JudgeHistories(std::vector<BenchmarkHistory>& benchmarks, const CompareOptions& options) {
  std::vector<TimeComparison*> all;
  for (BenchmarkHistory& benchmark : benchmarks)
    for (auto* comparisons : {&benchmark.steps, &benchmark.to_first})
      for (FileComparison& of : *comparisons) all.push_back(&of.times);
  JudgeTimes(all, options.gate.LimitOf(Finding::kSlower));
}

namespace {

// clang-format off
constexpr std::array<FindingInfo, kFindingCount> kFindings = {{
    {.finding = Finding::kSlower, .word = "slower", .text = "slower", .fails = true, .has_limit = true},
    {.finding = Finding::kMemory, .word = "memory", .text = "more memory", .fails = true, .has_limit = true},
    {.finding = Finding::kStability, .word = "stability", .text = "less stable", .fails = true, .has_limit = false},
    {.finding = Finding::kAccuracy, .word = "accuracy", .text = "less accurate", .fails = true, .has_limit = true},
    {.finding = Finding::kPairs, .word = "pairs", .text = "other pairs", .fails = true, .has_limit = false},
    {.finding = Finding::kPhysics, .word = "physics", .text = "other physics", .fails = false, .has_limit = false},
    {.finding = Finding::kMissing, .word = "missing", .text = "missing", .fails = true, .has_limit = false},
    {.finding = Finding::kScenes, .word = "scenes", .text = "other scenes", .fails = true, .has_limit = false},
    {.finding = Finding::kUnsure, .word = "unsure", .text = "cannot tell", .fails = false, .has_limit = false},
}};
// clang-format on

/// The findings of a comparison, by kind.
class Finder {
 public:
  Finder(const FileComparison& comparison, const CompareOptions& options)
      : of_(comparison), options_(options) {}

  std::vector<Found> Find() {
    AddTimes();
    AddFacts();
    AddStates();
    for (const std::string& place : of_.match.only_a) Add(Finding::kMissing, place);
    for (const SetupDifference& difference : of_.setup.scenes)
      Add(Finding::kScenes, difference.name);
    std::vector<Found> list;
    for (auto& [finding, what] : found_) list.push_back({finding, std::move(what)});
    return list;
  }

 private:
  std::string PlaceOf(std::size_t point) const {
    return of_.match.points[point].PlaceText(of_.match.axes);
  }
  void Add(Finding finding, std::string what) { found_[finding].push_back(std::move(what)); }

  void AddStates() {
    const auto add = [&](Finding finding, const std::vector<std::size_t>& points,
                         const char* of_one) {
      for (const std::size_t point : points)
        Add(finding, of_.match.points.size() > 1 ? PlaceOf(point) : of_one);
    };
    if (!of_.states.of_pairs) add(Finding::kPhysics, of_.states.other, "last state");
    add(Finding::kPhysics, of_.states.unsettled, "last state");
    if (!of_.HasExactPairs() && !of_.HasOtherDetectors())
      add(Finding::kPairs, of_.OtherPairs(), "pairs");
  }

  void AddTimes() {
    const double limit = options_.gate.LimitOf(Finding::kSlower),
                 certain = of_.setup.LimitOfTimes(limit);
    const auto add = [&](const std::string& place, const TimeChange& change,
                         const JudgedChange& judged, bool may_be_unsure) {
      const std::string what = fmt::format("{} {}", place, PhaseName(change.phase));
      if (judged.IsSlowerThan(certain)) {
        Add(Finding::kSlower, what);
      } else if (judged.IsSlowerThan(limit)) {
        Add(Finding::kUnsure, fmt::format("{} ({})", what, of_.setup.doubt));
      } else if (may_be_unsure && judged.verdict == ChangeVerdict::kCannotTell) {
        Add(Finding::kUnsure, what);
      }
    };
    for (const TimedGroup& group : of_.times.groups)
      for (const TimeChange& change : group.phases)
        add(group.name, change, JudgementOf(change, options_), true);
    for (const auto& [point, why] : of_.times.left_out)
      Add(Finding::kUnsure, fmt::format("{} ({})", PlaceOf(point), why));
    if (options_.is_relative || of_.times.points.size() == of_.times.groups.size()) return;
    for (const TimedPoint& point : of_.times.points)
      for (const TimeChange& change : point.phases)
        add(PlaceOf(point.point), change, change.absolute, false);
  }

  void AddFacts() {
    for (const FactComparison& fact : of_.facts) {
      const Finding finding = fact.kind == FactComparison::Kind::kVerdict  ? Finding::kStability
                              : fact.kind == FactComparison::Kind::kMemory ? Finding::kMemory
                                                                           : Finding::kAccuracy;
      if (fact.IsWorse(options_.gate.LimitOf(finding))) Add(finding, fact.name);
    }
  }

  const FileComparison& of_;
  const CompareOptions& options_;
  std::map<Finding, std::vector<std::string>> found_;
};

}  // namespace

std::span<const FindingInfo, kFindingCount> Findings() { return kFindings; }

const FindingInfo& InfoOf(Finding finding) { return kFindings[static_cast<std::size_t>(finding)]; }

Gate::Gate(double limit) {
  limits_.fill(limit);
  for (const FindingInfo& info : kFindings) SetFails(info.finding, info.fails);
}

std::string Gate::TextOf(Finding finding) const {
  const FindingInfo& info = InfoOf(finding);
  return info.has_limit ? fmt::format("{} by more than {:g} %", info.text, 100 * LimitOf(finding))
                        : std::string(info.text);
}

std::vector<Found> FindingsOf(const FileComparison& comparison, const CompareOptions& options) {
  return Finder(comparison, options).Find();
}

bool IsFailed(const FileComparison& comparison, const CompareOptions& options) {
  return std::ranges::any_of(FindingsOf(comparison, options),
                             [&](const Found& found) { return options.gate.Fails(found.finding); });
}

bool Comparisons::IsFailed(const CompareOptions& options) const {
  return !unlike.empty() || (!missing.empty() && options.gate.Fails(Finding::kMissing)) ||
         std::ranges::any_of(benchmarks, [&](const BenchmarkHistory& benchmark) {
           return figures::IsFailed(benchmark.Whole(), options);
         });
}

}  // namespace cdb::figures
