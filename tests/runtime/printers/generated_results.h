// Results drawn at random, and what follows from them, computed by hand.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/runtime/figures/made_up_file.h"

namespace cdb::tests {

/// The runs of a point, by hand.
struct ByHand {
  std::vector<MadeUp> ran;  ///< with their repeats in order

  static int Rank(const MadeUp& run) {
    if (run.status == results::Status::kFailed) return 100;
    return static_cast<int>(run.verdict);
  }
  static std::string Word(const MadeUp& run) {
    if (run.status == results::Status::kFailed) return "failed";
    if (run.status == results::Status::kCrashed) return "crashed";
    static const std::map<protocol::Verdict, std::string> kWords = {
        {protocol::Verdict::kStable, "stable"},
        {protocol::Verdict::kDrifting, "drifting"},
        {protocol::Verdict::kTunnelled, "tunnelled"},
        {protocol::Verdict::kFrozen, "frozen"}};
    return kWords.at(run.verdict);
  }
  static bool IsSound(const MadeUp& run) {
    return run.status == results::Status::kDone && run.verdict != protocol::Verdict::kFrozen;
  }

  const MadeUp& Worst(const std::vector<MadeUp>& of) const {
    return *std::ranges::max_element(of, {}, Rank);
  }
  std::string Verdict() const { return Word(Worst(ran)); }
  std::optional<std::int64_t> FirstBadCycle() const {
    std::optional<std::int64_t> first;
    for (const MadeUp& run : ran)
      if (Rank(run) == Rank(Worst(ran)) && run.verdict > protocol::Verdict::kStable)
        first = std::min(first.value_or(run.first_bad_cycle), run.first_bad_cycle);
    return first;
  }
  /// The sound runs; if there are none, all with cycles.
  std::vector<MadeUp> Used() const {
    std::vector<MadeUp> sound, timed;
    for (const MadeUp& run : ran) {
      if (IsSound(run)) sound.push_back(run);
      if (run.cycles > 0) timed.push_back(run);
    }
    return sound.empty() ? timed : sound;
  }
  std::string Fault() const {
    const std::vector<MadeUp> used = Used();
    if (used.empty()) return Verdict();
    return IsSound(used[0]) ? "" : Word(Worst(used));
  }
  /// The mean over the cycles of their medians over the repeats.
  double Mean() const {
    const std::vector<MadeUp> used = Used();
    double sum = 0;
    std::size_t cycles = 0;
    for (std::uint64_t c = 0; c < kMadeUpCycles; ++c) {
      std::vector<double> times;
      for (const MadeUp& run : used)
        if (c < run.cycles) times.push_back(run.ns + (c == 0 ? run.stall : 0));
      if (times.empty()) continue;
      std::ranges::sort(times);
      sum += (times[(times.size() - 1) / 2] + times[times.size() / 2]) / 2;
      ++cycles;
    }
    return cycles == 0 ? NAN : sum / static_cast<double>(cycles);
  }
  double PeakRss() const {
    double most = NAN;
    for (const MadeUp& run : Used()) most = std::fmax(most, run.peak_rss);
    return most;
  }
};

/// A sweep and the runs that it had.
class Generated {
 public:
  explicit Generated(unsigned seed) : random_(seed) {
    const bool has_errors = Below(2) == 0;
    std::vector<plan::Axis> axes = {
        TextAxis("detector", Below(3) == 0 ? std::vector<std::string>{"dbvt"}
                                           : std::vector<std::string>{"simple", "dbvt", "sap"}),
        NumberAxis("x", Below(2) == 0 ? std::vector<double>{1, 2, 4} : std::vector<double>{3, 5})};
    if (Below(2) == 0) axes.push_back(TextAxis("case", {"calm", "storm"}));
    std::ranges::shuffle(axes, random_);
    plan_ =
        MakePlan(axes, 1 + Below(6),
                 {.cycles = kMadeUpCycles,
                  .record = {"timing"},
                  .metrics = has_errors ? schema::WordList{"position"} : schema::WordList{"none"}});
    const unsigned holes = Below(4);  // how much of the sweep did not end well
    for (const plan::Run& run : plan_.runs) {
      runs_[run.id] = Make(holes, 1000.0 * (1 + static_cast<double>(run.at[0])));
      by_hand_[NameOf(run.at)];
      if (runs_[run.id].status != results::Status::kMissing)
        by_hand_[NameOf(run.at)].ran.push_back(runs_[run.id]);
    }
  }

  const plan::Plan& plan() const { return plan_; }
  MadeUp Of(const plan::Run& run) const { return runs_.at(run.id); }
  const std::map<std::string, ByHand>& by_hand() const { return by_hand_; }

  std::string NameOf(const std::vector<std::size_t>& at) const {
    std::string name;
    for (std::size_t i = 0; i < at.size(); ++i) name += Coordinate(plan_.axes[i], at[i]);
    return name;
  }
  static std::string Coordinate(const plan::Axis& axis, std::size_t index) {
    const auto* number = std::get_if<double>(&axis.values[index]);
    std::ostringstream text;
    text << " " << axis.name << " ";
    if (number != nullptr)
      text << *number;
    else
      text << std::get<std::string>(axis.values[index]);
    return text.str();
  }

 private:
  unsigned Below(unsigned n) { return static_cast<unsigned>(random_() % n); }

  MadeUp Make(unsigned holes, double ns) {
    MadeUp made = {.ns = ns * (1 + 0.1 * Below(10)),
                   .stall = Below(3) * 500.0,
                   .peak_rss = 1e6 * (5 + Below(9)),
                   .errors = {{"position", 0.25 + Below(4)}}};
    made.first_bad_cycle = Below(4);
    if (Below(4) == 0) made.verdict = protocol::Verdict::kTunnelled;
    if (Below(6) == 0) made.verdict = protocol::Verdict::kDrifting;
    if (Below(12) >= 3 * holes) return made;
    switch (Below(4)) {
      case 0:
        made.status = results::Status::kMissing;
        break;
      case 1:
        made.verdict = protocol::Verdict::kFrozen;
        break;
      case 2:
        made.status = results::Status::kFailed;
        made.verdict = protocol::Verdict::kUnknown;
        made.cycles = 0;
        break;
      default:
        made.status = results::Status::kCrashed;
        made.verdict = protocol::Verdict::kCrashed;
        made.cycles = 2;
    }
    return made;
  }

  std::mt19937 random_;
  plan::Plan plan_;
  std::map<std::string, MadeUp> runs_;
  std::map<std::string, ByHand> by_hand_;
};

}  // namespace cdb::tests
