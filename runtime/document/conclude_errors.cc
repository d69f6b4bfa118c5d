// Which configuration is accurate enough and fast, for conclusions.h.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/document/conclusions.h"
#include "runtime/document/scene_axes.h"
#include "runtime/report/conclusion_words.h"
#include "runtime/report/error_figures.h"
#include "runtime/report/table.h"

namespace cdb::document {
namespace {

/// Scenes that have conclusions of their own.
constexpr std::size_t kMaxScenes = 3;
/// Configurations that are named one by one.
constexpr std::size_t kMaxNamed = 3;

class ErrorConclusions {
 public:
  ErrorConclusions(const ConclusionParts& parts, const schema::ErrorInfo& error,
                   const report::ErrorFigures& figures)
      : parts_(parts), error_(error), figures_(figures) {}

  void Add(const report::Point& scene, const report::ErrorRows& table,
           std::vector<Conclusion>& all) const {
    std::vector<const report::ErrorRow*> sound, in_time;
    for (const report::ErrorRow& row : table.rows) {
      if (row.row.is_void) continue;
      sound.push_back(&row);
      if (row.RealTimeFactor() >= 1) in_time.push_back(&row);
    }
    if (sound.size() < 2) return;
    const auto [accurate, certainty] = MostAccurate(in_time.empty() ? sound : in_time);
    all.push_back({fmt::format("Which configuration has the least error of {} within real time{}?",
                               error_.name, In(scene)),
                   (in_time.empty() ? "None runs in real time. Without that limit, " : "") +
                       accurate + Fastest(sound) + Front(sound),
                   "error", certainty});
  }

 private:
  std::string Name(const report::ErrorRow& row) const {
    return report::SettingText(parts_.file, figures_.rows, row.row.at);
  }
  std::string ErrorText(const report::ErrorRow& row) const {
    return fmt::format("{}{}{}", report::ScientificNumber(row.Known()),
                       error_.unit.empty() ? "" : fmt::format(" {}", error_.unit),
                       row.IsBelowFloor() ? " (its noise floor)" : "");
  }
  /// `12.3 times real time (95 % interval 12.0 .. 12.6)`.
  std::string SpeedText(const report::ErrorRow& row) const {
    const report::Interval& ms = row.time_interval;
    const std::string interval = report::IntervalText({1000 / ms.high, 1000 / ms.low});
    return fmt::format(
        "{} times real time{}", report::ShortNumber(row.RealTimeFactor()),
        interval == "-" ? "" : fmt::format(" ({} {})", parts_.times.IntervalName(), interval));
  }
  std::string In(const report::Point& scene) const {
    const std::string text = report::SettingText(parts_.file, figures_.each, scene);
    return text.empty() ? text : fmt::format(" for {}", text);
  }
  /// A sentence, and how certain it is.
  std::pair<std::string, Certainty> MostAccurate(
      const std::vector<const report::ErrorRow*>& rows) const {
    const report::ErrorRow& best = **std::ranges::min_element(rows, {}, &report::ErrorRow::Known);
    std::vector<std::string> ties;
    for (const report::ErrorRow* row : rows)
      if (row != &best &&
          (row->Known() == best.Known() || row->PossibleErrors().Overlaps(best.PossibleErrors())))
        ties.push_back(Name(*row));
    std::string text = fmt::format("{}: {}, at {}.", Name(best), ErrorText(best), SpeedText(best));
    if (!ties.empty())
      text += ties.size() <= kMaxNamed
                  ? fmt::format(" The error of {} cannot be told from it.", report::JoinWords(ties))
                  : fmt::format(" The errors of {} others cannot be told from it.", ties.size());
    if (parts_.times.bootstrap().kind() != report::IntervalKind::kInterval)
      return {text, Certainty::kUnknown};
    return {text, ties.empty() ? Certainty::kClear : Certainty::kTie};
  }

  /// The other end of the front. `rows`: the fastest first.
  std::string Fastest(const std::vector<const report::ErrorRow*>& rows) const {
    const report::ErrorRow& fastest = *rows[0];
    std::vector<std::string> ties;
    for (const report::ErrorRow* row : rows)
      if (row != &fastest && row->time_interval.Overlaps(fastest.time_interval))
        ties.push_back(Name(*row));
    std::string text = fmt::format(" The fastest is {}: {}, at {}.", Name(fastest),
                                   ErrorText(fastest), SpeedText(fastest));
    if (ties.empty()) return text;
    return text +
           (ties.size() <= kMaxNamed
                ? fmt::format(" The speed of {} cannot be told from it.", report::JoinWords(ties))
                : fmt::format(" The speeds of {} others cannot be told from it.", ties.size()));
  }

  std::string Front(const std::vector<const report::ErrorRow*>& rows) const {
    const auto count = static_cast<std::size_t>(
        std::ranges::count_if(rows, [](const report::ErrorRow* row) { return row->on_front; }));
    if (count == rows.size())
      return fmt::format(" All {} configurations are on the front: accuracy costs time throughout.",
                         count);
    if (count == 1)
      return " It is also the most accurate: no other configuration is worth its time.";
    return fmt::format(
        " {} of {} configurations are on the front: each of the others is no more "
        "accurate than a faster one.",
        count, rows.size());
  }

  const ConclusionParts& parts_;
  const schema::ErrorInfo& error_;
  const report::ErrorFigures& figures_;
};

}  // namespace

void ConcludeErrors(const ConclusionParts& parts, std::vector<Conclusion>& all) {
  if (!parts.file.Has("duration") || parts.points.empty()) return;
  report::ShowErrorOptions options;
  options.only_sound = parts.only_sound;
  for (const std::size_t axis : SceneAxes(parts.file))
    options.each.push_back(parts.file.axes()[axis].name);
  for (const schema::ErrorInfo& error : schema::Errors()) {
    options.error = error.name;
    if (!parts.file.Has("accuracy/" + options.error)) continue;
    const report::ErrorFigures figures = report::CollectErrors(parts.file, options, parts.times);
    if (figures.tables.size() > kMaxScenes) continue;
    for (const auto& [scene, table] : figures.tables)
      ErrorConclusions(parts, error, figures).Add(scene, table, all);
  }
}

}  // namespace cdb::document
