#include "runtime/figures/boundaries.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
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

class Boundary {
 public:
  Boundary(const results::ResultFile& file, const std::map<Point, std::string>& states,
           const BoundaryWords& words)
      : file_(file), words_(words) {
    std::pair<std::size_t, std::size_t> most = {0, 0};  // changes, then values
    for (std::size_t i = 0; i < file.axes().size(); ++i) {
      if (file.axes()[i].IsText()) continue;
      const std::map<Point, Line> lines = LinesAlong(i, states);
      std::size_t changes = 0;
      for (const auto& [place, line] : lines) changes += line.size() - 1;
      const std::pair own = {changes, file.axes()[i].values.size()};
      if (changes == 0 || own <= most) continue;
      most = own;
      own_ = i;
      lines_ = lines;
    }
    if (own_) order_ = AscendingValues(Axis());
  }

  std::string Text() const {
    if (!own_) return {};
    std::map<std::string, std::vector<Point>> places;
    for (const auto& [place, line] : lines_) places[TextOf(line)].push_back(place);
    const std::string along = AxisWords(Axis());
    if (places.size() > words_.most_lines) return fmt::format(" Along {}", along) + LimitsText();
    std::vector<std::string> texts;
    for (const auto& [line, alike] : InGridOrder(places)) {
      const std::string place = places.size() > 1 ? PlacesText(alike) : std::string();
      texts.push_back(place.empty() ? line : fmt::format("{}: {}", place, line));
    }
    return fmt::format(" Along {}{}{}.", along, places.size() > 1 ? ", " : ": ",
                       fmt::join(texts, "; "));
  }

 private:
  /// Adjacent points with the same state; values by their rank in ascending order.
  struct Segment {
    std::string state;
    std::size_t first, last;
  };
  using Line = std::vector<Segment>;

  const plan::Axis& Axis() const { return file_.axes()[*own_]; }
  std::string ValueText(std::size_t rank) const {
    return terminal::CoordinateText(Axis(), order_[rank]);
  }

  std::map<Point, Line> LinesAlong(std::size_t axis,
                                   const std::map<Point, std::string>& states) const {
    const std::vector<std::size_t> order = AscendingValues(file_.axes()[axis]);
    std::map<Point, std::map<std::size_t, std::string>> by_rank;
    for (const auto& [at, state] : states)
      by_rank[Without(at, axis)]
             [static_cast<std::size_t>(std::ranges::find(order, at[axis]) - order.begin())] = state;
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

  using Alike = std::pair<std::string, std::vector<Point>>;
  static std::vector<Alike> InGridOrder(const std::map<std::string, std::vector<Point>>& places) {
    std::vector<Alike> all(places.begin(), places.end());
    std::ranges::sort(all, {}, [](const Alike& of) { return of.second.front(); });
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

  /// `dbvt and auto`, `rate 60`, `rate 60 (2 cases)`, `2 cases`.
  std::string PlacesText(const std::vector<Point>& places) const {
    std::vector<std::size_t> swept;  // of the other axes, their positions in a place
    const std::vector<std::size_t> axes = OtherAxes(file_, *own_);
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (file_.axes()[axes[i]].values.size() > 1) swept.push_back(i);
    if (swept.size() == 1) {
      const plan::Axis& axis = file_.axes()[axes[swept[0]]];
      std::vector<std::string> values;
      for (const Point& place : places)
        values.push_back(terminal::CoordinateText(axis, place[swept[0]]));
      return (axis.IsText() ? "" : axis.name + " ") + JoinWords(values);
    }
    std::vector<std::size_t> common;
    Point values;
    for (const std::size_t i : swept) {
      if (!std::ranges::all_of(places,
                               [&](const Point& place) { return place[i] == places[0][i]; }))
        continue;
      common.push_back(axes[i]);
      values.push_back(places[0][i]);
    }
    const std::string text = PlaceText(file_, common, values);
    if (places.size() == 1) return text;
    return text.empty() ? fmt::format("{} cases", places.size())
                        : fmt::format("{} ({} cases)", text, places.size());
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
      limits.last[place] = good == 0 ? std::nullopt : std::optional(is_low ? end.last : end.first);
    }
    return limits;
  }

  /// `up to 200`, `from 30 on`, `nowhere`.
  std::string ReachText(const Limits& limits, std::optional<std::size_t> last) const {
    if (!last) return "nowhere";
    if (*last == (limits.is_low ? Axis().values.size() - 1 : 0)) return "everywhere";
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
    auto limits = LimitsOf(true);
    if (!limits) limits = LimitsOf(false);
    if (!limits)
      return fmt::format(
          " there is no boundary: some cases are {} again beyond a value at which they are not.",
          words_.good);
    if (std::ranges::all_of(limits->last, [](const auto& of) { return !of.second; }))
      return fmt::format(": {} nowhere.", words_.good);
    const std::vector<std::size_t> others = OtherAxes(file_, *own_);
    const std::vector<std::size_t> moving = AxesThatMove(*limits, others.size());
    if (moving.size() == 1) return TextBy(*limits, moving[0], others[moving[0]]);
    const auto is_less = [&](const std::optional<std::size_t>& a,
                             const std::optional<std::size_t>& b) {
      if (!a || !b) return b.has_value();
      return limits->is_low ? *a < *b : *a > *b;
    };
    const auto [least, most] = std::ranges::minmax_element(
        limits->last, is_less, [](const auto& of) { return of.second; });
    const auto nowhere =
        std::ranges::count_if(limits->last, [](const auto& of) { return !of.second; });
    std::string text =
        fmt::format(": {} {} in the worst case, {} in the best{}", words_.good,
                    ReachText(*limits, least->second), ReachText(*limits, most->second),
                    nowhere > 0 ? fmt::format(" ({} of {} cases are nowhere {})", nowhere,
                                              limits->last.size(), words_.good)
                                : "");
    std::vector<std::string> names;
    for (const std::size_t i : moving) names.push_back(AxisWords(file_.axes()[others[i]]));
    return text + (names.empty() ? "." : fmt::format("; it depends on {}.", JoinWords(names)));
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
  std::optional<std::size_t> own_;  ///< the axis along which the states change most
  std::map<Point, Line> lines_;     ///< along it, by place on the other axes
  std::vector<std::size_t> order_;  ///< its values, ascending
};

}  // namespace

std::string BoundaryText(const results::ResultFile& file,
                         const std::map<Point, std::string>& states, const BoundaryWords& words) {
  return Boundary(file, states, words).Text();
}

}  // namespace cdb::figures
