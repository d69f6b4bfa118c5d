#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/figures/times.h"
#include "runtime/printers/document.h"
#include "runtime/printers/suite.h"
#include "runtime/terminal/console.h"

namespace cdb::printers {
namespace {

std::string MemoryText(double bytes) {
  return std::isnan(bytes) ? "-" : fmt::format("{:.0f} MB", bytes / 1e6);
}

std::string RatioText(double ratio) {
  return std::isnan(ratio) ? "-" : fmt::format("{:.2f}", ratio);
}

std::string RangeText(const figures::Interval& interval) {
  return std::isnan(interval.low) ? "-"
                                  : fmt::format("{:.2f} .. {:.2f}", interval.low, interval.high);
}

/// The speedup of a configuration in a scene: in brackets if it is disturbed, a dash if it is
/// wrong.
std::string SpeedupText(const figures::SceneFigures& scene, const std::string& name) {
  const figures::ConfigurationFigures* of = scene.Find(name);
  if (of == nullptr || (!of->HasScore() && !of->is_disturbed)) return "-";
  const std::string ratio = RatioText(of->speedup.value);
  return of->is_disturbed ? fmt::format("({})", ratio) : ratio;
}

std::string KindTable(const figures::KindFigures& kind) {
  Table table;
  table.AddColumn("configuration", false);
  for (const char* head : {"score", "95 % interval", "memory"}) table.AddColumn(head, true);
  for (const figures::SceneFigures* scene : kind.scenes) table.AddColumn(scene->scene->name, true);
  for (const figures::KindScore& score : kind.scores) {
    std::vector<std::string> row = {score.name,
                                    score.faults.empty() ? RatioText(score.score) : "none",
                                    RangeText(score.interval), MemoryText(score.memory_bytes)};
    for (const figures::SceneFigures* scene : kind.scenes)
      row.push_back(SpeedupText(*scene, score.name));
    table.rows.push_back(std::move(row));
  }
  return TextOf({{.table = std::move(table)}}, Format::kTerminal);
}

/// Configurations with the same faults share a line.
std::string FaultLines(const figures::KindFigures& kind) {
  std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> by_faults;
  for (const figures::KindScore& score : kind.scores) {
    if (score.faults.empty()) continue;
    const auto there =
        std::ranges::find(by_faults, score.faults, [](const auto& of) { return of.first; });
    if (there == by_faults.end())
      by_faults.push_back({score.faults, {score.name}});
    else
      there->second.push_back(score.name);
  }
  std::string text;
  for (const auto& [faults, names] : by_faults)
    text += terminal::Wrapped(
        fmt::format("No score: {}: {}", fmt::join(names, ", "), fmt::join(faults, "; ")), 2);
  return text;
}

bool HasDisturbed(const figures::KindFigures& kind) {
  return std::ranges::any_of(kind.scenes, [](const figures::SceneFigures* scene) {
    return std::ranges::any_of(scene->configurations, &figures::ConfigurationFigures::is_disturbed);
  });
}

/// Width of the names in a table that fits a terminal.
constexpr std::size_t kNamesWidth = 25;

/// `skin`, `auto, grid or skin`, `any but dbvt` if only the baseline is not among them, `skin or 3
/// others` if they are too long; `-` for none.
std::string NamesOf(const std::vector<const figures::ConfigurationFigures*>& of,
                    const figures::SceneFigures& scene) {
  if (of.empty()) return "-";
  const figures::ConfigurationFigures& baseline = scene.configurations[0];
  if (of.size() > 1 && of.size() + 1 == scene.configurations.size() &&
      std::ranges::find(of, &baseline) == of.end())
    return "any but " + baseline.name;
  std::string names = of[0]->name;
  for (std::size_t i = 1; i < of.size(); ++i)
    names += (i + 1 == of.size() ? " or " : ", ") + of[i]->name;
  return names.size() <= kNamesWidth ? names
                                     : fmt::format("{} or {} others", of[0]->name, of.size() - 1);
}

/// The recommendation without a time budget.
std::vector<const figures::ConfigurationFigures*> Best(const figures::SceneFigures& scene,
                                                       bool only_bullets_own) {
  return figures::Recommend(scene, std::numeric_limits<double>::infinity(), only_bullets_own);
}

/// ` sap32 and sap tie with it.`; empty for one.
std::string TiesText(const std::vector<const figures::ConfigurationFigures*>& best) {
  if (best.size() < 2) return {};
  std::vector<std::string> names;
  for (std::size_t i = 1; i < best.size(); ++i) names.push_back(best[i]->name);
  const std::string last = names.back();
  names.pop_back();
  return names.empty() ? fmt::format(" {} ties with it.", last)
                       : fmt::format(" {} and {} tie with it.", fmt::join(names, ", "), last);
}

std::string SpeedOver(const figures::ConfigurationFigures& of,
                      const figures::ConfigurationFigures& baseline) {
  if (&of == &baseline) return "the baseline";
  const double ratio = of.speedup.value;
  return fmt::format("{:.2f} times as fast as {}{}", ratio, baseline.name,
                     std::isnan(of.speedup_interval.low)
                         ? ""
                         : fmt::format(" (95 % interval {})", RangeText(of.speedup_interval)));
}

/// Speedup below which a change is not worth mentioning.
constexpr double kWorthwhile = 1.05;

/// The fastest of Bullet's own configurations that is worth a change from the baseline: faster
/// beyond the interval, and no less accurate; null if there is none.
const figures::ConfigurationFigures* FindFaster(const figures::SceneFigures& scene) {
  const figures::ConfigurationFigures* fastest = nullptr;
  for (const figures::ConfigurationFigures& of : scene.configurations)
    if (of.is_bullets_own && of.HasScore() && of.error <= scene.configurations[0].error &&
        of.speedup.value >= kWorthwhile && of.speedup_interval.low > 1 &&
        (fastest == nullptr || of.speedup.value > fastest->speedup.value))
      fastest = &of;
  return fastest;
}

const char* OutcomeText(const figures::SceneVerification& of) {
  if (of.outcome == figures::SceneVerification::Outcome::kAgrees && of.timed == 0)
    return "not verified: no score to compare";
  switch (of.outcome) {
    case figures::SceneVerification::Outcome::kSameStates:
      return "verified: the same states";
    case figures::SceneVerification::Outcome::kAgrees:
      return "agrees";
    case figures::SceneVerification::Outcome::kDisagrees:
      return "DISAGREES";
  }
  return "";
}

}  // namespace

std::string DefaultsText(const std::vector<figures::SceneFigures>& scenes) {
  std::vector<std::string> slow, wrong;
  std::size_t known = 0;
  for (const figures::SceneFigures& scene : scenes) {
    const figures::ConfigurationFigures& baseline = scene.configurations[0];
    if (baseline.is_disturbed) continue;
    ++known;
    const std::string id = scene.scene->Id();
    if (!baseline.HasScore())
      wrong.push_back(fmt::format("{} ({})", id, baseline.fault));
    else if (const figures::ConfigurationFigures* faster = FindFaster(scene))
      slow.push_back(fmt::format("{} ({} {:.2f})", id, faster->name, faster->speedup.value));
  }
  if (known == 0) return "Unknown whether Bullet's defaults are right: the machine was disturbed.";
  std::string text = slow.empty()
                         ? fmt::format(
                               "In none of {} scenes is another of Bullet's configurations at "
                               "least {:.0f} % faster than its default.",
                               known, 100 * (kWorthwhile - 1))
                         : fmt::format(
                               "Another of Bullet's configurations is at least {:.0f} % faster "
                               "than its default in {} of {} scenes (95 % interval above 1): {}.",
                               100 * (kWorthwhile - 1), slow.size(), known, fmt::join(slow, ", "));
  if (!wrong.empty()) text += fmt::format(" It is wrong in {}.", fmt::join(wrong, ", "));
  return text;
}

std::string ScoreText(const std::vector<figures::KindFigures>& kinds) {
  std::string text;
  for (const figures::KindFigures& kind : kinds) {
    text += fmt::format("{}: {}\n", kind.kind->name, kind.kind->doc);
    text += KindTable(kind) + FaultLines(kind);
    text += fmt::format("  Speed relative to {}: 2 is twice as fast.{}\n\n", kind.baseline,
                        HasDisturbed(kind) ? " In brackets: disturbed runs." : "");
  }
  return text;
}

std::string RecommendationText(const std::vector<figures::SceneFigures>& scenes) {
  Table table;
  table.AddColumn("scene", false);
  table.AddColumn("best of all", false);
  table.AddColumn("best of Bullet's", false);
  for (const figures::TimeBudget& budget : figures::kTimeBudgets)
    table.AddColumn(budget.name, false);
  for (const figures::SceneFigures& scene : scenes) {
    const auto best = Best(scene, false);
    std::vector<std::string> row = {scene.scene->Id(), NamesOf(best, scene),
                                    NamesOf(Best(scene, true), scene)};
    for (const figures::TimeBudget& budget : figures::kTimeBudgets) {
      const auto fitting = figures::Recommend(scene, budget.seconds, false);
      row.push_back(!fitting.empty() && fitting == best ? "same" : NamesOf(fitting, scene));
    }
    table.rows.push_back(std::move(row));
  }
  return "Which one to use\n" + TextOf({{.table = std::move(table)}}, Format::kTerminal) +
         "  Best: the most accurate of the correct ones, and of equally accurate ones the "
         "fastest.\n"
         "  Time budgets: the best whose slow steps fit; same: the best of all; -: none fits.\n";
}

std::string AnswerText(const figures::SceneFigures& scene) {
  const figures::ConfigurationFigures& baseline = scene.configurations[0];
  const auto best = Best(scene, false), own = Best(scene, true);
  if (best.empty())
    return std::ranges::any_of(scene.configurations, &figures::ConfigurationFigures::is_disturbed)
               ? "Not known: the machine was disturbed."
               : "No configuration is correct.";
  std::string text =
      fmt::format("{}: {} a step, {}.{}", best[0]->name, figures::TimeText(best[0]->step_ns),
                  SpeedOver(*best[0], baseline), TiesText(best));
  if (!own.empty() && own[0] != best[0])
    text += fmt::format(" Of Bullet's: {}, {} a step, {}.{}", own[0]->name,
                        figures::TimeText(own[0]->step_ns), SpeedOver(*own[0], baseline),
                        TiesText(own));
  return text;
}

std::string VerificationText(const std::vector<figures::SceneVerification>& scenes) {
  Table table;
  for (const char* head : {"scene", "last states alike", "scores compared", "result"})
    table.AddColumn(head, false);
  for (const figures::SceneVerification& of : scenes)
    table.rows.push_back(
        {of.scene, of.states, fmt::format("{} of {}", of.timed, of.claimed), OutcomeText(of)});
  std::string text = TextOf({{.table = std::move(table)}}, Format::kTerminal);
  for (const figures::SceneVerification& of : scenes)
    for (const std::string& line : of.disagreements)
      text += terminal::Wrapped(fmt::format("{}: {}", of.scene, line), 2);
  return text;
}

}  // namespace cdb::printers
