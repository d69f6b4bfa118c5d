// The test of changes between two files, on made-up runs with known noise.
#include "runtime/figures/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "library/distributions/stream.h"
#include "runtime/figures/times.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using figures::Bootstrap;
using figures::Change;
using figures::ChangeTest;
using figures::ChangeVerdict;
using figures::Estimate;
using figures::TestedChange;

TEST(CompareStatistics, TestsByStudentsDistribution) {
  // Two samples whose means have the bootstrap variance that Welch's test assumes.
  const Bootstrap five(5);
  const Estimate a = five.MeanEstimate({99, 101, 100, 98, 102}),
                 b = five.MeanEstimate({109, 111, 110, 108, 112});
  const TestedChange tested = ChangeTest(five, five).Of(figures::ChangeOf(a, b));
  EXPECT_NEAR(tested.ratio, 1.1, 1e-12);
  // The standard deviation of both is sqrt(2.5), the error of the difference 1, nu about 8.
  const double error = std::sqrt(0.5 / 1e4 + 0.5 / 1.21e4);
  EXPECT_NEAR(tested.interval.low, 1.1 * std::exp(-2.308 * error), 1e-3);
  EXPECT_NEAR(tested.interval.high, 1.1 * std::exp(2.308 * error), 1e-3);
  // P(t > (log 1.1 - log 1.01) / error) + P(t > (log 1.1 + log 1.01) / error), integrated.
  EXPECT_NEAR(tested.p, 1.258e-5, 1e-8);
}

TEST(CompareStatistics, CallsAChangeOfOnePercentNone) {
  const Bootstrap five(5);
  const Estimate a = five.MeanEstimate({100, 100.01, 99.99, 100, 100});
  const auto p = [&](double factor) {
    return ChangeTest(five, five).Of(figures::ChangeOf(a, figures::Scaled(a, factor))).p;
  };
  EXPECT_GT(p(1.0099), 0.5);
  EXPECT_LT(p(1.011), 1e-6);
  EXPECT_LT(p(1 / 1.011), 1e-6);
}

TEST(CompareStatistics, JudgesACountByItsNoise) {
  const Bootstrap one(1);
  const auto tested = [&](double factor) {
    return ChangeTest(one, one, 0.001)
        .Of(figures::ChangeOf(one.MeanEstimate({1e6}), one.MeanEstimate({1e6 * factor})));
  };
  EXPECT_TRUE(ChangeTest(one, one, 0.001).HasIntervals());
  EXPECT_EQ(figures::JudgeChange(tested(1.0009), 1, 0.05), ChangeVerdict::kSame);
  EXPECT_EQ(tested(1.0009).p, 1);
  EXPECT_EQ(tested(1.0011).p, 0);
  EXPECT_EQ(tested(1 / 1.0011).p, 0);
  EXPECT_NEAR(tested(1.01).interval.low, 1.01 / 1.001, 1e-12);
  EXPECT_NEAR(tested(1.01).interval.high, 1.01 * 1.001, 1e-12);
  EXPECT_FALSE(tested(NAN).IsTested());
}

TEST(CompareStatistics, DoesNotPairTheRepeatsOfTwoFiles) {
  // The third repeat is slow in both files, but at different times: a coincidence.
  const Bootstrap five(5);
  const Estimate a = five.MeanEstimate({100, 110, 200, 120, 100});
  const TestedChange tested = ChangeTest(five, five).Of(figures::ChangeOf(a, a));
  EXPECT_LT(tested.interval.low, 0.8);
  EXPECT_GT(tested.interval.high, 1.25);
}

TEST(CompareStatistics, HasNoIntervalOfFewRepeatsOrIncompleteOnes) {
  const Bootstrap four(4), five(5);
  const Estimate few = four.MeanEstimate({1, 2, 3, 4}), enough = five.MeanEstimate({1, 2, 3, 4, 5});
  EXPECT_FALSE(ChangeTest(four, five).HasIntervals());
  EXPECT_FALSE(ChangeTest(four, five).Of(figures::ChangeOf(few, enough)).IsTested());
  Estimate incomplete = enough;
  incomplete.things = 4;
  EXPECT_FALSE(ChangeTest(five, five).Of(figures::ChangeOf(incomplete, enough)).IsTested());
  EXPECT_EQ(figures::JudgeChange({}, NAN, 1), ChangeVerdict::kCannotTell);
}

TEST(CompareStatistics, JudgesByTestAndMargin) {
  const TestedChange slower = {1.05, {1.03, 1.07}, 0.001}, faster = {0.9, {0.8, 0.95}, 0.001},
                     wide = {1.01, {0.9, 1.12}, 0.9}, narrow = {1.01, {0.99, 1.03}, 0.9};
  EXPECT_EQ(figures::JudgeChange(slower, 0.01, 0.05), ChangeVerdict::kSlower);
  EXPECT_EQ(figures::JudgeChange(faster, 0.05, 0.05), ChangeVerdict::kFaster);
  EXPECT_EQ(figures::JudgeChange(slower, 0.06, 0.05), ChangeVerdict::kCannotTell);
  EXPECT_EQ(figures::JudgeChange(wide, 1, 0.05), ChangeVerdict::kCannotTell);
  EXPECT_EQ(figures::JudgeChange(narrow, 1, 0.05), ChangeVerdict::kSame);
  EXPECT_NEAR(narrow.Bound(), 0.03, 1e-12);
}

TEST(CompareStatistics, CorrectsForManyTests) {
  // The same values as R's p.adjust.
  const std::vector<double> p = {0.01, 0.04, NAN, 0.03, 0.005};
  const std::vector<double> holm = {0.03, 0.06, NAN, 0.06, 0.02},
                            bh = {0.02, 0.04, NAN, 0.04, 0.02};
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (std::isnan(p[i])) {
      EXPECT_TRUE(std::isnan(figures::HolmAdjusted(p)[i]));
      EXPECT_TRUE(std::isnan(figures::BenjaminiHochbergAdjusted(p)[i]));
      continue;
    }
    EXPECT_NEAR(figures::HolmAdjusted(p)[i], holm[i], 1e-12) << i;
    EXPECT_NEAR(figures::BenjaminiHochbergAdjusted(p)[i], bh[i], 1e-12) << i;
  }
}

/// Made-up noise. Relative standard deviations of a whole repeat, of a run in it, and of a cycle.
struct MadeUpNoise {
  double repeat = 0.005, run = 0.015, cycle = 0.03;
  double stalls = 0.01;    ///< fraction of cycles that take five times as long
  double slow_runs = 0;    ///< fraction of runs that another process slows down as a whole
  double slowed_by = 1.3;  ///< the largest factor; each is slowed by a part of it
};

/// A file of `groups` x `points`, timed `repeats` times.
class MadeUpFile {
 public:
  MadeUpFile(distributions::Stream& stream, std::size_t repeats, const MadeUpNoise& noise)
      : stream_(stream), noise_(noise), bootstrap_(repeats) {
    for (std::size_t r = 0; r < repeats; ++r) repeat_.push_back(Factor(noise.repeat));
  }
  const Bootstrap& bootstrap() const { return bootstrap_; }

  Estimate Point(double ns) {
    constexpr std::size_t kCount = 12;
    std::vector<std::vector<double>> repeats;
    for (const double of_repeat : repeat_) {
      const double slow =
          stream_.Uniform() < noise_.slow_runs ? std::pow(noise_.slowed_by, stream_.Uniform()) : 1;
      const double of_run = of_repeat * slow * Factor(noise_.run);
      std::vector<double>& cycles = repeats.emplace_back();
      for (std::size_t c = 0; c < kCount; ++c) {
        const double stall = stream_.Uniform() < noise_.stalls ? 5 : 1;
        cycles.push_back(ns * (1 + 0.05 * static_cast<double>(c)) * of_run * Factor(noise_.cycle) *
                         stall);
      }
    }
    return figures::TimesOver(repeats, bootstrap_, figures::CycleStatistic::kMean,
                              figures::FastestOf(repeat_.size()))
        .mean;
  }

 private:
  double Factor(double sigma) { return std::exp(sigma * stream_.Normal()); }

  distributions::Stream& stream_;
  const MadeUpNoise noise_;
  const Bootstrap bootstrap_;
  std::vector<double> repeat_;
};

constexpr std::size_t kGroups = 4, kPointsEach = 3;

/// Changes between two files, the second of which is slower by `factor` in group 0.
struct Experiment {
  std::vector<double> groups, points;  ///< adjusted p: by Holm, by Benjamini and Hochberg
  std::size_t covered = 0;             ///< groups whose interval contains the true change
};
Experiment CompareOnce(distributions::Stream& stream, std::size_t repeats, const MadeUpNoise& noise,
                       double factor) {
  MadeUpFile a(stream, repeats, noise), b(stream, repeats, noise);
  const ChangeTest test(a.bootstrap(), b.bootstrap());
  Experiment made;
  for (std::size_t g = 0; g < kGroups; ++g) {
    const double truth = g == 0 ? factor : 1;
    std::vector<Change> changes;
    for (std::size_t i = 0; i < kPointsEach; ++i) {
      const double ns = 1000 * static_cast<double>(i + 1);
      changes.push_back(figures::ChangeOf(a.Point(ns), b.Point(ns * truth)));
      made.points.push_back(test.Of(changes.back()).p);
    }
    const TestedChange tested = test.Of(figures::GeometricMeanOf(changes));
    made.groups.push_back(tested.p);
    made.covered += tested.interval.low <= truth && truth <= tested.interval.high ? 1 : 0;
  }
  made.groups = figures::HolmAdjusted(made.groups);
  made.points = figures::BenjaminiHochbergAdjusted(made.points);
  return made;
}

struct Rates {
  double false_alarms = 0;       ///< fraction of experiments with a false alarm in some group
  double false_discoveries = 0;  ///< mean fraction of reported points that did not change
  double power = 0;              ///< fraction of experiments that find group 0
  double coverage = 0;           ///< of the intervals of groups
};
Rates RatesOf(std::size_t repeats, const MadeUpNoise& noise, double factor, int all) {
  const int experiments = Cases(all);
  distributions::Stream stream(7 + repeats);
  const auto found = [](double p) { return p <= figures::kSignificance; };
  Rates rates;
  for (int i = 0; i < experiments; ++i) {
    const Experiment made = CompareOnce(stream, repeats, noise, factor);
    bool is_false = false;
    double true_points = 0, false_points = 0;
    for (std::size_t g = 0; g < kGroups; ++g) {
      const bool is_planted = g == 0 && factor != 1;
      if (is_planted) rates.power += found(made.groups[g]) ? 1 : 0;
      if (!is_planted) is_false = is_false || found(made.groups[g]);
      for (std::size_t k = 0; k < kPointsEach; ++k)
        (is_planted ? true_points : false_points) +=
            found(made.points[g * kPointsEach + k]) ? 1 : 0;
    }
    rates.false_alarms += is_false ? 1 : 0;
    if (false_points > 0) rates.false_discoveries += false_points / (true_points + false_points);
    rates.coverage += static_cast<double>(made.covered) / kGroups;
  }
  for (double* rate :
       {&rates.false_alarms, &rates.false_discoveries, &rates.power, &rates.coverage})
    *rate /= experiments;
  return rates;
}

// Fixed seeds: the rates are always the same.
TEST(CompareStatistics, FindsWhatIsPlantedAndNothingElse) {
  if (kAddressSanitizer) GTEST_SKIP() << "a tenth of the experiments is too few for these rates";
  for (const std::size_t repeats : {5, 9}) {
    const Rates null = RatesOf(repeats, {}, 1, 100), planted = RatesOf(repeats, {}, 1.05, 100);
    EXPECT_LE(null.false_alarms, 0.05) << repeats;
    EXPECT_LE(null.false_discoveries, 0.05) << repeats;
    EXPECT_LE(planted.false_alarms, 0.05) << repeats;
    EXPECT_LE(planted.false_discoveries, 0.05) << repeats;
    EXPECT_GE(planted.coverage, 0.95) << repeats;
    EXPECT_GE(planted.power, repeats == 9 ? 0.9 : 0.6) << repeats;
  }
}

TEST(CompareStatistics, FindsWhatIsPlantedAmongSlowRuns) {
  const MadeUpNoise shared = {.repeat = 0.002, .run = 0.01, .slow_runs = 0.4};
  const Rates null = RatesOf(45, shared, 1, 40), planted = RatesOf(45, shared, 1.05, 40);
  EXPECT_LE(null.false_alarms, 0.05);
  EXPECT_LE(planted.false_alarms, 0.05);
  EXPECT_GE(null.coverage, 0.9);
  EXPECT_GE(planted.power, 0.9);
}

TEST(CompareStatistics, RaisesNoFalseAlarmOnABusyMachine) {
  const MadeUpNoise busy = {.repeat = 0.02, .run = 0.04, .cycle = 0.05, .stalls = 0.05};
  const Rates null = RatesOf(6, busy, 1, 100), planted = RatesOf(6, busy, 1.3, 50);
  EXPECT_LE(null.false_alarms, 0.05);
  EXPECT_GE(null.coverage, 0.95);
  EXPECT_GE(planted.power, 0.6);
}

}  // namespace
}  // namespace cdb::tests
