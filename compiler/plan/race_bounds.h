// Races: of several configurations, which is the fastest? Repeats are run in rounds; a
// configuration that is surely slower than another one gets no more of them.
//
// Two configurations are compared by the signs of the differences between their times in the same
// repeat. If the first is the slower one in at most half of the repeats, whatever happened in those
// before, then for each bet b from 0 to 1 the product over the repeats of 1 + b where it is slower,
// 1 - b where it is faster, and 1 where both are equal, is a supermartingale: a fortune that does
// not grow by betting on its being slower. So is the mean over several bets, the evidence here.
// The probability that it ever reaches 1 / alpha is at most alpha, however often one looks (Ville
// 1939; Ramdas et al. 2023, Game-theoretic statistics and safe anytime-valid inference, Statistical
// Science 38). No distribution is assumed: neither a normal one, nor symmetry, nor finite
// variances.
//
// The fastest of k configurations is dropped only if the evidence against one of k - 1 others
// reaches (k - 1) / alpha, so with a probability of at most alpha over the whole race (Bonferroni).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cdb::plan {

/// The probability with which a race may drop the fastest configuration.
inline constexpr double kRaceError = 0.05;
/// The evidence that one configuration is slower than another one in more than half of the
/// repeats.
double RaceEvidence(std::uint64_t slower, std::uint64_t faster);

/// When a configuration is surely slower than another one, in a race of so many.
class RaceBounds {
 public:
  /// For up to `repeats` repeats.
  RaceBounds(std::size_t configurations, std::uint64_t repeats);

  /// The least number of `repeats` in which it must be slower; more than `repeats` if these are too
  /// few.
  std::uint64_t LeastSlower(std::uint64_t repeats) const { return least_slower_[repeats]; }
  std::uint64_t repeats() const { return least_slower_.size() - 1; }

 private:
  std::vector<std::uint64_t> least_slower_;  ///< by repeats
};

/// The least repeats after which a configuration can be dropped.
std::uint64_t LeastRaceRepeats(std::size_t configurations);

}  // namespace cdb::plan
