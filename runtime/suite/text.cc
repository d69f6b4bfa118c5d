#include "runtime/suite/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "runtime/report/table.h"
#include "runtime/report/wrap.h"

namespace cdb::suite {
namespace {

/// `1.50 ms`
std::string TimeText(double ns) {
  const auto unit = report::TimeUnit::For(ns);
  return fmt::format("{} {}", report::ShortNumber(ns / unit.ns), unit.name);
}

std::string MemoryText(double bytes) {
  return std::isnan(bytes) ? "-" : fmt::format("{:.0f} MB", bytes / 1e6);
}

std::string RatioText(double ratio) {
  return std::isnan(ratio) ? "-" : fmt::format("{:.2f}", ratio);
}

std::string RangeText(const report::Interval& interval) {
  return std::isnan(interval.low) ? "-"
                                  : fmt::format("{:.2f} .. {:.2f}", interval.low, interval.high);
}

/// Of a configuration in a scene; a dash where it has no score there.
std::string SpeedupText(const SceneFigures& scene, const std::string& name) {
  const ConfigurationFigures* of = scene.Find(name);
  return of == nullptr || !of->HasScore() ? "-" : RatioText(of->speedup.value);
}

std::string KindTable(const KindFigures& kind) {
  report::Table table;
  table.AddColumn("configuration", false);
  for (const char* head : {"score", "95 % interval", "memory"}) table.AddColumn(head, true);
  for (const SceneFigures* scene : kind.scenes)
    table.AddColumn(std::string(scene->scene->name), true);
  for (const KindScore& score : kind.scores) {
    std::vector<std::string> row = {score.name,
                                    score.faults.empty() ? RatioText(score.score) : "none",
                                    RangeText(score.interval), MemoryText(score.memory_bytes)};
    for (const SceneFigures* scene : kind.scenes) row.push_back(SpeedupText(*scene, score.name));
    table.AddRow(std::move(row));
  }
  return table.Text();
}

/// Configurations with the same faults stand together.
std::string FaultLines(const KindFigures& kind) {
  std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> by_faults;
  for (const KindScore& score : kind.scores) {
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
    text += report::Wrapped(
        fmt::format("No score: {}: {}", fmt::join(names, ", "), fmt::join(faults, "; ")), 2);
  return text;
}

/// `skin`, `-`.
std::string NameOf(const ConfigurationFigures* of) { return of == nullptr ? "-" : of->name; }

/// The fastest of those that are as right as the most accurate.
const ConfigurationFigures* Best(const SceneFigures& scene, bool only_bullets_own) {
  return Recommend(scene, std::numeric_limits<double>::infinity(), only_bullets_own);
}

std::string SpeedOver(const ConfigurationFigures& of, const ConfigurationFigures& baseline) {
  if (&of == &baseline) return "the baseline";
  const double ratio = of.speedup.value;
  return fmt::format("{:.2f} times as fast as {}{}", ratio, baseline.name,
                     std::isnan(of.speedup_interval.low)
                         ? ""
                         : fmt::format(" (95 % interval {})", RangeText(of.speedup_interval)));
}

}  // namespace

std::string ScoreText(const std::vector<KindFigures>& kinds) {
  std::string text;
  for (const KindFigures& kind : kinds) {
    text += fmt::format("{}: {}\n", kind.kind->name, kind.kind->doc);
    text += KindTable(kind) + FaultLines(kind);
    text += fmt::format("  1 is {}; 2 is twice as fast.\n\n", kind.baseline);
  }
  return text;
}

std::string RecommendationText(const std::vector<SceneFigures>& scenes) {
  report::Table table;
  table.AddColumn("scene", false);
  table.AddColumn("fastest of all", false);
  table.AddColumn("of Bullet's own", false);
  for (const Budget& budget : kBudgets) table.AddColumn(fmt::format("in {}", budget.name), false);
  for (const SceneFigures& scene : scenes) {
    std::vector<std::string> row = {scene.scene->Id(), NameOf(Best(scene, false)),
                                    NameOf(Best(scene, true))};
    for (const Budget& budget : kBudgets)
      row.push_back(NameOf(Recommend(scene, budget.seconds, false)));
    table.AddRow(std::move(row));
  }
  return "Which one to take\n" + table.Text();
}

std::string AnswerText(const SceneFigures& scene) {
  const ConfigurationFigures& baseline = scene.configurations[0];
  const ConfigurationFigures* best = Best(scene, false);
  if (best == nullptr) return "No configuration is right here, or no time counts.";
  std::string text = fmt::format("{}: {} a step, {}.", best->name, TimeText(best->step_ns),
                                 SpeedOver(*best, baseline));
  const ConfigurationFigures* own = Best(scene, true);
  if (own != nullptr && own != best)
    text += fmt::format(" Of Bullet's own: {}, {} a step, {}.", own->name, TimeText(own->step_ns),
                        SpeedOver(*own, baseline));
  return text;
}

}  // namespace cdb::suite
