#include "compiler/plan/race_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cdb::plan {
namespace {

/// Probabilities p of being slower, from 1/2 to 1, each of which is a bet of 2 p - 1. The squares
/// of evenly spaced sines weight them as Jeffreys' prior does, by which the evidence grows nearly
/// as fast as by the best bet (Krichevsky and Trofimov 1981, The performance of universal
/// encoding).
constexpr std::size_t kBets = 64;

/// The logarithms of what a bet multiplies the fortune by.
struct Bet {
  double if_slower, if_faster;
};

std::array<Bet, kBets> MakeBets() {
  std::array<Bet, kBets> all{};
  for (std::size_t i = 0; i < kBets; ++i) {
    const double part = (static_cast<double>(i) + 0.5) / static_cast<double>(kBets);
    const double sine = std::sin(std::numbers::pi / 4 * (1 + part));
    const double p = sine * sine;
    all[i] = {std::log(2 * p), std::log(2 * (1 - p))};
  }
  return all;
}

double Enough(std::size_t configurations) {
  return static_cast<double>(std::max<std::size_t>(configurations, 2) - 1) / kRaceError;
}

}  // namespace

double RaceEvidence(std::uint64_t slower, std::uint64_t faster) {
  static const std::array<Bet, kBets> kAll = MakeBets();
  double sum = 0;
  for (const Bet& bet : kAll)
    sum += std::exp(static_cast<double>(slower) * bet.if_slower +
                    static_cast<double>(faster) * bet.if_faster);
  return sum / static_cast<double>(kBets);
}

RaceBounds::RaceBounds(std::size_t configurations, std::uint64_t repeats) {
  const double enough = Enough(configurations);
  std::uint64_t slower = 0;
  for (std::uint64_t n = 0; n <= repeats; ++n) {
    // With more repeats, no fewer are enough.
    while (slower <= n && RaceEvidence(slower, n - slower) < enough) ++slower;
    least_slower_.push_back(slower);
  }
}

std::uint64_t LeastRaceRepeats(std::size_t configurations) {
  std::uint64_t repeats = 1;
  while (RaceEvidence(repeats, 0) < Enough(configurations)) ++repeats;
  return repeats;
}

}  // namespace cdb::plan
