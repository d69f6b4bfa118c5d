#include "runtime/suite/against.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "runtime/compare/facts.h"
#include "runtime/terminal/table.h"
#include "runtime/terminal/wrap.h"

namespace cdb::suite {
namespace {

using Outcome = SceneVerification::Outcome;

/// Factor from which on an error is larger than another one.
constexpr double kUnlikeError = 2;
/// Fraction of the bound: smaller errors count as equal.
constexpr double kSmallError = 0.1;

std::string SpeedupText(const ConfigurationFigures& of) {
  const std::string value = fmt::format("{:.2f}", of.speedup.value);
  return std::isnan(of.speedup_interval.low)
             ? value
             : fmt::format("{} ({:.2f} .. {:.2f})", value, of.speedup_interval.low,
                           of.speedup_interval.high);
}

/// Disturbances of a run on this machine do not make it wrong.
bool IsWrong(const ConfigurationFigures& of, const StandardScene& scene) {
  return of.verdict > scene.worst_verdict || of.error > scene.bound ||
         of.verdict == measure::Verdict::kUnknown;
}

bool HasOtherSpeedup(const ConfigurationFigures& claimed, const ConfigurationFigures& here,
                     double margin) {
  if (!claimed.HasScore() || !here.HasScore()) return false;
  const double apart = std::abs(std::log(claimed.speedup.value / here.speedup.value));
  return apart > std::log1p(margin) && !claimed.speedup_interval.Overlaps(here.speedup_interval);
}

void CompareConfigurations(const StandardScene& scene, const ConfigurationFigures& claimed,
                           const ConfigurationFigures& here, double margin,
                           std::vector<std::string>& disagreements) {
  if (claimed.HasScore() && IsWrong(here, scene))
    disagreements.push_back(
        fmt::format("{}: has a score, but here it is wrong: {}", claimed.name, here.fault));
  else if (here.error > kUnlikeError * claimed.error && here.error > kSmallError * scene.bound)
    disagreements.push_back(fmt::format("{}: {} error {}, here {}", claimed.name, scene.error,
                                        terminal::ShortNumber(claimed.error),
                                        terminal::ShortNumber(here.error)));
  if (HasOtherSpeedup(claimed, here, margin))
    disagreements.push_back(fmt::format("{}: speedup {}, here {}", claimed.name,
                                        SpeedupText(claimed), SpeedupText(here)));
}

std::string StatesText(const compare::StateComparison& states) {
  const std::size_t known = states.same + states.other.size() + states.unsettled.size();
  std::string text = fmt::format("{} of {}", states.same, known);
  if (states.unknown > 0) text += fmt::format(", {} unknown", states.unknown);
  if (!states.unsettled.empty())
    text += fmt::format(", {} not repeatable", states.unsettled.size());
  return text;
}

const char* OutcomeText(const SceneVerification& of) {
  if (of.outcome == Outcome::kAgrees && of.timed == 0) return "not verified: no score to compare";
  switch (of.outcome) {
    case Outcome::kSameStates:
      return "verified: the same states";
    case Outcome::kAgrees:
      return "agrees";
    case Outcome::kDisagrees:
      return "DISAGREES";
  }
  return "";
}

}  // namespace

SceneVerification VerifyScene(const ScoredFile& claimed, const ScoredFile& here) {
  const StandardScene& scene = *claimed.figures.scene;
  SceneVerification made;
  made.scene = scene.Id();
  made.outcome = Outcome::kAgrees;
  if (claimed.of.file.plan_sha256() == here.of.file.plan_sha256()) {
    const auto states =
        compare::CompareStates(claimed.of, here.of, compare::MatchPoints(claimed.of, here.of, {}));
    made.states = StatesText(states);
    if (states.other.empty() && states.unknown == 0) made.outcome = Outcome::kSameStates;
    if (!states.unsettled.empty())
      made.disagreements.push_back("repeats of one run end in different states");
  } else {
    made.states = "other seeds or detectors";
  }
  const bool is_same_cpu =
      claimed.of.file.ReadProvenance("cpu") == here.of.file.ReadProvenance("cpu");
  for (const ConfigurationFigures& of : claimed.figures.configurations)
    if (const ConfigurationFigures* other = here.figures.Find(of.name)) {
      if (of.HasScore()) ++made.claimed;
      if (of.HasScore() && other->HasScore()) ++made.timed;
      CompareConfigurations(scene, of, *other, is_same_cpu ? kLikeSpeedup : kUnlikeSpeedup,
                            made.disagreements);
    }
  if (!made.disagreements.empty()) made.outcome = Outcome::kDisagrees;
  return made;
}

std::string VerificationText(const std::vector<SceneVerification>& scenes) {
  terminal::Table table;
  for (const char* head : {"scene", "last states alike", "scores compared", "result"})
    table.AddColumn(head, false);
  for (const SceneVerification& of : scenes)
    table.AddRow(
        {of.scene, of.states, fmt::format("{} of {}", of.timed, of.claimed), OutcomeText(of)});
  std::string text = table.Text();
  for (const SceneVerification& of : scenes)
    for (const std::string& line : of.disagreements)
      text += terminal::Wrapped(fmt::format("{}: {}", of.scene, line), 2);
  return text;
}

}  // namespace cdb::suite
