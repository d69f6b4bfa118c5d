// Conclusions about configurations that are both accurate enough and fast (conclusions.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compiler/schema/metrics.h"
#include "runtime/figures/boundaries.h"
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
/// Smaller errors are of no interest, in any unit.
constexpr double kRounding = 1e-9;

class ErrorConclusions {
 public:
  ErrorConclusions(const Model& model, const schema::ErrorInfo& error, const ErrorFigures& figures)
      : model_(model), error_(error), figures_(figures) {}

  void Add(const Point& scene, const ErrorRows& table, std::vector<Conclusion>& all) const {
    std::vector<const ErrorRow*> sound, in_time;
    std::set<Point> unsound, rows;
    for (const ErrorRow& row : table.rows) {
      rows.insert(row.row.at);
      if (!row.MayBeOnFront()) {
        unsound.insert(row.row.at);
        continue;
      }
      sound.push_back(&row);
      if (row.RealTimeFactor() >= 1) in_time.push_back(&row);
    }
    if (sound.size() < 2) return;
    const auto [accurate, certainty] = MostAccurate(in_time.empty() ? sound : in_time);
    all.push_back({fmt::format("Which configuration has the least error of {} within real time{}?",
                               error_.name, In(scene)),
                   (in_time.empty() ? "None runs in real time. Without that limit, " : "") +
                       accurate + Fastest(sound) + Front(sound, !unsound.empty()) +
                       LeftOut(unsound, rows),
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

  std::string Front(const std::vector<const ErrorRow*>& rows, bool has_others) const {
    const char* which = has_others ? "sound " : "";
    const auto count = static_cast<std::size_t>(
        std::ranges::count_if(rows, [](const ErrorRow* row) { return row->on_front; }));
    if (count == rows.size())
      return fmt::format(
          " All {} {}configurations are on the front: accuracy costs time throughout.", count,
          which);
    if (count == 1)
      return " It is also the most accurate: no other configuration is worth its time.";
    return fmt::format(
        " {} of {} {}configurations are on the front: each of the others is no more accurate than "
        "a faster one.",
        count, rows.size(), which);
  }

  /// ` 7 are not sound, and left out (contact bullet).`
  std::string LeftOut(const std::set<Point>& unsound, const std::set<Point>& rows) const {
    if (unsound.empty()) return {};
    const std::string values = ValuesOfOnly(model_.file(), figures_.rows, unsound, rows);
    return fmt::format(" {} {} not sound, and left out{}.", unsound.size(),
                       unsound.size() == 1 ? "is" : "are",
                       values.empty() ? values : fmt::format(" ({})", values));
  }

  const Model& model_;
  const schema::ErrorInfo& error_;
  const ErrorFigures& figures_;
};

/// Whether the truth is known well enough to tell the configurations apart.
void ConcludeFloor(const Model& model, const schema::ErrorInfo& error, const ErrorFigures& figures,
                   std::vector<Conclusion>& all) {
  if (!model.file().Has("accuracy/reference")) return;
  std::vector<std::size_t> axes = figures.each;
  axes.insert(axes.end(), figures.rows.begin(), figures.rows.end());
  std::set<Point> below, sound;
  std::size_t unsound = 0;
  double floor = 0;
  for (const auto& [scene, table] : figures.tables)
    for (const ErrorRow& row : table.rows) {
      if (!row.MayBeOnFront()) {
        ++unsound;
        continue;
      }
      Point at = scene;
      at.insert(at.end(), row.row.at.begin(), row.row.at.end());
      sound.insert(at);
      if (!row.IsBelowFloor()) continue;
      below.insert(at);
      floor = std::fmax(floor, row.floor);
    }
  if (below.empty() || floor < kRounding) return;
  const std::string where =
      below.size() == sound.size() ? std::string() : ValuesOfOnly(model.file(), axes, below, sound);
  all.push_back(
      {fmt::format("Is the reference good enough for {}?", error.name),
       fmt::format(
           "Not for {} of {} sound configurations{}: their errors are below the floor, up "
           "to {}{}, by which the reference changes with twice its time step and a "
           "displaced start. A shorter accuracy.reference.timestep lowers the floor, unless "
           "the motion is chaotic.{}",
           below.size(), sound.size(), where.empty() ? where : fmt::format(" ({})", where),
           terminal::ShortNumber(floor), error.unit.empty() ? "" : fmt::format(" {}", error.unit),
           unsound == 0 ? "" : fmt::format(" {} unsound ones were not looked at.", unsound)),
       "reference", Certainty::kClear});
}

/// How the error changes with the time step: its exponent, by a fit to the sound errors above the
/// floor, in each case: configurations that differ in the time step alone.
class Order {
 public:
  Order(const Model& model, const schema::ErrorInfo& error, const ErrorFigures& figures)
      : model_(model), error_(error), figures_(figures) {
    for (std::size_t i = 0; i < figures.rows.size(); ++i)
      if (IsOfTimeStep(figures.rows[i])) step_axes_.push_back(figures.rows[i]);
    case_axes_ = figures.each;
    for (const std::size_t axis : figures.rows)
      if (std::ranges::find(step_axes_, axis) == step_axes_.end()) case_axes_.push_back(axis);
    for (const auto& [scene, table] : figures.tables)
      for (const ErrorRow& row : table.rows) Add(scene, row);
    for (auto& [at, of] : cases_) {
      std::ranges::sort(of.steps, std::greater(), &Step::timestep);
      Judge(of);
      all_.insert(at);
      by_answer_[of.answer].insert(at);
    }
  }

  std::vector<ErrorOrder> Fits() const {
    const auto scenes = static_cast<std::ptrdiff_t>(figures_.each.size());
    std::vector<ErrorOrder> fits;
    for (const auto& [at, of] : cases_)
      if (!std::isnan(of.fit.p))
        fits.push_back({{at.begin(), at.begin() + scenes},
                        {case_axes_.begin() + scenes, case_axes_.end()},
                        {at.begin() + scenes, at.end()},
                        of.fit});
    return fits;
  }

  void Conclude(std::vector<Conclusion>& all) const {
    const bool is_asked = std::ranges::any_of(cases_, [](const auto& of) {
      std::set<double> different;
      for (const Step& step : of.second.steps)
        if (!step.IsBelowFloor()) different.insert(step.timestep);
      return different.size() >= kLeastSteps;
    });
    if (!is_asked) return;
    const bool is_clear =
        std::ranges::all_of(cases_, [](const auto& of) { return of.second.is_clear; });
    all.push_back({fmt::format("Does the error of {} fall with the time step?", error_.name),
                   Sentences(), "order", is_clear ? Certainty::kClear : Certainty::kUnknown});
  }

 private:
  /// Fewer different time steps have no order.
  static constexpr std::size_t kLeastSteps = 3;
  /// An error that falls by a lower power does not fall.
  static constexpr double kFlat = 0.25;
  /// A smaller relative rise is none.
  static constexpr double kNoticeableRise = 0.02;

  struct Step {
    double timestep, error, floor;
    std::string place, unsound;
    bool IsBelowFloor() const { return error < std::fmax(floor, kRounding); }
    bool Counts() const { return unsound.empty() && !IsBelowFloor(); }
  };
  enum class Answer { kYes, kNo, kNoOrder, kTooFewSound, kBelowFloor, kScattered };
  struct Case {
    std::vector<Step> steps;  ///< the longest first
    PowerFit fit = {};        ///< of those that count
    Answer answer = Answer::kTooFewSound;
    bool is_clear = false;
    const Step *low = nullptr, *high = nullptr;  ///< the largest rise to a shorter time step
  };
  using Places = std::set<Point>;

  void Add(const Point& scene, const ErrorRow& row) {
    const double timestep = model_.TimeStepOf(*row.row.points.front());
    for (const MeasuredPoint* point : row.row.points)
      if (model_.TimeStepOf(*point) != timestep) return;
    if (!(timestep > 0) || std::isnan(row.error)) return;
    Point at = scene, step_at;
    for (std::size_t i = 0; i < figures_.rows.size(); ++i)
      (std::ranges::find(step_axes_, figures_.rows[i]) == step_axes_.end() ? at : step_at)
          .push_back(row.row.at[i]);
    cases_[at].steps.push_back({timestep, row.error, std::isnan(row.floor) ? 0 : row.floor,
                                PlaceText(model_.file(), step_axes_, step_at),
                                row.row.is_void ? row.row.mark : row.unsound});
  }

  static void Judge(Case& of) {
    PowerGroup sound;
    std::set<double> different;
    for (const Step& step : of.steps) {
      if (step.unsound.empty()) different.insert(step.timestep);
      if (step.Counts()) sound.emplace_back(step.timestep, step.error);
    }
    bool is_monotonic = true;
    double most = 1 + kNoticeableRise;
    for (std::size_t i = 0; i < of.steps.size(); ++i)
      for (std::size_t j = i + 1; j < of.steps.size(); ++j) {
        const Step &longer = of.steps[i], &shorter = of.steps[j];
        const double rise =
            (shorter.error - shorter.floor) / (longer.error + longer.floor + kRounding);
        if (!(rise > 1 + kNoticeableRise)) continue;
        if (longer.Counts() && shorter.Counts()) is_monotonic = false;
        if (rise <= most) continue;
        most = rise;
        of.low = &longer;
        of.high = &shorter;
      }
    of.fit = FitPower({sound});
    if (std::isnan(of.fit.p)) {
      of.answer = different.size() < kLeastSteps ? Answer::kTooFewSound : Answer::kBelowFloor;
      return;
    }
    const bool has_order = of.fit.interval.low > 0;
    const bool is_flat = of.fit.interval.high < kFlat;
    if (of.fit.p >= kFlat && has_order) {
      of.answer = Answer::kYes;
      of.is_clear = is_monotonic;
    } else if (is_flat || sound.back().second >= sound.front().second) {
      of.answer = Answer::kNo;
      of.is_clear = is_flat;
    } else if (is_monotonic) {
      of.answer = Answer::kNoOrder;
    } else {
      of.answer = Answer::kScattered;
    }
  }

  /// ` in 7 of 11 values of mu (mu 0.4 .. 1)`; empty if these are all.
  std::string Where(const Places& some) const {
    if (some.size() == all_.size()) return {};
    const std::string values = ValuesOfOnly(model_.file(), case_axes_, some, all_);
    return fmt::format(" for {} of {} {}{}", some.size(), all_.size(),
                       PointsNoun(model_.file(), case_axes_),
                       values.empty() ? values : fmt::format(" ({})", values));
  }

  const Places* Find(Answer answer) const {
    const auto found = by_answer_.find(answer);
    return found == by_answer_.end() ? nullptr : &found->second;
  }

  /// `as the time step to the power 1.99 to 2.41 (95 % intervals within 1.2 .. 3.1)`.
  std::string PowerText(const Places& places) const {
    double least = kNone, most = kNone;
    Interval interval = {kNone, kNone};
    for (const Point& at : places) {
      const PowerFit& fit = cases_.at(at).fit;
      least = std::fmin(least, fit.p);
      most = std::fmax(most, fit.p);
      interval = {std::fmin(interval.low, fit.interval.low),
                  std::fmax(interval.high, fit.interval.high)};
    }
    return fmt::format("as the time step to the power {} ({} {:.2f} .. {:.2f})",
                       most - least < 0.05 ? fmt::format("{:.2f}", (least + most) / 2)
                                           : fmt::format("{:.2f} to {:.2f}", least, most),
                       places.size() == 1 ? "95 % interval" : "95 % intervals within", interval.low,
                       interval.high);
  }

  std::string Sentences() const {
    std::string all;
    for (const std::string& text :
         {Told(Answer::kYes, "Yes", ""),
          // The fit of a few steps tells nothing.
          Told(Answer::kNoOrder, "It falls with each shorter time step",
               ", but the order cannot be told from so few or such scattered errors"),
          NotFalling(), NotJudged(), Rises()})
      if (!text.empty()) all += (all.empty() ? "" : " ") + text;
    return all;
  }

  /// A sentence on the cases with this answer: `begin`, where they are, `end` and their powers.
  std::string Told(Answer answer, std::string_view begin, std::string_view end) const {
    const Places* places = Find(answer);
    if (places == nullptr) return {};
    return fmt::format("{}{}{}: {}.", begin, Where(*places), end, PowerText(*places));
  }

  std::string NotFalling() const {
    std::string text = Told(Answer::kNo, "No", "");
    if (!text.empty())
      text +=
          " Where it does not fall, something else makes the error: the iterations of the solver, "
          "contact settings or margins, walls that are planes, or chaotic motion.";
    return text;
  }

  std::string NotJudged() const {
    std::string text;
    std::size_t unsound = 0;
    for (const auto& [answer, why] :
         {std::pair(Answer::kTooFewSound, "fewer than three time steps are sound"),
          std::pair(Answer::kBelowFloor, "fewer than three errors are above the floor"),
          std::pair(Answer::kScattered, "the errors scatter")})
      if (const Places* places = Find(answer))
        text += fmt::format("{}Not judged{}: {}.", text.empty() ? "" : " ", Where(*places), why);
    for (const auto& [at, of] : cases_)
      if (!std::isnan(of.fit.p))
        unsound += static_cast<std::size_t>(std::ranges::count_if(
            of.steps, [](const Step& step) { return !step.unsound.empty(); }));
    if (unsound > 0)
      text += fmt::format("{}{} unsound time step{} left out of the fits.", text.empty() ? "" : " ",
                          unsound, unsound == 1 ? " is" : "s are");
    return text;
  }

  /// The largest rises, also those to or from time steps that are not sound.
  std::string Rises() const {
    std::vector<std::pair<double, std::string>> rises;
    for (const auto& [at, of] : cases_) {
      if (of.low == nullptr) continue;
      const std::string place = PlaceText(model_.file(), case_axes_, at);
      const auto text = [&](const Step& step) {
        return fmt::format("{}{} at {}{}", terminal::ShortNumber(step.error),
                           error_.unit.empty() ? "" : fmt::format(" {}", error_.unit), step.place,
                           step.unsound.empty() ? "" : fmt::format(" ({})", step.unsound));
      };
      rises.emplace_back(of.low->error / of.high->error,
                         fmt::format("from {} to {}{}", text(*of.low), text(*of.high),
                                     place.empty() ? place : fmt::format(" with {}", place)));
    }
    if (rises.empty()) return {};
    std::ranges::sort(rises);
    std::vector<std::string> named;
    for (std::size_t i = 0; i < std::min(rises.size(), kMaxNamed); ++i)
      named.push_back(rises[i].second);
    if (rises.size() > kMaxNamed)
      named.push_back(fmt::format("in {} other cases", rises.size() - kMaxNamed));
    return fmt::format("The error rises {}.", JoinWords(named));
  }

  /// Whether the time step changes along an axis.
  bool IsOfTimeStep(std::size_t axis) const {
    std::map<Point, double> steps;
    return std::ranges::any_of(model_.points(), [&](const MeasuredPoint& point) {
      const double step = model_.TimeStepOf(point);
      return steps.try_emplace(Without(point.at, axis), step).first->second != step;
    });
  }

  const Model& model_;
  const schema::ErrorInfo& error_;
  const ErrorFigures& figures_;
  std::vector<std::size_t> step_axes_, case_axes_;
  std::map<Point, Case> cases_;  ///< by the coordinates on `case_axes_`
  Places all_;
  std::map<Answer, Places> by_answer_;
};

}  // namespace

std::vector<ErrorOrder> OrdersOf(const Model& model, const schema::ErrorInfo& error,
                                 const ErrorFigures& figures) {
  if (!error.needs_truth) return {};
  return Order(model, error, figures).Fits();
}

void ConcludeErrors(const Model& model, std::vector<Conclusion>& all) {
  for (const auto& [error, figures] : CollectAllErrors(model)) {
    // Of different scenes, none is the best.
    if (figures.tables.size() <= kMaxScenes && figures.has_fronts)
      for (const auto& [scene, table] : figures.tables)
        ErrorConclusions(model, *error, figures).Add(scene, table, all);
    ConcludeFloor(model, *error, figures, all);
    if (error->needs_truth) Order(model, *error, figures).Conclude(all);
  }
}

}  // namespace cdb::figures
