#include "runtime/compare/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "runtime/compare/result.h"
#include "runtime/report/show_noise.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/figures.h"

namespace cdb::compare {
namespace {

constexpr std::size_t kMostPoints = 24;

class ComparisonText {
 public:
  ComparisonText(const Comparison& comparison, const CompareOptions& options)
      : of_(comparison), options_(options), a_(comparison.a->name), b_(comparison.b->name) {}

  Document Sections() const {
    Document document = {Head(), {"Result", ResultLines(of_, options_)}};
    for (DocumentSection section : {Facts(), Groups(), Points()})
      if (!section.table.rows.empty()) document.push_back(std::move(section));
    return document;
  }

 private:
  std::string PlaceOf(std::size_t point) const {
    return of_.match.points[point].PlaceText(of_.match.axes);
  }

  /// Facts that a reader must know before any figure.
  DocumentSection Head() const {
    DocumentSection head = {fmt::format("{}: from {} to {}", of_.a->file.title(), a_, b_)};
    for (const auto& list : {of_.setup.machine, of_.setup.parameters})
      for (const SetupDifference& of : list) head.table.rows.push_back({of.name, of.a, of.b});
    head.table.columns = {{"differs", false}, {a_, false}, {b_, false}};
    if (of_.setup.machine.empty())
      head.lines.push_back("The same machine, versions and kind of build");
    for (const std::string& note : of_.match.notes) head.notes.push_back("Axis ignored: " + note);
    std::string points = Counted(of_.match.points.size(), "point") + " in both files";
    for (const auto& [name, places] :
         {std::pair{a_, of_.match.only_a}, std::pair{b_, of_.match.only_b}})
      if (!places.empty())
        points += fmt::format("; {} only in {}: {}", places.size(), name, PlacesText(places));
    head.notes.push_back(points);
    for (const std::string& note : of_.setup.notes) head.notes.push_back(note);
    if (of_.setup.is_interleaved)
      head.notes.push_back("The runs of both files were interleaved in time");
    for (const ComparedFile* file : {of_.a, of_.b}) {
      std::string noise = report::NoiseText(file->file, statistics::GroupCells(file->file).good);
      noise.erase(0, noise.find_first_not_of(' '));
      noise.erase(noise.find_last_not_of('\n') + 1);
      if (!noise.empty()) head.notes.push_back(file->name + ": " + noise);
    }
    return head;
  }

  DocumentSection Facts() const {
    DocumentSection facts = {"Facts that are the same in every repeat, compared exactly"};
    facts.table.columns = {{"fact", false}, {"better", true}, {"worse", true},
                           {"other", true}, {"points", true}, {"the largest change", false}};
    for (const FactComparison& fact : of_.facts) {
      if (fact.changes.empty()) continue;
      const FactChange& most = fact.changes[0];
      facts.table.rows.push_back({fact.name, fmt::format("{}", fact.Count(Direction::kBetter)),
                                  fmt::format("{}", fact.Count(Direction::kWorse)),
                                  fmt::format("{}", fact.Count(Direction::kOther)),
                                  fmt::format("{}", fact.points),
                                  fmt::format("{}: {}", PlaceOf(most.point), ChangeText(most))});
    }
    facts.notes = {"Other: neither better nor worse, or an error within its noise floor."};
    return facts;
  }

  static void AddTimeColumns(DocumentTable& table, const std::string& a, const std::string& b) {
    for (const std::string& head : {std::string("phase"), a, b, std::string("ratio"),
                                    std::string("95 % interval"), std::string("verdict")})
      table.columns.emplace_back(head, head != "phase" && head != "verdict");
  }

  static std::vector<std::string> TimeCells(const TimeChange& change) {
    const TestedChange& tested = change.absolute.tested;
    return {PhaseName(change.phase),
            TimeText(change.a_ns, change.a_ns),
            TimeText(change.b_ns, change.a_ns),
            FourDigits(tested.ratio),
            tested.IsTested() ? fmt::format("{} .. {}", FourDigits(tested.interval.low),
                                            FourDigits(tested.interval.high))
                              : "-",
            VerdictText(change.absolute)};
  }

  bool ShowsRelative() const { return options_.is_relative || of_.times.HasCommonShift(); }

  DocumentSection Groups() const {
    const bool pools = of_.times.points.size() > of_.times.groups.size();
    const std::string by = of_.match.group ? of_.match.axes[*of_.match.group] : "";
    DocumentSection groups = {
        fmt::format("Mean of a cycle{}{}{}", pools ? ", geometric mean over the points" : "",
                    by.empty() || !pools ? "" : " of each ", pools ? by : "")};
    groups.table.columns = {{by, false}};
    if (pools) groups.table.columns.emplace_back("points", true);
    AddTimeColumns(groups.table, a_, b_);
    if (ShowsRelative()) {
      groups.table.columns.emplace_back("relative", true);
      groups.table.columns.emplace_back("", false);
    }
    for (const TimedGroup& group : of_.times.groups)
      for (const TimeChange& change : group.phases) {
        std::vector<std::string> row = {group.name};
        if (pools) row.push_back(fmt::format("{}", group.points));
        for (std::string& cell : TimeCells(change)) row.push_back(std::move(cell));
        if (ShowsRelative()) {
          row.push_back(FourDigits(change.relative.tested.ratio));
          row.push_back(VerdictText(change.relative));
        }
        groups.table.rows.push_back(std::move(row));
      }
    groups.notes = StatisticNotes();
    return groups;
  }

  std::vector<std::string> StatisticNotes() const {
    const std::size_t n_a = of_.a->file.begun_repeats(), n_b = of_.b->file.begun_repeats();
    std::string statistic = "Mean";
    if (const std::size_t m = statistics::FastestOf(std::min(n_a, n_b)); n_a > 1 || n_b > 1)
      statistic = fmt::format(
          "Fastest of {} repeats per cycle, averaged over all choices of that many (of {} and {}), "
          "then mean",
          m, n_a, n_b);
    std::vector<std::string> notes = {
        fmt::format("{} over cycles. Below 1: {} is faster.", statistic, b_)};
    if (of_.times.has_intervals)
      notes.push_back(fmt::format(
          "Intervals by bootstrap over the repeats of each file by itself. Slower, faster: by more "
          "than {:.0f} %, with Holm's correction for all groups and phases (5 %): cdb doc "
          "statistics.",
          100 * kNegligible));
    return notes;
  }

  /// The points that changed, or all points; empty if each group is a single point.
  DocumentSection Points() const {
    DocumentSection points = {options_.lists_all ? "Each point" : "Points that changed"};
    if (of_.times.points.size() == of_.times.groups.size() && !options_.lists_all) return points;
    for (std::size_t i = 0; i < of_.match.axes.size(); ++i)
      points.table.columns.emplace_back(of_.match.axes[i], !of_.match.is_text[i]);
    AddTimeColumns(points.table, a_, b_);
    std::vector<std::pair<double, std::vector<std::string>>> rows;
    for (const TimedPoint& point : of_.times.points)
      for (const TimeChange& change : point.phases) {
        if (!options_.lists_all && change.absolute.verdict <= ChangeVerdict::kSame) continue;
        std::vector<std::string> row = of_.match.points[point.point].place;
        for (std::string& cell : TimeCells(change)) row.push_back(std::move(cell));
        rows.emplace_back(std::fabs(std::log(change.change.ratio())), std::move(row));
      }
    const std::size_t count = rows.size();
    if (!options_.lists_all && count > kMostPoints) {
      std::ranges::stable_sort(rows, std::greater(), [](const auto& row) { return row.first; });
      rows.resize(kMostPoints);
    }
    for (auto& [size, row] : rows) points.table.rows.push_back(std::move(row));
    if (count > rows.size())
      points.notes.push_back(fmt::format("The {} largest of {} changes; --all lists every point.",
                                         rows.size(), count));
    if (of_.times.has_intervals)
      points.notes.push_back(
          "By Benjamini and Hochberg's correction for all points and phases: at most 5 % of the "
          "changes found are expected to be false.");
    return points;
  }

  const Comparison& of_;
  const CompareOptions options_;
  const std::string a_, b_;
};

}  // namespace

Document CompareDocument(const Comparison& comparison, const CompareOptions& options) {
  return ComparisonText(comparison, options).Sections();
}

}  // namespace cdb::compare
