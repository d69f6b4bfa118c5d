#include "runtime/figures/searches/bisection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <vector>

namespace cdb::tests {
namespace {

using searches::Bracket;
using searches::Outcome;
using searches::Probe;

/// Runs a whole search. `probe`: what a run at a value shows.
Bracket Search(std::size_t values, const std::function<Probe(std::size_t)>& probe) {
  std::vector<Probe> line(values);
  for (;;) {
    const Bracket bracket = searches::Locate(line);
    if (bracket.next.empty()) return bracket;
    for (const std::size_t value : bracket.next) {
      EXPECT_EQ(line.at(value).state, Probe::State::kNotRun) << "a value is run once";
      line[value] = probe(value);
    }
  }
}

Probe Sure(bool holds) { return {holds ? Probe::State::kYes : Probe::State::kNo, true}; }

TEST(Bisection, FindsEveryBoundaryOfEveryShortLine) {
  for (std::size_t values = 2; values <= 70; ++values)
    for (std::size_t first_yes = 1; first_yes < values; ++first_yes) {
      const Bracket found =
          Search(values, [&](std::size_t value) { return Sure(value >= first_yes); });
      EXPECT_EQ(found.outcome, Outcome::kBetween);
      EXPECT_EQ(found.first_yes, first_yes);
      EXPECT_EQ(found.last_no, first_yes - 1);
      EXPECT_EQ(found.sure_no, found.last_no);
      EXPECT_EQ(found.sure_yes, found.first_yes);
      EXPECT_TRUE(found.IsMonotone());
      EXPECT_LE(found.probes, searches::UsualProbes(values));
      EXPECT_LE(found.probes, values);
    }
}

TEST(Bisection, TakesFewRuns) {
  EXPECT_EQ(searches::UsualProbes(257), 11u);
  EXPECT_EQ(Search(257, [](std::size_t value) { return Sure(value >= 200); }).probes, 11u);
}

TEST(Bisection, SaysThatThereIsNoBoundary) {
  for (const std::size_t values : {1, 2, 3, 5, 100}) {
    const Bracket never = Search(values, [](std::size_t) { return Sure(false); });
    EXPECT_EQ(never.outcome, Outcome::kNowhere);
    EXPECT_LE(never.probes, 5u);
    const Bracket always = Search(values, [](std::size_t) { return Sure(true); });
    EXPECT_EQ(always.outcome, Outcome::kAtFirst);
    EXPECT_TRUE(always.IsMonotone());
  }
}

TEST(Bisection, TakesTheFirstOfSeveralBoundariesAndNoticesTheOthers) {
  // It holds in an interval that two of the first five values lie in.
  const Bracket found =
      Search(101, [](std::size_t value) { return Sure(value >= 30 && value < 90); });
  EXPECT_EQ(found.outcome, Outcome::kBetween);
  EXPECT_EQ(found.first_yes, 30u);
  EXPECT_FALSE(found.IsMonotone());
  EXPECT_EQ(found.changes, 2u);
}

/// Values near the boundary do not tell, with an estimate that may be wrong.
TEST(Bisection, NarrowsDownWhatRunsDoNotTell) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 500; ++trial) {
    const auto draw = [&](std::size_t most) {
      return std::uniform_int_distribution<std::size_t>(0, most)(random);
    };
    const std::size_t values = 30 + draw(400), middle = 10 + draw(values - 20), reach = draw(8);
    std::vector<bool> guess;
    for (std::size_t i = 0; i < values; ++i) guess.push_back(draw(1) == 1);
    const Bracket found = Search(values, [&](std::size_t value) {
      const bool is_sure = value + reach < middle || value > middle + reach;
      if (is_sure) return Sure(value > middle);
      return Probe{guess[value] ? Probe::State::kYes : Probe::State::kNo, false};
    });
    ASSERT_TRUE(found.outcome == Outcome::kBetween || found.outcome == Outcome::kUncertain);
    ASSERT_TRUE(found.sure_no && found.sure_yes);
    // What surely lies before and past it is next to the values that do not tell.
    EXPECT_LE(*found.sure_no, middle);
    EXPECT_GE(*found.sure_yes, middle);
    EXPECT_LE(*found.sure_yes - *found.sure_no, 2 * reach + 2);
    EXPECT_LE(found.probes, 3 * searches::UsualProbes(values));
  }
}

TEST(Bisection, EndsWhereNoRunTells) {
  const Bracket found = Search(257, [](std::size_t value) {
    return Probe{value >= 77 ? Probe::State::kYes : Probe::State::kNo, false};
  });
  EXPECT_EQ(found.outcome, Outcome::kUncertain);
  EXPECT_EQ(found.first_yes, 77u);
  EXPECT_FALSE(found.sure_no);
  EXPECT_FALSE(found.sure_yes);
}

/// Whatever was run before, in whatever order, it goes on.
TEST(Bisection, GoesOnFromAnyState) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t values = 2 + random() % 60, first_yes = 1 + random() % (values - 1);
    std::vector<Probe> line(values);
    for (std::size_t value = 0; value < values; ++value)
      if (random() % 3 == 0) line[value] = Sure(value >= first_yes);
    for (Bracket bracket = searches::Locate(line); !bracket.next.empty();
         bracket = searches::Locate(line))
      for (const std::size_t value : bracket.next) line[value] = Sure(value >= first_yes);
    EXPECT_EQ(searches::Locate(line).first_yes, first_yes);
  }
}

}  // namespace
}  // namespace cdb::tests
