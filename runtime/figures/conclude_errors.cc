// Conclusions about configurations that are both accurate enough and fast (conclusions.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compiler/schema/metrics.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/detectors.h"
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
                       row.IsBelowFloor() ? " (its floor)" : "");
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

/// Whether the truth is known well enough to tell the configurations apart.
void ConcludeFloor(const Model& model, const schema::ErrorInfo& error, const ErrorFigures& figures,
                   std::vector<Conclusion>& all) {
  if (!model.file().Has("accuracy/reference")) return;
  std::size_t below = 0, sound = 0;
  double floor = 0;
  for (const auto& [scene, table] : figures.tables)
    for (const ErrorRow& row : table.rows) {
      if (!row.MayBeOnFront()) continue;
      ++sound;
      if (!row.IsBelowFloor()) continue;
      ++below;
      floor = std::fmax(floor, row.floor);
    }
  constexpr double kRounding = 1e-9;  // of no interest, in any unit
  if (below == 0 || floor < kRounding) return;
  all.push_back(
      {fmt::format("Is the reference good enough for {}?", error.name),
       fmt::format("Not for {} of {} configurations: their errors are below the floor of {}{}, by "
                   "which the reference changes with twice its time step and a displaced start. A "
                   "shorter accuracy.reference.timestep lowers the floor, unless the motion is "
                   "chaotic.",
                   below, sound, terminal::ShortNumber(floor),
                   error.unit.empty() ? "" : fmt::format(" {}", error.unit)),
       "reference", Certainty::kClear});
}

/// How the error changes with the time step: its exponent, by a fit to the errors above the floor.
/// Configurations that differ in nothing else make a group.
class Order {
 public:
  Order(const Model& model, const ErrorFigures& figures) : model_(model), figures_(figures) {
    for (const auto& [scene, table] : figures.tables)
      for (const ErrorRow& row : table.rows) Add(scene, row);
  }

  void Conclude(const schema::ErrorInfo& error, std::vector<Conclusion>& all) const {
    double least = kNone, most = kNone;
    for (const auto& [key, points] : groups_) {
      const double order = GrowthExponent(points);  // NaN for fewer than three time steps
      least = std::fmin(least, order);
      most = std::fmax(most, order);
    }
    if (std::isnan(least)) return;
    constexpr double kFlat = 0.25;
    const std::string range = most - least < 0.05 ? fmt::format("{:.2f}", (least + most) / 2)
                                                  : fmt::format("{:.2f} to {:.2f}", least, most);
    std::string text = most < kFlat ? fmt::format("No: as the time step to the power {}.", range)
                       : least < kFlat
                           ? fmt::format("Not everywhere: as the time step to the power {}.", range)
                           : fmt::format("Yes: as the time step to the power {}.", range);
    if (least < kFlat)
      text +=
          " Where it does not fall, something else makes the error: the iterations of the "
          "solver, contact settings or margins, or chaotic motion.";
    all.push_back({fmt::format("Does the error of {} fall with the time step?", error.name), text,
                   "order", Certainty::kClear});
  }

 private:
  /// Rows of several time steps, and rows that are not known to have an error, are left out.
  void Add(const Point& scene, const ErrorRow& row) {
    if (!row.MayBeOnFront() || row.IsBelowFloor() || !(row.error > 0)) return;
    const double timestep = model_.TimeStepOf(*row.row.points.front());
    for (const MeasuredPoint* point : row.row.points)
      if (model_.TimeStepOf(*point) != timestep) return;
    if (!(timestep > 0)) return;
    Point rest = row.row.at;
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (IsOfTimeStep(figures_.rows[i])) rest[i] = 0;
    groups_[{scene, rest}].emplace_back(timestep, row.error);
  }

  /// Whether the time step changes along an axis.
  bool IsOfTimeStep(std::size_t axis) const {
    const auto [known, is_new] = is_of_time_step_.try_emplace(axis, false);
    if (!is_new) return known->second;
    std::map<Point, double> steps;
    for (const MeasuredPoint& point : model_.points()) {
      Point rest = point.at;
      rest[axis] = 0;
      const double step = model_.TimeStepOf(point);
      const auto [found, is_first] = steps.try_emplace(rest, step);
      known->second = known->second || (!is_first && found->second != step);
    }
    return known->second;
  }

  const Model& model_;
  const ErrorFigures& figures_;
  /// Time steps and errors.
  std::map<std::pair<Point, Point>, std::vector<std::pair<double, double>>> groups_;
  mutable std::map<std::size_t, bool> is_of_time_step_;
};

}  // namespace

void ConcludeErrors(const Model& model, std::vector<Conclusion>& all) {
  for (const auto& [error, figures] : CollectAllErrors(model)) {
    // Of different scenes, none is the best.
    if (figures.tables.size() <= kMaxScenes && figures.has_fronts)
      for (const auto& [scene, table] : figures.tables)
        ErrorConclusions(model, *error, figures).Add(scene, table, all);
    ConcludeFloor(model, *error, figures, all);
    if (error->needs_truth) Order(model, figures).Conclude(*error, all);
  }
}

}  // namespace cdb::figures
