#include <fmt/format.h>

#include <algorithm>

#include "runtime/printers/compare.h"
#include "runtime/printers/json_points.h"
#include "runtime/printers/show.h"

namespace cdb::printers {
namespace {

const char* VerdictWord(figures::ChangeVerdict verdict) {
  switch (verdict) {
    case figures::ChangeVerdict::kFaster:
      return "faster";
    case figures::ChangeVerdict::kSlower:
      return "slower";
    case figures::ChangeVerdict::kSame:
      return "same";
    case figures::ChangeVerdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

const char* DirectionWord(figures::Direction direction) {
  switch (direction) {
    case figures::Direction::kBetter:
      return "better";
    case figures::Direction::kWorse:
      return "worse";
    case figures::Direction::kOther:
      break;
  }
  return "other";
}

/// Coordinates by the names of the axes; numbers are text, as in tables.
Json PlaceOnMatch(const figures::PointMatch& match, std::size_t point) {
  Json place = Json::object();
  for (std::size_t i = 0; i < match.axes.size(); ++i)
    place[match.axes[i]] = match.points[point].place[i];
  return place;
}

Json TestedJson(const figures::TestedChange& tested) {
  return {{"ratio", tested.ratio},
          {"interval", {tested.interval.low, tested.interval.high}},
          {"p", tested.p}};
}

Json JudgedJson(const figures::JudgedChange& change) {
  Json json = TestedJson(change.tested);
  json["adjusted_p"] = change.adjusted_p;
  json["verdict"] = VerdictWord(change.verdict);
  return json;
}

Json PhasesJson(const std::vector<figures::TimeChange>& phases, bool has_relative) {
  Json json = Json::array();
  for (const figures::TimeChange& change : phases) {
    Json of = {
        {"phase", figures::PhaseName(change.phase)}, {"a_ns", change.a_ns}, {"b_ns", change.b_ns}};
    of.update(JudgedJson(change.absolute));
    if (has_relative) of["relative"] = JudgedJson(change.relative);
    json.push_back(std::move(of));
  }
  return json;
}

Json TimesJson(const figures::PointMatch& match, const figures::TimeComparison& times) {
  Json groups = Json::array(), points = Json::array(), left_out = Json::array();
  for (const figures::TimedGroup& group : times.groups)
    groups.push_back({{"name", group.name},
                      {"points", group.points},
                      {"phases", PhasesJson(group.phases, times.common.has_value())}});
  for (const figures::TimedPoint& point : times.points)
    points.push_back(
        {{"point", PlaceOnMatch(match, point.point)}, {"phases", PhasesJson(point.phases, false)}});
  for (const auto& [point, why] : times.left_out)
    left_out.push_back({{"point", PlaceOnMatch(match, point)}, {"why", why}});
  return {{"has_intervals", times.has_intervals},
          {"group", match.group ? Json(match.axes[*match.group]) : Json()},
          {"common", times.common ? TestedJson(*times.common) : Json()},
          {"harness", times.harness ? TestedJson(*times.harness) : Json()},
          {"groups", std::move(groups)},
          {"points", std::move(points)},
          {"left_out", std::move(left_out)}};
}

Json StatesJson(const figures::PointMatch& match, const figures::StateComparison& states) {
  Json other = Json::array(), unsettled = Json::array();
  for (const std::size_t point : states.other) other.push_back(PlaceOnMatch(match, point));
  for (const std::size_t point : states.unsettled) unsettled.push_back(PlaceOnMatch(match, point));
  return {{"of_pairs", states.of_pairs},
          {"same", states.same},
          {"other", std::move(other)},
          {"not_repeatable", std::move(unsettled)},
          {"unknown", states.unknown}};
}

Json FactsJson(const figures::PointMatch& match,
               const std::vector<figures::FactComparison>& facts) {
  Json json = Json::array();
  for (const figures::FactComparison& fact : facts) {
    Json changes = Json::array();
    for (const figures::FactChange& change : fact.changes)
      changes.push_back({{"point", PlaceOnMatch(match, change.point)},
                         {"direction", DirectionWord(change.direction)},
                         {"a", change.a},
                         {"b", change.b},
                         {"a_text", change.text_a},
                         {"b_text", change.text_b}});
    json.push_back({{"name", fact.name}, {"points", fact.points}, {"changes", std::move(changes)}});
  }
  return json;
}

Json ComparisonJson(const figures::FileComparison& of, const figures::CompareOptions& options) {
  Json differs = Json::array();
  for (const auto& list : {of.setup.machine, of.setup.parameters})
    for (const figures::SetupDifference& difference : list)
      differs.push_back({{"name", difference.name}, {"a", difference.a}, {"b", difference.b}});
  std::vector<std::string> notes = of.match.notes;
  notes.insert(notes.end(), of.setup.notes.begin(), of.setup.notes.end());
  return {{"a", of.a->name},
          {"b", of.b->name},
          {"is_worse", !figures::WorseThings(of, options).empty()},
          {"result", ResultLines(of, options)},
          {"differs", std::move(differs)},
          {"notes", notes},
          {"is_interleaved", of.setup.is_interleaved},
          {"points", of.match.points.size()},
          {"only_a", of.match.only_a},
          {"only_b", of.match.only_b},
          {"states", StatesJson(of.match, of.states)},
          {"facts", FactsJson(of.match, of.facts)},
          {"times", TimesJson(of.match, of.times)}};
}

Json AllJson(const std::vector<figures::BenchmarkHistory>& benchmarks,
             const std::vector<std::string>& unmatched, const figures::CompareOptions& options) {
  bool is_worse = false;
  Json list = Json::array();
  for (const figures::BenchmarkHistory& benchmark : benchmarks) {
    Json files = Json::array(), comparisons = Json::array(), to_first = Json::array();
    for (const auto& file : benchmark.files) files.push_back(file->name);
    for (const figures::FileComparison& step : benchmark.steps)
      comparisons.push_back(ComparisonJson(step, options));
    for (const figures::FileComparison& of : benchmark.to_first)
      to_first.push_back(ComparisonJson(of, options));
    is_worse = is_worse || !figures::WorseThings(benchmark.Whole(), options).empty();
    Json json = {{"benchmark", benchmark.files[0]->file.benchmark()},
                 {"title", benchmark.files[0]->file.title()},
                 {"files", std::move(files)},
                 {"comparisons", std::move(comparisons)}};
    if (!to_first.empty()) json["relative_to_the_first"] = std::move(to_first);
    list.push_back(std::move(json));
  }
  return {{"cdb_compare", 1},
          {"fail_above", options.margin},
          {"is_worse", is_worse},
          {"unmatched", unmatched},
          {"benchmarks", std::move(list)}};
}

/// The sections as a terminal shows them.
Json SectionsJson(const Document& document) {
  Json sections = Json::array();
  for (const Section& section : document) {
    Json columns = Json::array();
    for (const Table::Column& column : section.table.columns)
      columns.push_back({{"label", column.head}, {"is_number", column.is_number}});
    sections.push_back({{"title", section.title},
                        {"lines", section.lines},
                        {"columns", std::move(columns)},
                        {"rows", section.table.rows},
                        {"notes", section.notes}});
  }
  return sections;
}

}  // namespace

std::string CompareJson(const std::vector<figures::BenchmarkHistory>& benchmarks,
                        const std::vector<std::string>& unmatched,
                        const figures::CompareOptions& options) {
  return AllJson(benchmarks, unmatched, options)
             .dump(2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

std::string ComparePageJson(const std::vector<figures::BenchmarkHistory>& benchmarks,
                            const std::vector<std::string>& names,
                            const std::vector<std::string>& unmatched,
                            const figures::CompareOptions& options) {
  Json all = AllJson(benchmarks, unmatched, options);
  all["names"] = names;
  all["sections"] = benchmarks[0].files.size() > 2
                        ? SectionsJson(HistoryDocument(benchmarks, names, options))
                        : Json::array();
  for (std::size_t i = 0; i < benchmarks.size(); ++i)
    all["benchmarks"][i]["sections"] =
        benchmarks[i].files.size() > 2
            ? Json::array()
            : SectionsJson(CompareDocument(benchmarks[i].steps[0], options));
  return all.dump(-1, ' ', false, Json::error_handler_t::replace);
}

namespace {

/// The group's change in the phase by which all groups are compared; null if it has none.
const figures::TimeChange* FindChange(const figures::FileComparison& comparison,
                                      const std::string& group) {
  const auto found = std::ranges::find(comparison.times.groups, group, &figures::TimedGroup::name);
  if (found == comparison.times.groups.end()) return nullptr;
  const auto change =
      std::ranges::find(found->phases, comparison.times.common_phase, &figures::TimeChange::phase);
  return change == found->phases.end() ? nullptr : &*change;
}

/// The second file relative to the first is in `steps`, not in `to_first`.
const figures::FileComparison& ToFirst(const figures::BenchmarkHistory& benchmark,
                                       std::size_t file) {
  return file == 1 ? benchmark.steps[0] : benchmark.to_first[file - 2];
}

/// A group's change from file `i - 1` to file `i`; null if it was not timed.
const figures::JudgedChange* FindStep(const figures::BenchmarkHistory& benchmark, std::size_t i,
                                      const std::string& group,
                                      const figures::CompareOptions& options) {
  const figures::TimeChange* change = FindChange(benchmark.steps[i - 1], group);
  return change == nullptr ? nullptr : &figures::JudgementOf(*change, options);
}

/// The steps at which the group became faster or slower: `c.h5 +5.2 %`.
std::string StepsText(const figures::BenchmarkHistory& benchmark,
                      const std::vector<std::string>& names, const std::string& group,
                      const figures::CompareOptions& options) {
  std::string text;
  bool is_known = true;
  for (std::size_t i = 1; i < names.size(); ++i) {
    const figures::JudgedChange* judged = FindStep(benchmark, i, group, options);
    is_known =
        is_known && judged != nullptr && judged->verdict != figures::ChangeVerdict::kCannotTell;
    if (judged != nullptr && judged->verdict > figures::ChangeVerdict::kSame)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", names[i],
                          PercentText(judged->tested.ratio));
  }
  if (!text.empty()) return text;
  return is_known ? "none" : "cannot tell";
}

std::vector<std::string> GroupRow(const figures::BenchmarkHistory& benchmark,
                                  const std::vector<std::string>& names, const std::string& group,
                                  const figures::CompareOptions& options) {
  std::vector<std::string> row = {benchmark.files[0]->file.benchmark(), group, FourDigits(1)};
  std::vector<double> ratios = {1};
  for (std::size_t file = 1; file < benchmark.files.size(); ++file) {
    const figures::TimeChange* change = FindChange(ToFirst(benchmark, file), group);
    ratios.push_back(change == nullptr ? figures::kNone : change->change.ratio());
    row.push_back(FourDigits(ratios.back()));
  }
  row.push_back(Sparkline(ratios, ratios.size(), figures::kNegligible));
  row.push_back(StepsText(benchmark, names, group, options));
  return row;
}

/// The same with intervals, a line for each file and group.
void AddSteps(const figures::BenchmarkHistory& benchmark, const std::vector<std::string>& names,
              const figures::CompareOptions& options, std::vector<std::string>& lines) {
  for (std::size_t i = 1; i < names.size(); ++i)
    for (const figures::TimedGroup& group : benchmark.steps[i - 1].times.groups) {
      const figures::JudgedChange* judged = FindStep(benchmark, i, group.name, options);
      if (judged == nullptr || judged->verdict <= figures::ChangeVerdict::kSame) continue;
      lines.push_back(
          fmt::format("{}: {}, from {} to {}: {} {} ({})",
                      judged->verdict == figures::ChangeVerdict::kSlower ? "SLOWER" : "FASTER",
                      benchmark.files[0]->file.benchmark(), names[i - 1], names[i], group.name,
                      PercentText(judged->tested.ratio),
                      PercentRange(judged->tested.interval.low, judged->tested.interval.high)));
    }
}

/// Setups that differ and facts that changed from each file to the next.
std::vector<std::string> StepLines(const figures::BenchmarkHistory& benchmark) {
  std::vector<std::string> lines;
  for (const figures::FileComparison& step : benchmark.steps) {
    const std::string head = fmt::format(
        "{}, from {} to {}: ", benchmark.files[0]->file.benchmark(), step.a->name, step.b->name);
    for (const auto& list : {step.setup.machine, step.setup.parameters})
      for (const figures::SetupDifference& of : list)
        lines.push_back(fmt::format("{}{}: {} -> {}", head, of.name, of.a, of.b));
    for (const std::string& note : step.match.notes)
      lines.push_back(head + "axis ignored: " + note);
    for (const std::string& note : step.setup.notes) lines.push_back(head + note);
    const std::size_t unmatched = step.match.only_a.size() + step.match.only_b.size();
    if (unmatched > 0)
      lines.push_back(fmt::format("{}{} points are only in one of them", head, unmatched));
    for (const std::string& line : FactLines(step)) lines.push_back(head + line);
  }
  return lines;
}

}  // namespace

Document HistoryDocument(const std::vector<figures::BenchmarkHistory>& benchmarks,
                         const std::vector<std::string>& names,
                         const figures::CompareOptions& options) {
  Section setups = {"From file to file"}, table = {"History"};
  table.table.columns = {{"benchmark", false}, {"", false}};
  for (const std::string& name : names) table.table.AddColumn(name, true);
  table.table.AddColumn("", false);
  table.table.AddColumn("steps", false);
  std::vector<std::string> worse;
  for (const figures::BenchmarkHistory& benchmark : benchmarks) {
    for (std::string& line : StepLines(benchmark)) setups.lines.push_back(std::move(line));
    for (const figures::TimedGroup& group : benchmark.steps[0].times.groups)
      table.table.rows.push_back(GroupRow(benchmark, names, group.name, options));
    AddSteps(benchmark, names, options, table.lines);
    for (const std::string& thing : figures::WorseThings(benchmark.Whole(), options))
      worse.push_back(benchmark.files[0]->file.benchmark() + " " + thing);
  }
  if (setups.lines.empty()) setups.lines = {"The same machine, versions and facts"};
  const protocol::Phase phase = benchmarks[0].steps[0].times.common_phase;
  table.notes = {fmt::format("Mean {} of a cycle over that of the first file, geometric mean over "
                             "the points that both have.",
                             figures::PhaseName(phase)),
                 "Steps: files that are slower or faster than the one before, by Holm's correction "
                 "for all of them (5 %)."};
  const std::string margin = fmt::format("{:g} %", 100 * options.margin);
  table.notes.push_back(
      worse.empty()
          ? "Nothing is significantly worse in the last file than in the first, by more than " +
                margin
          : fmt::format(
                "WORSE: the last file relative to the first, by more than {}, exit status 4: {}",
                margin, PlacesText(worse)));
  return {setups, table};
}

}  // namespace cdb::printers
