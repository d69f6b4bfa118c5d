#include "runtime/printers/compare.h"
#include "runtime/printers/json_parts.h"

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

}  // namespace

std::string CompareJson(const std::vector<figures::BenchmarkHistory>& benchmarks,
                        const std::vector<std::string>& unmatched,
                        const figures::CompareOptions& options) {
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
  const Json all = {{"cdb_compare", 1},
                    {"fail_above", options.margin},
                    {"is_worse", is_worse},
                    {"unmatched", unmatched},
                    {"benchmarks", std::move(list)}};
  return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cdb::printers
