// Conclusions about configurations that are both accurate enough and fast (conclusions.h).
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/errors.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// Limit of scenes that get separate conclusions.
constexpr std::size_t kMaxScenes = 3;
/// Limit of configurations that are named individually.
constexpr std::size_t kMaxNamed = 3;

class ErrorConclusions {
 public:
  ErrorConclusions(const Model& model, const schema::ErrorInfo& error, const ErrorFigures& figures)
      : model_(model), error_(error), figures_(figures) {}

  void Add(const Point& scene, const ErrorRows& table, std::vector<Conclusion>& all) const {
    std::vector<const ErrorRow*> sound, in_time;
    for (const ErrorRow& row : table.rows) {
      if (!row.MayBeOnFront()) continue;
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
  std::string Name(const ErrorRow& row) const {
    return PlaceText(model_.file(), figures_.rows, row.row.at);
  }
  std::string ErrorText(const ErrorRow& row) const {
    return fmt::format("{}{}{}", terminal::ShortNumber(row.Known()),
                       error_.unit.empty() ? "" : fmt::format(" {}", error_.unit),
                       row.IsBelowFloor() ? " (its noise floor)" : "");
  }
  /// `12.3 times real time (95 % interval 12.0 .. 12.6)`.
  std::string SpeedText(const ErrorRow& row) const {
    const Interval& ms = row.time_interval;
    const std::string interval = IntervalText({1000 / ms.high, 1000 / ms.low});
    return fmt::format(
        "{} times real time{}", terminal::ShortNumber(row.RealTimeFactor()),
        interval == "-" ? "" : fmt::format(" ({} {})", model_.times().IntervalName(), interval));
  }
  std::string In(const Point& scene) const {
    const std::string text = PlaceText(model_.file(), figures_.each, scene);
    return text.empty() ? text : fmt::format(" for {}", text);
  }
  /// A sentence and its certainty.
  std::pair<std::string, Certainty> MostAccurate(const std::vector<const ErrorRow*>& rows) const {
    const ErrorRow& best = **std::ranges::min_element(rows, {}, &ErrorRow::Known);
    std::vector<std::string> ties;
    for (const ErrorRow* row : rows)
      if (row != &best &&
          (row->Known() == best.Known() || row->PossibleErrors().Overlaps(best.PossibleErrors())))
        ties.push_back(Name(*row));
    std::string text = fmt::format("{}: {}, at {}.", Name(best), ErrorText(best), SpeedText(best));
    if (!ties.empty())
      text += ties.size() <= kMaxNamed
                  ? fmt::format(" The error of {} cannot be told from it.", JoinWords(ties))
                  : fmt::format(" The errors of {} others cannot be told from it.", ties.size());
    if (model_.times().bootstrap().kind() != IntervalKind::kInterval)
      return {text, Certainty::kUnknown};
    return {text, ties.empty() ? Certainty::kClear : Certainty::kTie};
  }

  /// The fast end of the front. `rows`: the fastest first.
  std::string Fastest(const std::vector<const ErrorRow*>& rows) const {
    const ErrorRow& fastest = *rows[0];
    std::vector<std::string> ties;
    for (const ErrorRow* row : rows)
      if (row != &fastest && row->time_interval.Overlaps(fastest.time_interval))
        ties.push_back(Name(*row));
    std::string text = fmt::format(" The fastest is {}: {}, at {}.", Name(fastest),
                                   ErrorText(fastest), SpeedText(fastest));
    if (ties.empty()) return text;
    return text +
           (ties.size() <= kMaxNamed
                ? fmt::format(" The speed of {} cannot be told from it.", JoinWords(ties))
                : fmt::format(" The speeds of {} others cannot be told from it.", ties.size()));
  }

  std::string Front(const std::vector<const ErrorRow*>& rows) const {
    const auto count = static_cast<std::size_t>(
        std::ranges::count_if(rows, [](const ErrorRow* row) { return row->on_front; }));
    if (count == rows.size())
      return fmt::format(" All {} configurations are on the front: accuracy costs time throughout.",
                         count);
    if (count == 1)
      return " It is also the most accurate: no other configuration is worth its time.";
    return fmt::format(
        " {} of {} configurations are on the front: each of the others is no more accurate than a "
        "faster one.",
        count, rows.size());
  }

  const Model& model_;
  const schema::ErrorInfo& error_;
  const ErrorFigures& figures_;
};

}  // namespace

void ConcludeErrors(const Model& model, std::vector<Conclusion>& all) {
  for (const auto& [error, figures] : CollectAllErrors(model)) {
    // Of different scenes, none is the best.
    if (figures.tables.size() > kMaxScenes || !figures.has_fronts) continue;
    for (const auto& [scene, table] : figures.tables)
      ErrorConclusions(model, *error, figures).Add(scene, table, all);
  }
}

}  // namespace cdb::figures
