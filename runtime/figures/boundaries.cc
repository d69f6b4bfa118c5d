#include "runtime/figures/boundaries.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// The values of an axis of numbers in ascending order, as indices.
std::vector<std::size_t> AscendingValues(const plan::Axis& axis) {
  std::vector<std::size_t> order(axis.values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {},
                           [&](std::size_t i) { return std::get<double>(axis.values[i]); });
  return order;
}

/// Limit of the parts of a list of values: `60, 240 .. 480 and 960` has three.
constexpr std::size_t kMostParts = 4;
/// Limit of points that are named one by one.
constexpr std::size_t kMostPoints = 3;
/// Neighbouring numbers from which on they are a range.
constexpr std::size_t kLeastForRange = 3;

/// The axes with several values.
std::vector<std::size_t> SweptAxes(const results::ResultFile& file,
                                   const std::vector<std::size_t>& axes) {
  std::vector<std::size_t> swept;
  for (const std::size_t axis : axes)
    if (file.axes()[axis].values.size() > 1) swept.push_back(axis);
  return swept;
}

/// `mu 0.4 .. 1`; empty for a long list. `all`: the values that occur.
std::string ListText(const plan::Axis& axis, const std::set<std::size_t>& values,
                     const std::set<std::size_t>& all) {
  std::vector<std::size_t> order(all.begin(), all.end());
  if (!axis.IsText())
    std::ranges::stable_sort(order, {},
                             [&](std::size_t i) { return std::get<double>(axis.values[i]); });
  std::vector<std::string> parts;
  const auto text = [&](std::size_t place) { return terminal::CoordinateText(axis, order[place]); };
  for (std::size_t begin = 0; begin < order.size(); ++begin) {
    std::size_t end = begin;
    while (end < order.size() && values.contains(order[end])) ++end;
    if (!axis.IsText() && end - begin >= kLeastForRange) {
      parts.push_back(text(begin) + " .. " + text(end - 1));
    } else {
      for (std::size_t i = begin; i < end; ++i) parts.push_back(text(i));
    }
    begin = end;
  }
  if (parts.size() > kMostParts) return {};
  // Detectors are known by their names.
  return (axis.name == "detector" ? "" : axis.name + " ") + JoinWords(parts);
}

}  // namespace

std::string ValuesOfOnly(const results::ResultFile& file, const std::vector<std::size_t>& axes,
                         const std::set<Point>& some, const std::set<Point>& all) {
  std::vector<std::set<std::size_t>> own(axes.size()), any(axes.size());
  for (const Point& point : some)
    for (std::size_t i = 0; i < axes.size(); ++i) own[i].insert(point[i]);
  for (const Point& point : all)
    for (std::size_t i = 0; i < axes.size(); ++i) any[i].insert(point[i]);
  const auto only = [&](std::size_t i, std::size_t j) {
    return std::ranges::none_of(all, [&](const Point& point) {
      return own[i].contains(point[i]) && own[j].contains(point[j]) && !some.contains(point);
    });
  };
  const auto text = [&](std::size_t i) { return ListText(file.axes()[axes[i]], own[i], any[i]); };
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (any[i].size() > 1 && only(i, i) && !text(i).empty()) return text(i);
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t j = i + 1; j < axes.size(); ++j)
      if (any[i].size() > 1 && any[j].size() > 1 && only(i, j) && !text(i).empty() &&
          !text(j).empty())
        return text(i) + " and " + text(j);
  return some.size() == 1 ? PlaceText(file, axes, *some.begin()) : std::string();
}

std::string PointsNoun(const results::ResultFile& file, const std::vector<std::size_t>& axes) {
  std::vector<std::string> names;
  for (const std::size_t axis : SweptAxes(file, axes)) names.push_back(file.axes()[axis].name);
  return fmt::format("{} of {}", names.size() == 1 ? "values" : "combinations", JoinWords(names));
}

std::string PointsText(const results::ResultFile& file, const std::vector<std::size_t>& axes,
                       const std::set<Point>& some, const std::set<Point>& all) {
  const std::string values = ValuesOfOnly(file, axes, some, all);
  if (!values.empty()) return values;
  if (some.size() > kMostPoints)
    return fmt::format("{} of the {} {}", some.size(), all.size(), PointsNoun(file, axes));
  std::vector<std::string> each;
  for (const Point& point : some) each.push_back(fmt::format("({})", PlaceText(file, axes, point)));
  return JoinWords(each);
}

namespace {

/// The states along one axis of numbers.
class Boundary {
 public:
  Boundary(const results::ResultFile& file, const std::map<Point, std::string>& states,
           const BoundaryWords& words, std::size_t axis)
      : file_(file),
        words_(words),
        axis_(axis),
        others_(OtherAxes(file, axis)),
        order_(AscendingValues(file.axes()[axis])),
        lines_(LinesAlong(states)) {
    for (const auto& [place, line] : lines_) {
      places_.insert(place);
      by_line_[TextOf(line)].insert(place);
      changes_ += line.size() - 1;
    }
    if (by_line_.size() > words.most_lines) {
      limits_ = LimitsOf(true);
      if (!limits_) limits_ = LimitsOf(false);
      if (limits_) moving_ = AxesThatMove(*limits_, others_.size());
    }
    form_ = FormOf();
  }

  /// How much a sentence says about every point.
  enum class Form {
    kWhole,     ///< the whole of each line, and the places that have it
    kLimits,    ///< the limit of each, by the only axis that moves it
    kMost,      ///< the whole of each line, and the places that have it, but for the rest
    kExtremes,  ///< the least and the greatest limit
    kCounts,    ///< the whole of each line, and the number of places that have it
    kNoBoundary
  };
  Form form() const { return form_; }
  /// The states do not change along the axis.
  bool IsFlat() const { return changes_ == 0; }
  /// True if it explains the states in fewer words, or, as far as these are alike, more of them.
  bool IsBetterThan(const Boundary& other) const {
    const auto rank = [](const Boundary& of) {
      return std::tuple(static_cast<int>(of.form_), of.by_line_.size(),
                        -static_cast<int>(of.changes_), -static_cast<int>(of.Axis().values.size()));
    };
    return rank(*this) < rank(other);
  }

  std::string Text() const {
    const std::string along = AxisWords(Axis());
    if (by_line_.size() > words_.most_lines) return fmt::format(" Along {}", along) + LimitsText();
    std::vector<std::string> texts;
    for (const auto& [line, alike] : InGridOrder()) {
      const std::string place =
          by_line_.size() > 1 ? PointsText(file_, others_, alike, places_) : std::string();
      texts.push_back(place.empty() ? line : fmt::format("{}: {}", place, line));
    }
    return fmt::format(" Along {}{}{}.", along, by_line_.size() > 1 ? ", " : ": ",
                       fmt::join(texts, "; "));
  }

 private:
  /// Adjacent points with the same state; values by their rank in ascending order.
  struct Segment {
    std::string state;
    std::size_t first, last;
  };
  using Line = std::vector<Segment>;

  const plan::Axis& Axis() const { return file_.axes()[axis_]; }
  std::string ValueText(std::size_t rank) const {
    return terminal::CoordinateText(Axis(), order_[rank]);
  }

  std::map<Point, Line> LinesAlong(const std::map<Point, std::string>& states) const {
    std::map<Point, std::map<std::size_t, std::string>> by_rank;
    for (const auto& [at, state] : states)
      by_rank[Without(at, axis_)]
             [static_cast<std::size_t>(std::ranges::find(order_, at[axis_]) - order_.begin())] =
                 state;
    std::map<Point, Line> lines;
    for (const auto& [place, ranks] : by_rank) {
      Line& line = lines[place];
      for (const auto& [rank, state] : ranks) {
        if (line.empty() || line.back().state != state) line.push_back({state, rank, rank});
        line.back().last = rank;
      }
    }
    return lines;
  }

  Form FormOf() const {
    if (by_line_.size() <= words_.most_lines) {
      std::size_t without = 0, many = 0;
      for (const auto& [line, places] : by_line_) {
        if (places.size() == places_.size() ||
            !ValuesOfOnly(file_, others_, places, places_).empty())
          continue;
        ++without;
        if (places.size() > kMostPoints) ++many;
      }
      return without == 0 ? Form::kWhole : many <= 1 ? Form::kMost : Form::kCounts;
    }
    if (!limits_) return Form::kNoBoundary;
    return moving_.size() == 1 ? Form::kLimits : Form::kExtremes;
  }

  using Alike = std::pair<std::string, std::set<Point>>;
  std::vector<Alike> InGridOrder() const {
    std::vector<Alike> all(by_line_.begin(), by_line_.end());
    std::ranges::sort(all, {}, [](const Alike& of) { return *of.second.begin(); });
    return all;
  }

  std::string Everywhere(const std::string& state) const {
    const auto found = words_.everywhere.find(state);
    return found == words_.everywhere.end() ? state + " everywhere" : found->second;
  }

  /// `stable up to 90, tunnelled from 120`.
  std::string TextOf(const Line& line) const {
    if (line.size() == 1) return Everywhere(line[0].state);
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const auto& [state, first, last] = line[i];
      texts.push_back(i == 0                 ? fmt::format("{} up to {}", state, ValueText(last))
                      : i + 1 == line.size() ? fmt::format("{} from {}", state, ValueText(first))
                      : first == last
                          ? fmt::format("{} {}", state, ValueText(first))
                          : fmt::format("{} {} .. {}", state, ValueText(first), ValueText(last)));
    }
    return fmt::format("{}", fmt::join(texts, ", "));
  }

  /// The good part of the lines: from the lower or the upper end of the axis.
  struct Limits {
    bool is_low = true;
    /// By place: the last good rank, seen from that end; nullopt if none is.
    std::map<Point, std::optional<std::size_t>> last;
  };

  /// Nullopt if a line is good again beyond another state.
  std::optional<Limits> LimitsOf(bool is_low) const {
    Limits limits{.is_low = is_low, .last = {}};
    for (const auto& [place, line] : lines_) {
      const auto good = std::ranges::count(line, words_.good, &Segment::state);
      const Segment& end = is_low ? line.front() : line.back();
      if (good > 1 || (good == 1 && end.state != words_.good)) return std::nullopt;
      std::optional<std::size_t>& last = limits.last[place];
      if (good == 0) continue;
      // Beyond the ends of a line nothing was run.
      if (line.size() == 1)
        last = is_low ? order_.size() - 1 : 0;
      else
        last = is_low ? end.last : end.first;
    }
    return limits;
  }

  /// `up to 200`, `from 30 on`, `nowhere`.
  std::string ReachText(const Limits& limits, std::optional<std::size_t> last) const {
    if (!last) return "nowhere";
    if (*last == (limits.is_low ? order_.size() - 1 : 0)) return "everywhere";
    const std::string at = ValueText(*last);
    return limits.is_low ? "up to " + at : "from " + at + " on";
  }

  /// The others of the axes that move the limit if nothing else changes, as positions in a place.
  static std::vector<std::size_t> AxesThatMove(const Limits& limits, std::size_t others) {
    std::vector<std::size_t> moving;
    for (std::size_t i = 0; i < others; ++i) {
      std::map<Point, std::set<std::optional<std::size_t>>> reached;
      for (const auto& [place, last] : limits.last) reached[Without(place, i)].insert(last);
      if (std::ranges::any_of(reached, [](const auto& each) { return each.second.size() > 1; }))
        moving.push_back(i);
    }
    return moving;
  }

  /// Where many lines stop being good.
  std::string LimitsText() const {
    if (!limits_) {
      const auto again = std::ranges::count_if(lines_, [&](const auto& of) {
        return std::ranges::count(of.second, words_.good, &Segment::state) > 1;
      });
      const std::string noun = PointsNoun(file_, others_);
      return (again == 0
                  ? fmt::format(" there is no boundary: where it is {} differs among the {} {}.",
                                words_.good, places_.size(), noun)
                  : fmt::format(" there is no boundary: {} of the {} {} are {} again beyond a "
                                "value at which they are not.",
                                again, places_.size(), noun, words_.good)) +
             SelectHint();
    }
    if (std::ranges::all_of(limits_->last, [](const auto& of) { return !of.second; }))
      return fmt::format(": {} nowhere.", words_.good);
    if (form_ == Form::kLimits) return TextBy(*limits_, moving_[0], others_[moving_[0]]);
    const auto is_less = [&](const std::optional<std::size_t>& a,
                             const std::optional<std::size_t>& b) {
      if (!a || !b) return b.has_value();
      return limits_->is_low ? *a < *b : *a > *b;
    };
    const auto [least, most] = std::ranges::minmax_element(
        limits_->last, is_less, [](const auto& of) { return of.second; });
    const auto nowhere =
        std::ranges::count_if(limits_->last, [](const auto& of) { return !of.second; });
    std::string text = fmt::format(
        ": {} {} in the worst case, {} in the best{}", words_.good,
        ReachText(*limits_, least->second), ReachText(*limits_, most->second),
        nowhere > 0 ? fmt::format(" ({} of the {} {} are {} nowhere)", nowhere, places_.size(),
                                  PointsNoun(file_, others_), words_.good)
                    : "");
    std::vector<std::string> names;
    for (const std::size_t i : moving_) names.push_back(AxisWords(file_.axes()[others_[i]]));
    return text + (names.empty() ? "." : fmt::format("; it depends on {}.", JoinWords(names))) +
           SelectHint();
  }

  /// How to see the boundary of a single case.
  std::string SelectHint() const {
    std::string options;
    const Point& place = *places_.rbegin();
    for (std::size_t i = 0; i < others_.size(); ++i)
      if (const plan::Axis& axis = file_.axes()[others_[i]]; axis.values.size() > 1)
        options +=
            fmt::format(" --select {}={}", axis.name, terminal::CoordinateText(axis, place[i]));
    return options.empty() ? options
                           : fmt::format(" One case at a time: `cdb show FILE{}`.", options);
  }

  /// The limit for each value of the only other axis that moves it; `place_at`: its position in a
  /// place.
  std::string TextBy(const Limits& limits, std::size_t place_at, std::size_t other) const {
    const plan::Axis& axis = file_.axes()[other];
    std::map<std::size_t, std::string> reached;
    for (const auto& [place, last] : limits.last)
      reached.emplace(place[place_at], ReachText(limits, last));
    std::vector<std::string> texts;
    for (auto begin = reached.begin(); begin != reached.end();) {
      auto end = std::next(begin);
      while (end != reached.end() && end->second == begin->second) ++end;
      const std::string from = terminal::CoordinateText(axis, begin->first);
      const std::string to = terminal::CoordinateText(axis, std::prev(end)->first);
      texts.push_back(fmt::format("{} with {} {}", begin->second, axis.name,
                                  from == to ? from : from + " .. " + to));
      begin = end;
    }
    return fmt::format(": {} {}.", words_.good, JoinWords(texts));
  }

  const results::ResultFile& file_;
  const BoundaryWords& words_;
  const std::size_t axis_;
  const std::vector<std::size_t> others_;
  const std::vector<std::size_t> order_;  ///< the values of the axis, ascending
  const std::map<Point, Line> lines_;     ///< by place on the other axes
  std::set<Point> places_;
  std::map<std::string, std::set<Point>> by_line_;  ///< the places that have each text
  std::size_t changes_ = 0;
  std::optional<Limits> limits_;     ///< of more lines than are given in full
  std::vector<std::size_t> moving_;  ///< AxesThatMove
  Form form_ = Form::kNoBoundary;
};

/// ` That is: drifting with contact bullet and stable with contact faithful.`; empty if some state
/// has no such values.
std::string ValuesOfStates(const results::ResultFile& file,
                           const std::map<Point, std::string>& states) {
  std::map<std::string, std::set<Point>> by_state;
  std::set<Point> all;
  for (const auto& [at, state] : states) {
    by_state[state].insert(at);
    all.insert(at);
  }
  if (by_state.size() < 2) return {};
  std::vector<std::string> texts;
  for (const auto& [state, some] : by_state) {
    const std::string values = ValuesOfOnly(file, AllAxes(file), some, all);
    if (values.empty()) return {};
    texts.push_back(fmt::format("{} with {}", state, values));
  }
  return fmt::format(" That is: {}.", JoinWords(texts));
}

}  // namespace

std::string BoundaryText(const results::ResultFile& file,
                         const std::map<Point, std::string>& states, const BoundaryWords& words) {
  std::optional<Boundary> best;
  for (std::size_t i = 0; i < file.axes().size(); ++i) {
    if (!file.axes()[i].IsScale()) continue;
    Boundary along(file, states, words, i);
    if (!along.IsFlat() && (!best || along.IsBetterThan(*best))) best.emplace(std::move(along));
  }
  if (best && best->form() <= Boundary::Form::kLimits) return best->Text();
  const std::string values = ValuesOfStates(file, states);
  return !values.empty() ? values : best ? best->Text() : std::string();
}

}  // namespace cdb::figures
