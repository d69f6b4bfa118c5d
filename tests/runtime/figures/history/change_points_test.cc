// Steps and drifts of made-up histories: closed forms, rates of false alarms, and what is found.
#include "runtime/figures/history/change_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "library/distributions/stream.h"
#include "runtime/figures/bootstrap.h"

namespace cdb::tests {
namespace {

using history::FindChanges;
using FoundChanges = std::vector<history::Change>;

constexpr std::size_t kCommits = 60;
constexpr double kNoise = 0.02;
constexpr int kHistories = 1000;

/// The logarithms at each commit: `level`, and noise of 2 %.
std::vector<double> MadeUpLogs(distributions::Stream& stream, std::size_t commits,
                               const std::function<double(std::size_t)>& level) {
  std::vector<double> logs;
  for (std::size_t i = 0; i < commits; ++i) logs.push_back(level(i) + kNoise * stream.Normal());
  return logs;
}

double Flat(std::size_t) { return 0; }

/// Student's t with 3 degrees of freedom, whose variance is 3.
double HeavyTailed(distributions::Stream& stream) {
  double squares = 0;
  for (int i = 0; i < 3; ++i) squares += std::pow(stream.Normal(), 2);
  return stream.Normal() / std::sqrt(squares / 3);
}

/// A step of 5 % at `at`.
std::function<double(std::size_t)> StepAt(std::size_t at) {
  return [at](std::size_t i) { return i >= at ? std::log(1.05) : 0; };
}

/// The number of made-up histories for which `holds`.
int CountHistories(std::uint64_t seed, const std::function<double(std::size_t)>& level,
                   const std::function<bool(const FoundChanges&)>& holds, std::size_t series = 1) {
  distributions::Stream stream(seed);
  int count = 0;
  for (int i = 0; i < kHistories; ++i)
    count += holds(FindChanges(MadeUpLogs(stream, kCommits, level), {.series = series})) ? 1 : 0;
  return count;
}

bool HasAny(const FoundChanges& changes) { return !changes.empty(); }

std::function<bool(const FoundChanges&)> IsOneStepNear(std::size_t at) {
  return [at](const FoundChanges& changes) {
    return changes.size() == 1 && !changes[0].is_drift && changes[0].to + 1 >= at &&
           changes[0].to <= at + 1;
  };
}

bool HasDrift(const FoundChanges& changes) {
  return std::ranges::any_of(changes, &history::Change::is_drift);
}

/// Values 1, 2, 3 and 5, 6, 7: both variances are 1, so that t is 4 / sqrt(2 / 3) with 4 degrees of
/// freedom. For these, the tail is 1 / 2 - (3 x - x^3) / 4 with x = t / sqrt(t^2 + 4).
TEST(ChangePoints, SplitsAreTestedByStudentsT) {
  const std::vector<double> before = {1, 2, 3}, after = {5, 6, 7};
  const history::SplitTest test = history::TestSplit(before, after);
  EXPECT_DOUBLE_EQ(test.difference, 4);
  EXPECT_DOUBLE_EQ(test.error, std::sqrt(2.0 / 3));
  EXPECT_DOUBLE_EQ(test.freedom, 4);
  const double t = 4 / std::sqrt(2.0 / 3), x = t / std::sqrt(t * t + 4);
  EXPECT_NEAR(test.p, 2 * (0.5 - (3 * x - x * x * x) / 4), 1e-12);
}

TEST(ChangePoints, UnequalVariancesAreTestedByTheLargerError) {
  const std::vector<double> quiet = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, noisy = {-3, 1, 5};
  const history::SplitTest test = history::TestSplit(quiet, noisy);
  EXPECT_DOUBLE_EQ(test.error, std::sqrt(16.0 / 3));  // Welch's; the pooled one is smaller
  EXPECT_DOUBLE_EQ(test.freedom, 2);
  EXPECT_NEAR(test.p, 2 * figures::StudentTail(1 / std::sqrt(16.0 / 3), 11), 1e-12);
  const std::vector<double> alike = {1, 1, 1}, spread = {0, 2, -2, 3, -3};
  const double pooled = std::sqrt(26.0 / 6 * (1.0 / 3 + 1.0 / 5));
  EXPECT_NEAR(history::TestSplit(spread, alike).p, 2 * figures::StudentTail(1 / pooled, 6), 1e-12);
}

TEST(ChangePoints, EnergySplitsWhereTheLevelChanges) {
  EXPECT_EQ(history::EnergySplit(std::vector<double>{0, 1, 0, 1, 0, 5, 6, 5, 6}), 5u);
  EXPECT_EQ(history::EnergySplit(std::vector<double>{0, 0, 5, 5, 5}), 0u);
}

TEST(ChangePoints, LinesAreFittedByLeastSquares) {
  const history::LineFit fit = history::FitLine(std::vector<double>{1, 3, 2, 6});
  EXPECT_DOUBLE_EQ(fit.slope, 1.4);
  EXPECT_NEAR(fit.level, 0.9, 1e-12);
  EXPECT_NEAR(fit.loss, 4.2, 1e-12);
  EXPECT_NEAR(fit.error, std::sqrt(4.2 / 2 / 5), 1e-12);
}

TEST(ChangePoints, OfExactLevelsAreExact) {
  std::vector<double> logs(20, 0.0);
  for (std::size_t i = 8; i < 20; ++i) logs[i] = i < 14 ? 0.5 : 0.25;
  const FoundChanges changes = FindChanges(logs, {});
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].from, 7u);
  EXPECT_EQ(changes[0].to, 8u);
  EXPECT_DOUBLE_EQ(changes[0].log_ratio, 0.5);
  EXPECT_DOUBLE_EQ(changes[0].low, 0.5);
  EXPECT_EQ(changes[1].to, 14u);
  EXPECT_DOUBLE_EQ(changes[1].log_ratio, -0.25);
  EXPECT_TRUE(FindChanges(logs, {.least_effect = 0.7}).empty());
}

TEST(ChangePoints, AStepBeforeADriftHasItsOwnSize) {
  std::vector<double> logs;
  distributions::Stream stream(3);
  for (std::size_t i = 0; i < 30; ++i)
    logs.push_back((i >= 11 ? 0.05 : 0) +
                   0.004 * static_cast<double>(std::clamp(i, 16ul, 27ul) - 16) +
                   1e-5 * stream.Normal());
  const FoundChanges changes = FindChanges(logs, {});
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_FALSE(changes[0].is_drift);
  EXPECT_EQ(changes[0].to, 11u);
  EXPECT_NEAR(changes[0].log_ratio, 0.05, 1e-4);
  EXPECT_TRUE(changes[1].is_drift);
  EXPECT_EQ(changes[1].from, 16u);
  EXPECT_EQ(changes[1].to, 27u);
  EXPECT_NEAR(changes[1].log_ratio, 0.044, 1e-4);
}

TEST(ChangePoints, AnExactSlopeIsOneDrift) {
  std::vector<double> logs;
  for (int i = 0; i < 40; ++i) logs.push_back(0.01 * std::min(std::max(0, i - 5), 20));
  const FoundChanges changes = FindChanges(logs, {});
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_TRUE(changes[0].is_drift);
  EXPECT_EQ(changes[0].from, 5u);
  EXPECT_EQ(changes[0].to, 25u);
  EXPECT_NEAR(changes[0].log_ratio, 0.2, 1e-9);
}

TEST(ChangePoints, OfNoOrFewValuesAreNone) {
  EXPECT_TRUE(FindChanges({}, {}).empty());
  EXPECT_TRUE(FindChanges(std::vector<double>{1, 1, 9, 9, 9}, {}).empty());
  EXPECT_TRUE(FindChanges(std::vector<double>(30, 1.0), {}).empty());
}

TEST(ChangePoints, OutliersOfOneCommitAreNoChange) {
  for (const std::size_t at : {0u, 3u, 30u, 58u, 59u}) {
    const auto outlier = [at](std::size_t i) { return i == at ? std::log(3.0) : 0; };
    EXPECT_LE(CountHistories(11 + at, outlier, HasAny), 10) << at;
  }
}

TEST(ChangePoints, FalseAlarmsAreRare) {
  EXPECT_LE(CountHistories(1, Flat, HasAny), 5);
  EXPECT_LE(CountHistories(2, Flat, HasAny, 50), 1);
  distributions::Stream stream(3);
  int of_heavy_tails = 0;
  for (int i = 0; i < kHistories; ++i) {
    std::vector<double> logs;
    for (std::size_t k = 0; k < kCommits; ++k)
      logs.push_back(kNoise / std::sqrt(3.0) * HeavyTailed(stream));
    of_heavy_tails += FindChanges(logs, {}).empty() ? 0 : 1;
  }
  EXPECT_LE(of_heavy_tails, 10);
  RecordProperty("of_heavy_tails", of_heavy_tails);
}

TEST(ChangePoints, StepsAreFoundAtTheirCommit) {
  EXPECT_GE(CountHistories(4, StepAt(30), IsOneStepNear(30)), 880);
  EXPECT_GE(CountHistories(5, StepAt(30), IsOneStepNear(30), 50), 880);
  EXPECT_GE(CountHistories(6, StepAt(30), HasAny), 990);
  EXPECT_GE(CountHistories(7, StepAt(52), HasAny), 800);
}

TEST(ChangePoints, IntervalsContainTheSizeOfAStep) {
  const int covered = CountHistories(8, StepAt(30), [](const FoundChanges& changes) {
    return changes.size() == 1 && changes[0].low < std::log(1.05) &&
           std::log(1.05) < changes[0].high;
  });
  EXPECT_GE(covered, 850);
}

TEST(ChangePoints, AChangeAndItsRevertAreTwo) {
  const auto bump = [](std::size_t i) { return i >= 25 && i < 33 ? 0.08 : 0; };
  const int found = CountHistories(9, bump, [](const FoundChanges& changes) {
    return changes.size() == 2 && changes[0].log_ratio > 0 && changes[1].log_ratio < 0;
  });
  EXPECT_GE(found, 900);
}

TEST(ChangePoints, SlopesAreDrifts) {
  const auto slope = [](double rate) {
    return [rate](std::size_t i) { return rate * std::min(std::max(0.0, i - 15.0), 30.0); };
  };
  EXPECT_GE(CountHistories(10, slope(0.004), HasDrift), 850);
  EXPECT_GE(CountHistories(12, slope(0.002), HasDrift), 600);
  EXPECT_GE(CountHistories(13, slope(0.002), HasAny), 990);
}

}  // namespace
}  // namespace cdb::tests
