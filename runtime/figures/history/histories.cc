#include "runtime/figures/history/histories.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "runtime/figures/bootstrap.h"

namespace cdb::history {
namespace {

std::string FactOf(const FileFigures& file, const char* name) {
  const auto found = file.facts.find(name);
  return found == file.facts.end() ? "" : found->second;
}

/// `AMD EPYC 7763, Release`.
std::string MachineOf(const FileFigures& file) {
  const std::string cpu = FactOf(file, "cpu"), build = FactOf(file, "build_type");
  return fmt::format("{}, {}", cpu.empty() ? "unknown processor" : cpu,
                     build.empty() ? "unknown build" : build);
}

/// The commit in the name of a file: that of its folder, or `CROWD-COMMIT.h5` without the name of
/// the benchmark.
std::string LabelOf(const FileFigures& file) {
  const std::filesystem::path path = file.file;
  if (path.has_parent_path()) return path.parent_path().string();
  const std::string stem = path.stem().string(), head = file.benchmark + "-";
  return stem.starts_with(head) && stem.size() > head.size() ? stem.substr(head.size()) : stem;
}

void Label(History& history) {
  std::map<std::string, std::size_t> counts;
  for (const FileFigures* file : history.files) ++counts[LabelOf(*file)];
  for (const FileFigures* file : history.files) {
    const std::string label = LabelOf(*file);
    history.labels.push_back(counts[label] > 1 ? file->file : label);
  }
}

/// The identity of a point in all files: its scene, which includes what is recorded. A file whose
/// plan cannot be read has places only, each of which is matched with the first scene there that
/// has counters if the file does.
class Scenes {
 public:
  explicit Scenes(const std::vector<const FileFigures*>& files) {
    for (const FileFigures* file : files)
      for (const PointFigures& point : file->points)
        if (!point.scene.empty())
          by_place_.emplace(std::pair(point.place, file->has_counters), point.scene);
  }
  std::string Of(const FileFigures& file, const PointFigures& point) const {
    if (!point.scene.empty()) return point.scene;
    const auto found = by_place_.find({point.place, file.has_counters});
    if (found != by_place_.end()) return found->second;
    return fmt::format("{}at {}", file.has_counters ? "counted " : "", point.place);
  }

 private:
  std::map<std::pair<std::string, bool>, std::string> by_place_;
};

/// The points of one scene: the file of each.
using Points = std::vector<std::pair<std::size_t, const PointFigures*>>;

/// In the order in which they appear.
std::vector<Points> PointsOf(const History& history) {
  const Scenes scenes(history.files);
  std::map<std::string, std::size_t> found;
  std::vector<Points> all;
  for (std::size_t file = 0; file < history.files.size(); ++file)
    for (const PointFigures& point : history.files[file]->points) {
      const auto [scene, is_new] =
          found.emplace(scenes.Of(*history.files[file], point), all.size());
      if (is_new) all.emplace_back();
      Points& points = all[scene->second];
      // Two points of one grid may have the same scene: the first counts.
      if (points.empty() || points.back().first != file) points.emplace_back(file, &point);
    }
  return all;
}

void AddSeries(const std::vector<Points>& all, History& history) {
  for (const Points& points : all)
    for (const FigureInfo& info : kFigures) {
      if (info.kind == FigureKind::kCount) continue;
      Series series = {points.back().second->place, &info, {}, {}, {}};
      for (const auto& [file, point] : points)
        if (const auto found = point->figures.find(info.name); found != point->figures.end()) {
          series.files.push_back(file);
          series.values.push_back(found->second);
        }
      if (!series.files.empty()) history.series.push_back(std::move(series));
    }
}

std::vector<double> LogsOf(const std::vector<double>& values) {
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log(value));
  return logs;
}

void FindAllChanges(const HistoryOptions& options, History& history) {
  const auto is_long = [](const Series& series) {
    return series.values.size() >= 2 * kLeastSegment;
  };
  const auto searched = std::ranges::count_if(history.series, is_long);
  history.short_series = history.series.size() - static_cast<std::size_t>(searched);
  for (Series& series : history.series) {
    if (!is_long(series)) continue;
    const double least = series.figure->kind == FigureKind::kInstructions ? 0.001 : 0.01;
    series.changes = FindChanges(LogsOf(series.values),
                                 {options.least_effect.value_or(least), options.significance,
                                  static_cast<std::size_t>(searched)});
  }
}

/// A change of one series, in files of the history.
struct Member {
  std::size_t series, change;
  std::size_t from, to;
  bool is_drift, is_worse;
  FigureKind kind;

  bool IsLike(const Member& other) const {
    if (is_drift != other.is_drift || is_worse != other.is_worse || kind != other.kind)
      return false;
    if (!is_drift) return to <= other.to + 1 && other.to <= to + 1;
    return from < other.to && other.from < to;
  }
};

std::vector<Member> MembersOf(const History& history) {
  std::vector<Member> members;
  for (std::size_t i = 0; i < history.series.size(); ++i) {
    const Series& series = history.series[i];
    for (std::size_t k = 0; k < series.changes.size(); ++k) {
      const Change& change = series.changes[k];
      members.push_back({i, k, series.files[change.from], series.files[change.to], change.is_drift,
                         change.log_ratio > 0, series.figure->kind});
    }
  }
  return members;
}

/// The members of a group; the first is the most common one.
std::vector<std::vector<Member>> Grouped(std::vector<Member> left) {
  std::vector<std::vector<Member>> groups;
  while (!left.empty()) {
    const auto votes = [&left](const Member& of) {
      return std::ranges::count_if(left, [&of](const Member& other) {
        return of.IsLike(other) && (of.is_drift || of.to == other.to);
      });
    };
    const Member head = *std::ranges::max_element(left, {}, votes);
    std::vector<Member> group = {head}, others;
    for (const Member& member : left) {
      if (member.series == head.series && member.change == head.change) continue;
      (member.IsLike(head) ? group : others).push_back(member);
    }
    groups.push_back(std::move(group));
    left = std::move(others);
  }
  return groups;
}

/// The files on both sides of a change of a series, between its neighbours; and those during it.
struct Surroundings {
  std::size_t first, from, to, last;
};

Surroundings AroundOf(const Series& series, std::size_t change) {
  const Change& of = series.changes[change];
  const std::size_t first = change == 0 ? 0 : series.changes[change - 1].to;
  const std::size_t last = change + 1 == series.changes.size() ? series.files.size() - 1
                                                               : series.changes[change + 1].from;
  return {series.files[first], series.files[of.from], series.files[of.to], series.files[last]};
}

/// The mean of the logarithms over the series at each file that all have, and that is on a side of
/// the step in all of them.
void CombineSteps(const History& history, const std::vector<Member>& members,
                  std::vector<double>& before, std::vector<double>& after) {
  std::map<std::size_t, std::pair<std::size_t, double>> sums;
  Surroundings common = AroundOf(history.series[members[0].series], members[0].change);
  for (const Member& member : members) {
    const Series& series = history.series[member.series];
    const Surroundings around = AroundOf(series, member.change);
    common = {std::max(common.first, around.first), std::min(common.from, around.from),
              std::max(common.to, around.to), std::min(common.last, around.last)};
    const std::vector<double> logs = WithoutOutliers(LogsOf(series.values));
    for (std::size_t i = 0; i < logs.size(); ++i) {
      auto& [count, sum] = sums[series.files[i]];
      ++count;
      sum += logs[i];
    }
  }
  for (const auto& [file, of] : sums) {
    if (of.first != members.size() || file < common.first || file > common.last) continue;
    const double mean = of.second / static_cast<double>(of.first);
    if (file <= common.from) before.push_back(mean);
    if (file >= common.to) after.push_back(mean);
  }
}

/// The change of one figure in a group of changes of any.
FigureChange ChangeOf(const History& history, const std::vector<Member>& members) {
  FigureChange change = {history.series[members[0].series].figure, {}, 0, 0, 0};
  std::vector<double> logs, lows, highs;
  for (const Member& member : members) {
    const Change& of = history.series[member.series].changes[member.change];
    change.changes.push_back({member.series, member.change});
    logs.push_back(of.log_ratio);
    lows.push_back(of.low);
    highs.push_back(of.high);
  }
  double log = figures::Mean(logs), low = figures::Median(lows), high = figures::Median(highs);
  if (members.size() > 1 && !members[0].is_drift) {
    std::vector<double> before, after;
    CombineSteps(history, members, before, after);
    if (before.size() >= kLeastSegment && after.size() >= kLeastSegment) {
      const SplitTest test = TestSplit(before, after);
      const double reach =
          test.error > 0 ? figures::StudentExceeded(0.025, test.freedom) * test.error : 0;
      log = test.difference;
      low = log - reach;
      high = log + reach;
    }
  }
  change.ratio = std::exp(log);
  change.low = std::exp(low);
  change.high = std::exp(high);
  return change;
}

/// Facts of provenance with other values in the file `to` than in `from`.
std::vector<std::string> ChangedFacts(const FileFigures& from, const FileFigures& to) {
  // The commit of cdb is another one in most files of cdb's own history.
  constexpr const char* kExplaining[] = {"cdb_version",    "bullet_version", "compiler",
                                         "compiler_flags", "host",           "cpu_governor",
                                         "system",         "kernel",         "jobs"};
  std::vector<std::string> texts;
  for (const char* fact : kExplaining)
    if (const std::string a = FactOf(from, fact), b = FactOf(to, fact); a != b)
      texts.push_back(fmt::format("{}: {} -> {}", fact, a.empty() ? "-" : a, b.empty() ? "-" : b));
  return texts;
}

void GroupChanges(History& history) {
  for (const std::vector<Member>& group : Grouped(MembersOf(history))) {
    const Member& head = group[0];
    GroupedChange change = {head.is_drift, head.is_worse, head.from, head.to, {}, {}};
    if (head.is_drift) {
      std::vector<double> from, to;
      for (const Member& member : group) {
        from.push_back(static_cast<double>(member.from));
        to.push_back(static_cast<double>(member.to));
      }
      change.from = static_cast<std::size_t>(figures::Median(from));
      change.to = static_cast<std::size_t>(figures::Median(to));
    }
    for (const FigureInfo& info : kFigures) {
      std::vector<Member> of_figure;
      for (const Member& member : group)
        if (history.series[member.series].figure == &info) of_figure.push_back(member);
      if (!of_figure.empty()) change.figures.push_back(ChangeOf(history, of_figure));
    }
    change.facts = ChangedFacts(*history.files[change.from], *history.files[change.to]);
    history.changes.push_back(std::move(change));
  }
  std::ranges::stable_sort(history.changes, {}, &GroupedChange::to);
}

bool HasOtherCounts(const PointFigures& a, const PointFigures& b) {
  return std::ranges::any_of(kFigures, [&](const FigureInfo& info) {
    const auto of_a = a.figures.find(info.name), of_b = b.figures.find(info.name);
    return info.kind == FigureKind::kCount && of_a != a.figures.end() && of_b != b.figures.end() &&
           of_a->second != of_b->second;
  });
}

bool HasOtherState(const PointFigures& a, const PointFigures& b) {
  return !a.state.empty() && !b.state.empty() && a.state != b.state;
}

/// True if most files have another motion than the one before, as where threads race.
bool IsUnrepeatable(const Points& points) {
  constexpr std::size_t kLeastSteps = 4;
  std::size_t changes = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    changes += HasOtherState(*points[i - 1].second, *points[i].second) ? 1 : 0;
  return points.size() > kLeastSteps && 2 * changes > points.size() - 1;
}

void FindMotionChanges(const std::vector<Points>& all, History& history) {
  std::map<std::pair<std::size_t, std::size_t>, MotionChange> found;
  const auto at = [&found](std::size_t from, std::size_t to) -> MotionChange& {
    MotionChange& change = found[{to, from}];
    change.from = from;
    change.to = to;
    return change;
  };
  for (const Points& points : all) {
    if (IsUnrepeatable(points)) {
      ++history.unrepeatable;
      continue;
    }
    for (std::size_t i = 1; i < points.size(); ++i) {
      const auto& [file_a, a] = points[i - 1];
      const auto& [file_b, b] = points[i];
      if (HasOtherState(*a, *b)) at(file_a, file_b).states.push_back(b->place);
      if (HasOtherCounts(*a, *b)) at(file_a, file_b).counts.push_back(b->place);
    }
  }
  for (auto& [place, change] : found) history.motions.push_back(std::move(change));
}

}  // namespace

double History::RatioSince(const Series& of, std::size_t since) const {
  double log = 0;
  for (const Change& change : of.changes)
    if (of.files[change.to] > since) log += change.log_ratio;
  return std::exp(log);
}

std::vector<History> MakeHistories(const std::vector<FileFigures>& files,
                                   const HistoryOptions& options) {
  std::map<std::pair<std::string, std::string>, History> found;
  for (const FileFigures& file : files) {
    History& history = found[{file.benchmark, MachineOf(file)}];
    history.benchmark = file.benchmark;
    history.machine = MachineOf(file);
    history.files.push_back(&file);
  }
  std::vector<History> histories;
  for (auto& [key, history] : found) {
    std::ranges::sort(history.files, {}, [](const FileFigures* file) {
      return std::tuple(file->place, file->started, file->file);
    });
    history.title = history.files.back()->title;
    Label(history);
    const std::vector<Points> points = PointsOf(history);
    AddSeries(points, history);
    FindAllChanges(options, history);
    GroupChanges(history);
    FindMotionChanges(points, history);
    histories.push_back(std::move(history));
  }
  return histories;
}

}  // namespace cdb::history
