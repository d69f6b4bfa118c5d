#include "runtime/figures/searches/bisection.h"

#include <algorithm>
#include <bit>
#include <iterator>

namespace cdb::searches {
namespace {

using enum Probe::State;

/// Both ends, and the values between them at which a search begins.
std::vector<std::size_t> FirstValues(std::size_t count) {
  constexpr std::size_t kParts = 4;
  std::vector<std::size_t> values;
  for (std::size_t i = 0; i <= kParts; ++i) {
    const std::size_t value = (count - 1) * i / kParts;
    if (values.empty() || values.back() != value) values.push_back(value);
  }
  return values;
}

/// Those of `line` that were run.
std::vector<std::size_t> RunValues(const std::vector<Probe>& line) {
  std::vector<std::size_t> run;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (line[i].state != kNotRun) run.push_back(i);
  return run;
}

/// Asks for the middle between two values, unless they are neighbours.
void AskBetween(std::size_t a, std::size_t b, Bracket& bracket) {
  if (b > a + 1) bracket.next.push_back(a + (b - a) / 2);
}

/// Finds the nearest sure values on both sides, and asks for what would bring them nearer.
void LookForSureValues(const std::vector<Probe>& line, const std::vector<std::size_t>& run,
                       Bracket& bracket) {
  std::size_t above = bracket.first_yes, below = bracket.last_no;
  for (auto it = std::make_reverse_iterator(std::ranges::upper_bound(run, bracket.last_no));
       it != run.rend() && !bracket.sure_no; ++it) {
    if (line[*it].is_sure && line[*it].state == kNo)
      bracket.sure_no = *it;
    else
      above = *it;
  }
  for (auto it = std::ranges::lower_bound(run, bracket.first_yes);
       it != run.end() && !bracket.sure_yes; ++it) {
    if (line[*it].is_sure && line[*it].state == kYes)
      bracket.sure_yes = *it;
    else
      below = *it;
  }
  if (bracket.sure_no && bracket.sure_no != bracket.last_no)
    AskBetween(*bracket.sure_no, above, bracket);
  if (bracket.sure_yes && bracket.sure_yes != bracket.first_yes)
    AskBetween(below, *bracket.sure_yes, bracket);
}

}  // namespace

std::size_t UsualProbes(std::size_t values) {
  const std::vector<std::size_t> first = FirstValues(values);
  std::size_t widest = 1;
  for (std::size_t i = 1; i < first.size(); ++i) widest = std::max(widest, first[i] - first[i - 1]);
  return first.size() + static_cast<std::size_t>(std::bit_width(widest - 1));
}

Bracket Locate(const std::vector<Probe>& line) {
  Bracket bracket;
  for (const std::size_t value : FirstValues(line.size()))
    if (line[value].state == kNotRun) bracket.next.push_back(value);
  const std::vector<std::size_t> run = RunValues(line);
  bracket.probes = run.size();
  for (std::size_t i = 1; i < run.size(); ++i)
    bracket.changes += line[run[i]].state != line[run[i - 1]].state;
  if (!bracket.next.empty()) return bracket;
  const auto first_yes =
      std::ranges::find_if(run, [&](std::size_t value) { return line[value].state == kYes; });
  if (first_yes == run.end() || first_yes == run.begin()) {
    bracket.starts_with_yes = first_yes != run.end();
    const bool is_sure = line[bracket.starts_with_yes ? run.front() : run.back()].is_sure;
    bracket.outcome = !is_sure                  ? Outcome::kUncertain
                      : bracket.starts_with_yes ? Outcome::kAtFirst
                                                : Outcome::kNowhere;
    return bracket;
  }
  bracket.first_yes = *first_yes;
  bracket.last_no = *std::prev(first_yes);
  AskBetween(bracket.last_no, bracket.first_yes, bracket);
  if (!bracket.next.empty()) return bracket;
  LookForSureValues(line, run, bracket);
  if (!bracket.next.empty()) return bracket;
  const bool is_sure = bracket.sure_no == bracket.last_no && bracket.sure_yes == bracket.first_yes;
  bracket.outcome = is_sure ? Outcome::kBetween : Outcome::kUncertain;
  return bracket;
}

}  // namespace cdb::searches
