// The rules of a race, and how often it drops the fastest configuration.
#include "runtime/figures/races/race.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/plan/race.h"
#include "compiler/plan/race_bounds.h"

namespace cdb::races {
namespace {

constexpr double kNotRun = std::numeric_limits<double>::quiet_NaN(),
                 kFailedRun = std::numeric_limits<double>::infinity();

Race RunWith(const Times& times, double tolerance = 0.01) {
  return RunRace(times, plan::RaceBounds(times.size(), times[0].size()), tolerance);
}

/// The numbers of a seed, the same with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// Above 0 and below 1.
  double Uniform() {
    state_ = plan::StreamSeed(state_, "race");
    return (static_cast<double>(state_ >> 12) + 0.5) * 0x1p-52;
  }
  double Normal() {
    return std::sqrt(-2 * std::log(Uniform())) * std::cos(2 * std::numbers::pi * Uniform());
  }
  /// Student's t with two degrees of freedom, whose variance is infinite.
  double HeavyTailed() { return Normal() / std::sqrt(-std::log(Uniform())); }

 private:
  std::uint64_t state_;
};

/// Noise as a part of a time.
constexpr double kNoise = 0.03;

enum class Noise {
  kNormal,
  kHeavyTails,
  kDrift,            ///< a random walk that all have in common
  kSpikes,           ///< one run in ten takes three times as long
  kSpikesOfFastest,  ///< only of the fastest
  kStallsOfFastest,  ///< one run in five of the fastest takes twice as long
  kPersistent,       ///< each has a drift of its own
};

struct Model {
  const char* name;
  Noise noise;
  std::size_t racers;
  double gap;  ///< by which the second fastest is slower; 0: all are as fast
  bool is_promised = true;
};

/// Made-up times: configuration i takes (1 + gap)^i.
Times MakeTimes(const Model& model, std::uint64_t repeats, std::uint64_t seed) {
  Random random(seed);
  Times times(model.racers);
  double drift = 0;
  std::vector<double> persistent(model.racers, 0);
  for (std::uint64_t r = 0; r < repeats; ++r) {
    drift += 0.05 * random.Normal();
    for (std::size_t i = 0; i < model.racers; ++i) {
      double log = static_cast<double>(i) * std::log1p(model.gap);
      log += kNoise * (model.noise == Noise::kHeavyTails ? random.HeavyTailed() : random.Normal());
      const double spike = random.Uniform();
      if (model.noise == Noise::kDrift) log += drift;
      if (spike < 0.1 &&
          (model.noise == Noise::kSpikes || (model.noise == Noise::kSpikesOfFastest && i == 0)))
        log += std::log(3.0);
      if (spike < 0.2 && model.noise == Noise::kStallsOfFastest && i == 0) log += std::log(2.0);
      if (model.noise == Noise::kPersistent) {
        persistent[i] = 0.9 * persistent[i] + kNoise * random.Normal();
        log += persistent[i];
      }
      times[i].push_back(std::exp(log));
    }
  }
  return times;
}

struct Rates {
  double dropped = 0;  ///< the part of the races that dropped the fastest configuration
  double won = 0;      ///< that the fastest won
  double runs = 0;     ///< the part of the runs that were executed
};

Rates Simulate(const Model& model, std::uint64_t repeats, std::uint64_t races) {
  const plan::RaceBounds bounds(model.racers, repeats);
  Rates rates;
  for (std::uint64_t seed = 1; seed <= races; ++seed) {
    const Race race = RunRace(MakeTimes(model, repeats, seed), bounds, plan::kRaceTolerance);
    EXPECT_TRUE(race.HasEnded());
    rates.dropped += race.standings[0].outcome == Outcome::kDropped;
    rates.won += race.standings[0].outcome == Outcome::kWon;
    for (const Standing& of : race.standings) rates.runs += static_cast<double>(of.repeats);
  }
  const auto all = static_cast<double>(races);
  return {rates.dropped / all, rates.won / all,
          rates.runs / all / static_cast<double>(model.racers * repeats)};
}

TEST(Race, NeedsFewRepeatsToDropOne) {
  // As the manual says.
  EXPECT_EQ(plan::LeastRaceRepeats(2), 6u);
  EXPECT_EQ(plan::LeastRaceRepeats(3), 7u);
  EXPECT_EQ(plan::LeastRaceRepeats(6), 8u);
  EXPECT_EQ(plan::LeastRaceRepeats(20), 11u);
  const plan::RaceBounds bounds(6, 100);
  for (std::uint64_t n = 1; n <= 100; ++n) {
    const std::uint64_t least = bounds.LeastSlower(n);
    EXPECT_GE(least, bounds.LeastSlower(n - 1));
    if (least > n) continue;
    EXPECT_GE(plan::RaceEvidence(least, n - least), 5 / plan::kRaceError);
    EXPECT_LT(plan::RaceEvidence(least - 1, n - least + 1), 5 / plan::kRaceError);
  }
  EXPECT_TRUE(std::isfinite(plan::RaceEvidence(900, 900)));
}

/// The fortune of a gambler does not grow, whatever the strategy: its mean over all outcomes of
/// fair coins is that from before.
TEST(Race, HasEvidenceThatDoesNotGrowByChance) {
  for (std::uint64_t slower = 0; slower < 12; ++slower)
    for (std::uint64_t faster = 0; faster < 12; ++faster)
      EXPECT_NEAR(
          (plan::RaceEvidence(slower + 1, faster) + plan::RaceEvidence(slower, faster + 1)) / 2 /
              plan::RaceEvidence(slower, faster),
          1, 1e-12);
}

/// Runs a race round by round, as `cdb run` does.
Race RunInRounds(const Times& all, std::size_t& rounds) {
  Times known(all.size(), std::vector<double>(all[0].size(), kNotRun));
  for (rounds = 0;; ++rounds) {
    Race race = RunWith(known);
    if (race.HasEnded()) return race;
    for (const auto& [racer, repeat] : race.next) {
      EXPECT_TRUE(std::isnan(known[racer][repeat])) << "a repeat is run once";
      known[racer][repeat] = all[racer][repeat];
    }
  }
}

void ExpectSame(const Race& a, const Race& b) {
  EXPECT_EQ(a.leader, b.leader);
  ASSERT_EQ(a.standings.size(), b.standings.size());
  for (std::size_t i = 0; i < a.standings.size(); ++i) {
    EXPECT_EQ(a.standings[i].outcome, b.standings[i].outcome);
    EXPECT_EQ(a.standings[i].repeats, b.standings[i].repeats);
    EXPECT_EQ(a.standings[i].against, b.standings[i].against);
    EXPECT_EQ(fmt::format("{}", a.standings[i].ratio), fmt::format("{}", b.standings[i].ratio));
  }
}

/// However many repeats there are already, it decides by those that it would have run.
TEST(Race, DecidesTheSameWhereverItWasStopped) {
  for (const double gap : {0.0, 0.02, 0.1})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Times all = MakeTimes({"", Noise::kNormal, 5, gap}, 40, seed);
      std::size_t rounds = 0;
      const Race in_rounds = RunInRounds(all, rounds);
      ExpectSame(in_rounds, RunWith(all));
      EXPECT_LE(rounds, 22u);
      // Of a round that was interrupted, the rest is asked for.
      Times part(all.size(), std::vector<double>(all[0].size(), kNotRun));
      part[0][0] = all[0][0];
      EXPECT_EQ(RunWith(part).next.size(), 4u);
    }
}

TEST(Race, IsWonByTheFastest) {
  Times times(3);
  for (int r = 0; r < 20; ++r) {
    times[0].push_back(200 + r);
    times[1].push_back(100 + r);
    times[2].push_back(300 + r);
  }
  const Race race = RunWith(times);
  EXPECT_EQ(race.leader, 1u);
  EXPECT_EQ(race.standings[1].outcome, Outcome::kWon);
  EXPECT_EQ(race.standings[1].ratio, 1);
  for (const std::size_t i : {0, 2}) {
    const Standing& of = race.standings[i];
    EXPECT_EQ(of.outcome, Outcome::kDropped);
    EXPECT_EQ(of.repeats, plan::LeastRaceRepeats(3));
    EXPECT_EQ(of.against, 1u);
    EXPECT_LE(of.bounds.low, of.ratio);
    EXPECT_GE(of.bounds.high, of.ratio);
    EXPECT_GT(of.bounds.low, 1) << "it is surely slower";
  }
  EXPECT_DOUBLE_EQ(race.standings[0].ratio, 203.0 / 103) << "the middle one of seven";
}

TEST(Race, DropsThoseThatFail) {
  const Times times = {{kFailedRun, kNotRun, kNotRun, kNotRun, kNotRun, kNotRun},
                       {2, 2, 2, 2, 2, 2},
                       {1, 1, 1, 1, 1, 1}};
  const Race race = RunRace(times, plan::RaceBounds(3, 6), 0.01);
  EXPECT_EQ(race.standings[0].outcome, Outcome::kFailed);
  EXPECT_EQ(race.standings[0].repeats, 1u);
  EXPECT_TRUE(race.HasEnded());
  EXPECT_EQ(race.standings[1].outcome, Outcome::kOpen) << "six repeats are too few for three";
  const Race alone = RunWith({{kFailedRun, kNotRun}, {3, kNotRun}});
  EXPECT_EQ(alone.standings[1].outcome, Outcome::kWon);
  EXPECT_EQ(alone.standings[1].repeats, 1u);
  const Race nobody = RunWith({{kFailedRun}, {kFailedRun}});
  EXPECT_TRUE(nobody.HasEnded());
  EXPECT_EQ(nobody.standings[1].outcome, Outcome::kFailed);
}

TEST(Race, EndsWhenAllThatAreLeftAreTied) {
  Times times(3);
  for (int r = 0; r < 60; ++r) {
    times[0].push_back(r % 2 == 0 ? 1 : 1.004);
    times[1].push_back(1.002);
    times[2].push_back(1.5);
  }
  const Race race = RunWith(times);
  EXPECT_EQ(race.standings[0].outcome, Outcome::kTied);
  EXPECT_EQ(race.standings[1].outcome, Outcome::kTied);
  EXPECT_EQ(race.standings[2].outcome, Outcome::kDropped);
  EXPECT_LT(race.standings[0].repeats, 60u);
  EXPECT_EQ(RunWith(times, 1e-6).standings[0].outcome, Outcome::kOpen);
}

/// One is slower than the next in two of three repeats, and the last one than the first.
TEST(Race, IsNotLeftByAllOfACircle) {
  Times times(3);
  for (int r = 0; r < 300; ++r)
    for (int i = 0; i < 3; ++i) times[static_cast<std::size_t>(i)].push_back(1 + (r + i) % 3);
  const Race race = RunWith(times);
  EXPECT_NE(race.standings[race.leader].outcome, Outcome::kDropped);
}

/// The figures of `cdb doc races`.
TEST(Race, DropsTheFastestAsSeldomAsPromised) {
  constexpr std::uint64_t kRepeats = 60, kRaces = 2000;
  // Three standard errors of a rate of 5 %.
  const double most = plan::kRaceError + 3 * std::sqrt(plan::kRaceError / kRaces);
  for (const Model& model : {
           Model{"normal", Noise::kNormal, 2, 0},
           Model{"normal", Noise::kNormal, 6, 0},
           Model{"normal", Noise::kNormal, 6, 0.01},
           Model{"normal", Noise::kNormal, 6, 0.05},
           Model{"normal", Noise::kNormal, 6, 0.2},
           Model{"heavy tails", Noise::kHeavyTails, 6, 0},
           Model{"heavy tails", Noise::kHeavyTails, 6, 0.05},
           Model{"common drift", Noise::kDrift, 6, 0},
           Model{"common drift", Noise::kDrift, 6, 0.05},
           Model{"spikes", Noise::kSpikes, 6, 0},
           Model{"spikes", Noise::kSpikes, 6, 0.05},
           Model{"spikes of the fastest", Noise::kSpikesOfFastest, 6, 0.05},
           Model{"stalls of the fastest", Noise::kStallsOfFastest, 6, 0.05},
           Model{"drifts of their own", Noise::kPersistent, 6, 0, false},
           Model{"drifts of their own", Noise::kPersistent, 6, 0.05, false},
       }) {
    const Rates rates = Simulate(model, kRepeats, kRaces);
    fmt::print("{:22} {:2} racers, {:3.0f} %: dropped {:5.2f} %, won {:5.1f} %, runs {:5.1f} %\n",
               model.name, model.racers, 100 * model.gap, 100 * rates.dropped, 100 * rates.won,
               100 * rates.runs);
    if (model.is_promised) {
      EXPECT_LE(rates.dropped, most) << model.name << model.gap;
    } else {
      EXPECT_GT(rates.dropped, most) << "the manual says that this noise is not covered";
    }
  }
}

}  // namespace
}  // namespace cdb::races
