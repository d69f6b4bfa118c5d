#include "runtime/printers/history.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <set>
#include <span>
#include <string_view>

#include "runtime/printers/compare.h"
#include "runtime/printers/json_points.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using history::FigureChange;
using history::FigureKind;
using history::GroupedChange;
using history::History;
using history::MotionChange;
using history::Series;

constexpr std::size_t kMostCurves = 5, kCurveWidth = 50;

/// `1a2b3c (2026-03-01)`.
std::string FileText(const History& of, std::size_t file) {
  const std::string day = DayOf(of.files[file]->started);
  return day.empty() ? of.labels[file] : fmt::format("{} ({})", of.labels[file], day);
}

std::string CommitText(const history::Commit& commit) {
  constexpr std::size_t kShort = 9;
  return commit.hash.substr(0, kShort) + " " + commit.subject;
}

std::string PointText(const std::string& place) { return place.empty() ? "the only point" : place; }

/// Digits of a percentage after the point: counts of instructions have less noise than times.
int DigitsOf(const history::FigureInfo& figure) {
  return figure.kind == FigureKind::kInstructions ? 2 : 1;
}

/// `step +5.1 % (+4.8 .. +5.4 %)`; with the number of its points, if it is not `points`.
std::string FigureText(const FigureChange& change, std::size_t points) {
  const std::size_t count = change.changes.size();
  const int digits = DigitsOf(*change.figure);
  return fmt::format("{} {} ({}){}", change.figure->text, PercentText(change.ratio, digits),
                     PercentRange(change.low, change.high, digits),
                     count == points ? "" : " at " + Counted(count, "point"));
}

std::size_t CountPoints(const History& of) {
  std::set<std::string> places;
  for (const Series& series : of.series) places.insert(series.place);
  return places.size();
}

const char* WordOf(const GroupedChange& change) {
  const FigureKind kind = change.figures[0].figure->kind;
  if (kind == FigureKind::kInstructions)
    return change.is_worse ? "MORE INSTRUCTIONS" : "fewer instructions";
  if (kind == FigureKind::kMemory) return change.is_worse ? "MORE MEMORY" : "less memory";
  return change.is_worse ? "SLOWER" : "faster";
}

/// Places of all series of a change, once each.
std::vector<std::string> PlacesOf(const History& of, const GroupedChange& change) {
  std::vector<std::string> places;
  for (const FigureChange& figure : change.figures)
    for (const history::SeriesChange& one : figure.changes)
      if (const std::string place = PointText(of.series[one.series].place);
          std::ranges::find(places, place) == places.end())
        places.push_back(place);
  return places;
}

/// The commits after that of the file `from`, up to that of the file `to`.
std::span<const history::Commit> CommitsBetween(const PrintedHistories& printed, const History& of,
                                                std::size_t from, std::size_t to) {
  if (printed.commits.empty()) return {};
  const auto first = static_cast<std::size_t>(of.files[from]->place) + 1,
             last = static_cast<std::size_t>(of.files[to]->place);
  return std::span(printed.commits).subspan(first, last + 1 - std::min(first, last + 1));
}

/// `  in 3 commits: 1a2b3c4 Subject; …`.
void AddCommits(std::span<const history::Commit> commits, std::vector<std::string>& lines) {
  if (commits.empty()) return;
  std::vector<std::string> texts;
  for (const history::Commit& commit : commits) texts.push_back(CommitText(commit));
  lines.push_back(fmt::format("  in {}: {}", Counted(commits.size(), "commit"), PlacesText(texts)));
}

void AddChange(const PrintedHistories& printed, const History& of, const GroupedChange& change,
               std::vector<std::string>& lines) {
  std::vector<std::string> figures;
  const std::vector<std::string> places = PlacesOf(of, change);
  for (const FigureChange& figure : change.figures)
    figures.push_back(FigureText(figure, places.size()));
  lines.push_back(
      change.is_drift
          ? fmt::format("{} little by little, over {} files from {} to {}: {}", WordOf(change),
                        change.to - change.from + 1, FileText(of, change.from),
                        FileText(of, change.to), fmt::join(figures, "; "))
          : fmt::format("{} between {} and {}: {}", WordOf(change), FileText(of, change.from),
                        FileText(of, change.to), fmt::join(figures, "; ")));
  lines.push_back(fmt::format("  at {} of {}: {}", places.size(), Counted(CountPoints(of), "point"),
                              PlacesText(places)));
  AddCommits(CommitsBetween(printed, of, change.from, change.to), lines);
  if (!change.facts.empty())
    lines.push_back(fmt::format("  changed meanwhile: {}", fmt::join(change.facts, "; ")));
}

void AddMotion(const PrintedHistories& printed, const History& of, const MotionChange& change,
               std::vector<std::string>& lines) {
  std::vector<std::string> parts;
  if (!change.states.empty())
    parts.push_back(
        fmt::format("another last state at {}", Counted(change.states.size(), "point")));
  if (!change.counts.empty())
    parts.push_back(fmt::format("other numbers of pairs or contacts at {}",
                                Counted(change.counts.size(), "point")));
  lines.push_back(fmt::format("OTHER MOTION between {} and {}: {}", FileText(of, change.from),
                              FileText(of, change.to), fmt::join(parts, ", ")));
  std::vector<std::string> places = change.states.empty() ? change.counts : change.states;
  for (std::string& place : places) place = PointText(place);
  lines.push_back("  at " + PlacesText(places));
  AddCommits(CommitsBetween(printed, of, change.from, change.to), lines);
}

/// Changes and motions, the newest first.
std::vector<std::string> ChangeLines(const PrintedHistories& printed, const History& of,
                                     std::size_t since) {
  std::vector<std::string> lines;
  std::set<std::size_t, std::greater<>> places;
  for (const GroupedChange& change : of.changes) places.insert(change.to);
  for (const MotionChange& change : of.motions) places.insert(change.to);
  for (const std::size_t place : places) {
    if (place <= since) continue;
    for (const GroupedChange& change : of.changes)
      if (change.to == place) AddChange(printed, of, change, lines);
    for (const MotionChange& change : of.motions)
      if (change.to == place) AddMotion(printed, of, change, lines);
  }
  return lines;
}

std::string ValueText(const Series& of, double value) {
  switch (of.figure->kind) {
    case FigureKind::kMemory:
      return terminal::ShortNumber(value / 1e6) + " MB";
    case FigureKind::kInstructions:
      return CountText(value);
    default:
      return figures::TimeText(value);
  }
}

/// The values at all files, NaN where there is none.
std::vector<double> ValuesOf(const History& of, const Series& series) {
  std::vector<double> values(of.files.size(), figures::kNone);
  for (std::size_t i = 0; i < series.files.size(); ++i) values[series.files[i]] = series.values[i];
  return values;
}

/// The series that changed most, or nothing without a change.
Table CurvesOf(const History& of, std::size_t since) {
  Table table = {.keys = 2};
  table.AddColumn("", false);
  table.AddColumn("point", false);
  table.AddColumn("over the files", false);
  table.AddColumn("first", true);
  table.AddColumn("last", true);
  std::vector<std::pair<double, const Series*>> changed;
  for (const Series& series : of.series)
    if (std::ranges::any_of(series.changes, [&](const history::Change& change) {
          return series.files[change.to] > since;
        }))
      changed.emplace_back(-std::fabs(std::log(of.RatioSince(series, since))), &series);
  std::ranges::stable_sort(changed, {}, [](const auto& one) { return one.first; });
  for (std::size_t i = 0; i < std::min(changed.size(), kMostCurves); ++i) {
    const Series& series = *changed[i].second;
    table.rows.push_back({series.figure->text, PointText(series.place),
                          Sparkline(ValuesOf(of, series), kCurveWidth, figures::kNegligible),
                          ValueText(series, series.values.front()),
                          ValueText(series, series.values.back())});
  }
  return table;
}

std::string GateLine(const PrintedHistories& printed, const History& of) {
  const std::vector<std::size_t> worse = printed.WorseSeries(of);
  std::vector<std::string> texts;
  for (const std::size_t i : worse)
    texts.push_back(fmt::format("{} at {} {}", of.series[i].figure->text,
                                PointText(of.series[i].place),
                                PercentText(of.RatioSince(of.series[i], printed.SinceOf(of)),
                                            DigitsOf(*of.series[i].figure))));
  return fmt::format("FAIL (exit status 4): worse by more than {:g} % since {}: {}",
                     100 * *printed.fail_above, of.labels[printed.SinceOf(of)], PlacesText(texts));
}

Section SectionOf(const PrintedHistories& printed, const History& of) {
  const std::size_t since = printed.SinceOf(of);
  Section section = {.title = fmt::format("{} ({})", of.title, of.benchmark)};
  const std::string span = of.files.size() == 1 ? FileText(of, 0)
                                                : fmt::format("from {} to {}", FileText(of, 0),
                                                              FileText(of, of.files.size() - 1));
  section.lines.push_back(fmt::format("{}: {}, {}; {}, {} series", of.machine,
                                      Counted(of.files.size(), "file"), span,
                                      Counted(CountPoints(of), "point"), of.series.size()));
  if (since > 0) section.lines.push_back("Changes after " + FileText(of, since));
  std::vector<std::string> changes = ChangeLines(printed, of, since);
  if (changes.empty())
    changes.push_back(of.short_series == of.series.size()
                          ? fmt::format("Too few files for changes: {} of a series are needed",
                                        2 * history::kLeastSegment)
                          : "No change was found");
  section.lines.insert(section.lines.end(), changes.begin(), changes.end());
  if (of.short_series > 0 && of.short_series < of.series.size())
    section.lines.push_back(fmt::format("{} of {} series have too few files for changes",
                                        of.short_series, of.series.size()));
  if (of.unrepeatable > 0)
    section.lines.push_back(
        fmt::format("The motion of {} is another one in most files, and is not reported",
                    Counted(of.unrepeatable, "point")));
  std::size_t unsound = 0;
  for (const history::FileFigures* file : of.files) unsound += file->unsound;
  if (unsound > 0)
    section.lines.push_back(
        fmt::format("Left out: {} of single files that failed or whose timings are void",
                    Counted(unsound, "point")));
  if (!printed.WorseSeries(of).empty()) section.lines.push_back(GateLine(printed, of));
  section.table = CurvesOf(of, since);
  return section;
}

Json IntervalJson(double low, double high) { return {JsonNumber(low), JsonNumber(high)}; }

Json FigureJson(const History& of, const FigureChange& figure) {
  Json points = Json::array();
  for (const auto& [i, k] : figure.changes) {
    const Series& series = of.series[i];
    const history::Change& change = series.changes[k];
    points.push_back({{"point", series.place},
                      {"from", of.labels[series.files[change.from]]},
                      {"to", of.labels[series.files[change.to]]},
                      {"ratio", JsonNumber(std::exp(change.log_ratio))},
                      {"interval", IntervalJson(std::exp(change.low), std::exp(change.high))},
                      {"adjusted_p", JsonNumber(change.p)}});
  }
  return {{"figure", figure.figure->name},
          {"ratio", JsonNumber(figure.ratio)},
          {"interval", IntervalJson(figure.low, figure.high)},
          {"points", std::move(points)}};
}

Json CommitsJson(std::span<const history::Commit> commits) {
  Json json = Json::array();
  for (const history::Commit& commit : commits)
    json.push_back({{"commit", commit.hash}, {"subject", commit.subject}});
  return json;
}

Json ChangesJson(const PrintedHistories& printed, const History& of, std::size_t since) {
  Json changes = Json::array();
  for (const GroupedChange& change : of.changes) {
    if (change.to <= since) continue;
    Json figures = Json::array();
    for (const FigureChange& figure : change.figures) figures.push_back(FigureJson(of, figure));
    changes.push_back({{"kind", change.is_drift ? "drift" : "step"},
                       {"is_worse", change.is_worse},
                       {"from", of.labels[change.from]},
                       {"to", of.labels[change.to]},
                       {"figures", std::move(figures)},
                       {"facts", change.facts}});
    if (!printed.commits.empty())
      changes.back()["commits"] = CommitsJson(CommitsBetween(printed, of, change.from, change.to));
  }
  return changes;
}

Json HistoryJson(const PrintedHistories& printed, const History& of) {
  const std::size_t since = printed.SinceOf(of);
  Json files = Json::array(), motions = Json::array(), series = Json::array();
  for (std::size_t i = 0; i < of.files.size(); ++i)
    files.push_back({{"label", of.labels[i]},
                     {"file", of.files[i]->file},
                     {"started", of.files[i]->started},
                     {"facts", of.files[i]->facts}});
  for (const MotionChange& change : of.motions)
    if (change.to > since)
      motions.push_back({{"from", of.labels[change.from]},
                         {"to", of.labels[change.to]},
                         {"states", change.states},
                         {"counts", change.counts}});
  for (const Series& one : of.series) {
    Json own = Json::array();
    for (const history::Change& change : one.changes)
      own.push_back({{"kind", change.is_drift ? "drift" : "step"},
                     {"from", one.files[change.from]},
                     {"to", one.files[change.to]},
                     {"ratio", JsonNumber(std::exp(change.log_ratio))},
                     {"interval", IntervalJson(std::exp(change.low), std::exp(change.high))}});
    series.push_back({{"figure", one.figure->name},
                      {"point", one.place},
                      {"ratio_since", JsonNumber(of.RatioSince(one, since))},
                      {"values", JsonNumbers(ValuesOf(of, one))},
                      {"changes", std::move(own)}});
  }
  return {{"benchmark", of.benchmark},     {"title", of.title},
          {"machine", of.machine},         {"is_worse", !printed.WorseSeries(of).empty()},
          {"files", std::move(files)},     {"changes", ChangesJson(printed, of, since)},
          {"motions", std::move(motions)}, {"series", std::move(series)}};
}

}  // namespace

std::string DayOf(double started) {
  if (started <= 0) return {};
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(static_cast<std::time_t>(started)));
}

std::size_t PrintedHistories::SinceOf(const History& of) const {
  std::size_t at = 0;
  for (std::size_t i = 0; since && i < of.files.size(); ++i)
    if (of.files[i]->place <= *since) at = i;
  return at;
}

std::vector<std::size_t> PrintedHistories::WorseSeries(const History& of) const {
  std::vector<std::size_t> worse;
  for (std::size_t i = 0; fail_above && i < of.series.size(); ++i)
    if (of.RatioSince(of.series[i], SinceOf(of)) > 1 + *fail_above) worse.push_back(i);
  return worse;
}

bool PrintedHistories::IsFailed() const {
  return std::ranges::any_of(histories,
                             [this](const History& of) { return !WorseSeries(of).empty(); });
}

Document HistoriesDocument(const PrintedHistories& printed) {
  Document document;
  for (const History& of : printed.histories) document.push_back(SectionOf(printed, of));
  Section last = {.title = printed.folder};
  last.lines.push_back(
      Counted(printed.files, "results file") +
      (printed.read == printed.files
           ? ""
           : fmt::format(", of which {} read; the others are in the cache", printed.read)));
  for (const auto& [file, why] : printed.left_out)
    last.lines.push_back(fmt::format("Left out: {}: {}", file, why));
  document.push_back(std::move(last));
  return document;
}

namespace {

Json AllJson(const PrintedHistories& printed) {
  Json histories = Json::array(), left_out = Json::array();
  for (const History& of : printed.histories) histories.push_back(HistoryJson(printed, of));
  for (const auto& [file, why] : printed.left_out)
    left_out.push_back({{"file", file}, {"why", why}});
  return Json{{"cdb_history", 1},
              {"is_worse", printed.IsFailed()},
              {"read", printed.read},
              {"left_out", std::move(left_out)},
              {"histories", std::move(histories)}};
}

}  // namespace

std::string HistoriesJson(const PrintedHistories& printed) { return AllJson(printed).dump(1); }

std::string HistoriesPageJson(const PrintedHistories& printed) {
  Json all = AllJson(printed);
  all["folder"] = printed.folder;
  const Json sections = SectionsJson(HistoriesDocument(printed));
  for (std::size_t i = 0; i < printed.histories.size(); ++i) {
    const History& of = printed.histories[i];
    Json& history = all["histories"][i];
    history["section"] = sections[i];
    history["since"] = printed.SinceOf(of);
    for (std::size_t k = 0; k < of.files.size(); ++k) {
      history["files"][k]["day"] = DayOf(of.files[k]->started);
      if (!printed.commits.empty())
        history["files"][k]["subject"] =
            printed.commits[static_cast<std::size_t>(of.files[k]->place)].subject;
    }
  }
  all["section"] = sections.back();
  return all.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace cdb::printers
