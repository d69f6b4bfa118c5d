#include "runtime/figures/races/race.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace cdb::races {
namespace {

class Runner {
 public:
  Runner(const Times& times, const plan::RaceBounds& bounds, double tolerance)
      : times_(times),
        bounds_(bounds),
        most_(times.empty() ? 0 : times[0].size()),
        tolerance_(tolerance) {
    race_.standings.resize(times.size());
    for (std::size_t i = 0; i < times.size(); ++i) running_.push_back(i);
  }

  Race Run() {
    if (most_ == 0) return std::move(race_);
    std::uint64_t repeats = 1;
    for (;;) {
      if (!HasRuns(repeats)) return std::move(race_);
      DropFailed(repeats);
      if (running_.empty()) return std::move(race_);
      Compare(repeats);
      if (running_.size() > 1) DropSlower(repeats);
      if (HasEnded(repeats)) break;
      repeats = NextLook(repeats);
    }
    return std::move(race_);
  }

 private:
  using Values = std::span<const double>;

  Values TimesOf(std::size_t configuration, std::uint64_t repeats) const {
    return Values(times_[configuration]).first(repeats);
  }

  /// False if some of the first repeats of those that are still running are missing: they are next.
  bool HasRuns(std::uint64_t repeats) {
    for (const std::size_t i : running_)
      for (std::uint64_t r = 0; r < repeats; ++r)
        if (std::isnan(times_[i][r])) race_.next.emplace_back(i, r);
    if (race_.next.empty()) return true;
    for (const std::size_t i : running_) race_.standings[i].outcome = Outcome::kNotKnown;
    return false;
  }

  void DropFailed(std::uint64_t repeats) {
    std::erase_if(running_, [&](std::size_t i) {
      const Values all = TimesOf(i, repeats);
      const auto failed = std::ranges::find_if(all, [](double time) { return std::isinf(time); });
      if (failed == all.end()) return false;
      race_.standings[i] = {.outcome = Outcome::kFailed,
                            .repeats = static_cast<std::uint64_t>(failed - all.begin()) + 1,
                            .against = i};
      return true;
    });
  }

  /// The logarithms of the ratios in each repeat, ascending.
  std::vector<double> Ratios(std::size_t above, std::size_t below, std::uint64_t repeats) const {
    std::vector<double> ratios;
    for (std::uint64_t r = 0; r < repeats; ++r)
      ratios.push_back(std::log(times_[above][r] / times_[below][r]));
    std::ranges::sort(ratios);
    return ratios;
  }

  bool IsSlower(std::size_t one, std::size_t other, std::uint64_t repeats) const {
    std::uint64_t slower = 0, faster = 0;
    for (std::uint64_t r = 0; r < repeats; ++r) {
      slower += times_[one][r] > times_[other][r];
      faster += times_[one][r] < times_[other][r];
    }
    return slower >= bounds_.LeastSlower(slower + faster);
  }

  Standing Compared(std::size_t one, std::size_t other, std::uint64_t repeats,
                    Outcome outcome) const {
    const std::vector<double> ratios = Ratios(one, other, repeats);
    Standing standing = {outcome, repeats, other, std::exp(figures::Percentile(ratios, 0.5))};
    // A ratio below the bound would be a configuration that is surely slower.
    if (const std::uint64_t least = bounds_.LeastSlower(repeats); least <= repeats)
      standing.bounds = {std::exp(ratios[repeats - least]), std::exp(ratios[least - 1])};
    return standing;
  }

  /// Finds the leader, and compares the others with it.
  void Compare(std::uint64_t repeats) {
    // About the mean of each repeat, as some take longer for all.
    std::vector<double> means(repeats, 0);
    for (const std::size_t i : running_)
      for (std::uint64_t r = 0; r < repeats; ++r)
        means[r] += std::log(times_[i][r]) / static_cast<double>(running_.size());
    const auto median = [&](std::size_t i) {
      std::vector<double> all;
      for (std::uint64_t r = 0; r < repeats; ++r) all.push_back(std::log(times_[i][r]) - means[r]);
      return figures::Median(std::move(all));
    };
    race_.leader = *std::ranges::min_element(running_, {}, median);
    for (const std::size_t i : running_)
      race_.standings[i] = Compared(i, race_.leader, repeats, Outcome::kOpen);
  }

  void DropSlower(std::uint64_t repeats) {
    std::vector<std::pair<std::size_t, std::size_t>> slower;  // than the second
    for (const std::size_t i : running_) {
      if (IsSlower(i, race_.leader, repeats)) {
        slower.emplace_back(i, race_.leader);
        continue;
      }
      const auto other =
          std::ranges::find_if(running_, [&](std::size_t j) { return IsSlower(i, j, repeats); });
      if (other != running_.end()) slower.emplace_back(i, *other);
    }
    // Each may be slower than another one, in a circle.
    if (slower.size() == running_.size()) return;
    for (const auto& [one, other] : slower) {
      race_.standings[one] = Compared(one, other, repeats, Outcome::kDropped);
      std::erase(running_, one);
    }
    if (std::ranges::find(running_, race_.leader) == running_.end()) Compare(repeats);
  }

  bool HasEnded(std::uint64_t repeats) {
    if (running_.size() == 1) {
      race_.standings[running_[0]].outcome = Outcome::kWon;
      return true;
    }
    const double most = std::log1p(tolerance_);
    const bool is_tied = std::ranges::all_of(running_, [&](std::size_t i) {
      const figures::Interval& bounds = race_.standings[i].bounds;
      return i == race_.leader || (std::log(bounds.low) >= -most && std::log(bounds.high) <= most);
    });
    if (!is_tied) return repeats == most_;
    for (const std::size_t i : running_) race_.standings[i].outcome = Outcome::kTied;
    return true;
  }

  /// The number of repeats after which one of those that are running can be dropped at the
  /// earliest, if it is slower in all that follow.
  std::uint64_t EarliestDrop(std::uint64_t repeats) const {
    std::uint64_t slower = 0, faster = repeats;
    for (const std::size_t i : running_) {
      std::uint64_t of_one = 0;
      for (std::uint64_t r = 0; r < repeats; ++r) of_one += times_[i][r] > times_[race_.leader][r];
      if (i == race_.leader || repeats - of_one >= faster) continue;
      slower = of_one;
      faster = repeats - of_one;
    }
    std::uint64_t more = 1;
    while (repeats + more < most_ && bounds_.LeastSlower(repeats + more) > slower + more) ++more;
    return repeats + more;
  }

  std::uint64_t NextLook(std::uint64_t repeats) const {
    const std::uint64_t grown = repeats + (repeats + 7) / 8;
    return std::min(most_, std::max(grown, EarliestDrop(repeats)));
  }

  const Times& times_;
  const plan::RaceBounds& bounds_;
  const std::uint64_t most_;
  const double tolerance_;
  std::vector<std::size_t> running_;  ///< ascending
  Race race_;
};

}  // namespace

Race RunRace(const Times& times, const plan::RaceBounds& bounds, double tolerance) {
  return Runner(times, bounds, tolerance).Run();
}

}  // namespace cdb::races
