// Conclusions about the limits of sound simulation (conclusions.h).
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "runtime/figures/conclusions.h"
#include "runtime/figures/model.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// Limit of different lines of verdicts.
constexpr std::size_t kMaxLines = 4;

class VerdictConclusion {
 public:
  explicit VerdictConclusion(const results::ResultFile& file) : file_(file) {
    for (const Point& at : AllPoints(file))
      if (const Ending ending = WorstEnding(file, at); ending.Rank() >= 0)
        verdicts_[at] = ending.Word();
  }

  std::optional<Conclusion> Get() const {
    const std::size_t all = verdicts_.size();
    std::map<std::string, std::size_t> counts;
    for (const auto& [at, word] : verdicts_) ++counts[word];
    const std::size_t stable = CountOf(counts, "stable"), unknown = CountOf(counts, "unknown");
    if (all == unknown) return std::nullopt;
    const char* question = "Is the simulation sound?";
    if (all == 1)
      return Conclusion{
          question,
          stable == 1 ? "Yes: it is stable." : fmt::format("No: it is {}.", counts.begin()->first),
          "stability", Certainty::kClear};
    if (stable == all)
      return Conclusion{question, fmt::format("Yes: all {} configurations are stable.", all),
                        "stability", Certainty::kClear};
    std::vector<std::string> others;
    for (const auto& [word, count] : counts)
      if (word != "stable") others.push_back(fmt::format("{} {}", count, word));
    return Conclusion{
        "Where does the simulation stop being sound?",
        fmt::format("{} of {} configurations are stable ({}).", stable, all, JoinWords(others)) +
            Along(),
        "stability", Certainty::kClear};
  }

 private:
  static std::size_t CountOf(const std::map<std::string, std::size_t>& counts, const char* word) {
    const auto found = counts.find(word);
    return found == counts.end() ? 0 : found->second;
  }

  /// The number of adjacent points along the axis whose verdicts differ.
  std::size_t ChangesAlong(std::size_t axis) const {
    std::size_t changes = 0;
    for (const auto& [at, word] : verdicts_) {
      Point next = at;
      ++next[axis];
      const auto found = verdicts_.find(next);
      changes += found != verdicts_.end() && found->second != word ? 1 : 0;
    }
    return changes;
  }

  /// The axis of numbers along which verdicts change most.
  std::optional<std::size_t> OwnAxis() const {
    std::optional<std::size_t> own;
    std::size_t most = 0;
    for (std::size_t i = 0; i < file_.axes().size(); ++i) {
      if (file_.axes()[i].IsText()) continue;
      const std::size_t changes = ChangesAlong(i);
      if (changes <= most) continue;
      most = changes;
      own = i;
    }
    return own;
  }

  /// The verdicts along that axis, one sentence for all places with equal verdicts.
  std::string Along() const {
    const auto own = OwnAxis();
    if (!own) return {};
    std::map<Point, Line> lines;
    for (const auto& [at, word] : verdicts_) {
      Line& line = lines[Without(at, *own)];
      if (line.empty() || line.back().word != word) line.push_back({word, at[*own], at[*own]});
      line.back().last = at[*own];
    }
    std::map<std::string, std::vector<Point>> places;
    for (const auto& [place, line] : lines) places[TextOf(*own, line)].push_back(place);
    if (places.size() > kMaxLines) return {};
    std::string text;
    for (const auto& [line, alike] : places)
      text += fmt::format(" Along {}{}: {}.", AxisWords(file_.axes()[*own]),
                          PlacesText(OtherAxes(file_, *own), alike), line);
    return text;
  }

  /// Adjacent points with the same verdict.
  struct Segment {
    std::string word;
    std::size_t first, last;
  };
  using Line = std::vector<Segment>;

  /// `stable 10 .. 90, tunnelled 120`.
  std::string TextOf(std::size_t own, const Line& line) const {
    const plan::Axis& axis = file_.axes()[own];
    std::string text;
    for (const Segment& segment : line)
      text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", segment.word,
                          terminal::CoordinateText(axis, segment.first),
                          segment.last > segment.first
                              ? " .. " + terminal::CoordinateText(axis, segment.last)
                              : "");
    return text;
  }

  /// The coordinates that the places have in common, and their number: ` with day storm (2 cases)`.
  std::string PlacesText(const std::vector<std::size_t>& axes,
                         const std::vector<Point>& places) const {
    std::vector<std::size_t> common;
    Point values;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const bool is_common =
          std::ranges::all_of(places, [&](const Point& place) { return place[i] == places[0][i]; });
      if (!is_common || file_.axes()[axes[i]].values.size() < 2) continue;
      common.push_back(axes[i]);
      values.push_back(places[0][i]);
    }
    const std::string text = PlaceText(file_, common, values);
    return (text.empty() ? text : " with " + text) +
           (places.size() > 1 ? fmt::format(" ({} cases)", places.size()) : "");
  }

  const results::ResultFile& file_;
  std::map<Point, std::string> verdicts_;
};

constexpr std::string_view kCertaintyNames[] = {"clear", "tie", "unknown"};

}  // namespace

void ConcludeVerdicts(const Model& model, std::vector<Conclusion>& all) {
  if (auto conclusion = VerdictConclusion(model.file()).Get())
    all.push_back(*std::move(conclusion));
}

std::string_view CertaintyName(Certainty certainty) {
  return kCertaintyNames[static_cast<std::size_t>(certainty)];
}

std::vector<Conclusion> Conclusions(const Model& model) {
  std::vector<Conclusion> all;
  ConcludeErrors(model, all);
  ConcludeStep(model, all);
  ConcludeDetectors(model, all);
  ConcludeVerdicts(model, all);
  ConcludeAxes(model, all);
  ConcludeDetectorLimits(model, all);
  return all;
}

}  // namespace cdb::figures
