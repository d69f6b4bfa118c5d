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

/// `is_count`: of instructions.
Json PhasesJson(const std::vector<figures::TimeChange>& phases, bool has_relative, bool is_count) {
  Json json = Json::array();
  for (const figures::TimeChange& change : phases) {
    Json of = {{"phase", figures::PhaseName(change.phase)},
               {is_count ? "a_instructions" : "a_ns", change.a_ns},
               {is_count ? "b_instructions" : "b_ns", change.b_ns}};
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
                      {"phases", PhasesJson(group.phases, times.common.has_value(),
                                            times.counts_instructions)}});
  for (const figures::TimedPoint& point : times.points)
    points.push_back({{"point", PlaceOnMatch(match, point.point)},
                      {"phases", PhasesJson(point.phases, false, times.counts_instructions)}});
  for (const auto& [point, why] : times.left_out)
    left_out.push_back({{"point", PlaceOnMatch(match, point)}, {"why", why}});
  return {{"clock", times.counts_instructions ? "instructions" : "time"},
          {"has_intervals", times.has_intervals},
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

Json FindingsJson(const figures::FileComparison& of, const figures::CompareOptions& options) {
  Json findings = Json::array();
  for (const figures::Found& found : figures::FindingsOf(of, options))
    findings.push_back({{"kind", figures::InfoOf(found.finding).word},
                        {"fails", options.gate.Fails(found.finding)},
                        {"what", found.what}});
  return findings;
}

Json DifferencesJson(const std::vector<figures::SetupDifference>& list) {
  Json json = Json::array();
  for (const figures::SetupDifference& difference : list)
    json.push_back({{"name", difference.name}, {"a", difference.a}, {"b", difference.b}});
  return json;
}

Json ComparisonJson(const figures::FileComparison& of, const figures::CompareOptions& options) {
  Json differs = Json::array();
  for (const auto* list : {&of.setup.scenes, &of.setup.machine, &of.setup.parameters})
    for (Json& difference : DifferencesJson(*list)) differs.push_back(std::move(difference));
  std::vector<std::string> notes = of.match.notes;
  notes.insert(notes.end(), of.setup.notes.begin(), of.setup.notes.end());
  return {{"a", of.a->name},
          {"b", of.b->name},
          {"is_worse", figures::IsFailed(of, options)},
          {"findings", FindingsJson(of, options)},
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

Json LimitsJson(const figures::Gate& gate) {
  Json limits = Json::object();
  for (const figures::FindingInfo& info : figures::Findings())
    if (info.has_limit) limits[std::string(info.word)] = gate.LimitOf(info.finding);
  return limits;
}

Json AllJson(const figures::Comparisons& comparisons, const figures::CompareOptions& options) {
  Json list = Json::array();
  for (const figures::BenchmarkHistory& benchmark : comparisons.benchmarks) {
    Json files = Json::array(), steps = Json::array(), to_first = Json::array();
    for (const auto& file : benchmark.files) files.push_back(file->name);
    for (const figures::FileComparison& step : benchmark.steps)
      steps.push_back(ComparisonJson(step, options));
    for (const figures::FileComparison& of : benchmark.to_first)
      to_first.push_back(ComparisonJson(of, options));
    Json json = {{"benchmark", benchmark.files[0]->file.benchmark()},
                 {"title", benchmark.files[0]->file.title()},
                 {"files", std::move(files)},
                 {"comparisons", std::move(steps)}};
    if (!to_first.empty()) json["relative_to_the_first"] = std::move(to_first);
    list.push_back(std::move(json));
  }
  Json unlike = Json::array();
  for (const figures::UnlikeBenchmark& of : comparisons.unlike)
    unlike.push_back({{"benchmark", of.name},
                      {"files", of.files},
                      {"why", of.why},
                      {"differs", DifferencesJson(of.differences)}});
  return {{"cdb_compare", 1},
          {"headline", Headline(comparisons, options)},
          {"is_worse", comparisons.IsFailed(options)},
          {"fail_above", LimitsJson(options.gate)},
          {"unmatched", comparisons.unmatched},
          {"missing", comparisons.missing},
          {"other_scenes", std::move(unlike)},
          {"benchmarks", std::move(list)}};
}

}  // namespace

std::string CompareJson(const figures::Comparisons& comparisons,
                        const figures::CompareOptions& options) {
  return AllJson(comparisons, options).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ComparePageJson(const figures::Comparisons& comparisons,
                            const figures::CompareOptions& options) {
  Json all = AllJson(comparisons, options);
  all["names"] = comparisons.names;
  all["sections"] = SectionsJson(SharedSections(comparisons, options));
  for (std::size_t i = 0; i < comparisons.benchmarks.size(); ++i)
    all["benchmarks"][i]["sections"] =
        comparisons.IsHistory()
            ? Json::array()
            : SectionsJson(CompareDocument(comparisons.benchmarks[i].steps[0], options));
  return all.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace cdb::printers
