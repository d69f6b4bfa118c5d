#include "runtime/figures/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace cdb::figures {
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
