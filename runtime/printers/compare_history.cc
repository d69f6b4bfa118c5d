#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/printers/compare.h"
#include "runtime/printers/show.h"

namespace cdb::printers {
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
    for (const auto* list : {&step.setup.scenes, &step.setup.machine, &step.setup.parameters})
      for (const figures::SetupDifference& of : *list)
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

Document HistoryDocument(const figures::Comparisons& comparisons,
                         const figures::CompareOptions& options) {
  const auto& [names, benchmarks, unlike, unmatched, missing] = comparisons;
  if (benchmarks.empty()) return {};
  Section setups = {"From file to file"}, table = {"History"};
  table.table.columns = {{"benchmark", false}, {"", false}};
  for (const std::string& name : names) table.table.AddColumn(name, true);
  table.table.AddColumn("", false);
  table.table.AddColumn("steps", false);
  for (const figures::BenchmarkHistory& benchmark : benchmarks) {
    for (std::string& line : StepLines(benchmark)) setups.lines.push_back(std::move(line));
    for (const figures::TimedGroup& group : benchmark.steps[0].times.groups)
      table.table.rows.push_back(GroupRow(benchmark, names, group.name, options));
    AddSteps(benchmark, names, options, table.lines);
  }
  if (setups.lines.empty()) setups.lines = {"The same machine, versions and facts"};
  const protocol::Phase phase = benchmarks[0].steps[0].times.common_phase;
  table.notes = {fmt::format("Mean {} of a cycle over that of the first file, geometric mean over "
                             "the points that both have.",
                             figures::PhaseName(phase)),
                 "Steps: files that are slower or faster than the one before, by Holm's correction "
                 "for all of them (5 %)."};
  table.notes.push_back("The last file relative to the first: " + Headline(comparisons, options));
  return {setups, table};
}

}  // namespace cdb::printers
