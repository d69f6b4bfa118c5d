// Where made-up times of cycles become steady.
#include "runtime/figures/steady/steady_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::tests {
namespace {

using steady::State;
using steady::SteadyState;

/// `level(c)`, with normal noise of 2 %.
template <typename Level>
SteadyState OfTimes(std::size_t cycles, std::uint64_t seed, Level level) {
  std::vector<double> times;
  for (std::size_t c = 0; c < cycles; ++c) {
    const auto uniform = [&seed] {
      seed = plan::StreamSeed(seed, "steady");
      return (static_cast<double>(seed >> 12) + 0.5) * 0x1p-52;
    };
    const double radius = std::sqrt(-2 * std::log(uniform()));
    const double noise = radius * std::cos(2 * std::numbers::pi * uniform());
    times.push_back(1000 * level(static_cast<double>(c)) * std::exp(0.02 * noise));
  }
  return steady::FindSteadyState(times);
}

TEST(SteadyState, IsAfterAStep) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const SteadyState of = OfTimes(300, seed, [](double c) { return c < 60 ? 1.5 : 1; });
    ASSERT_EQ(of.state, State::kAfterWarmup) << seed;
    EXPECT_EQ(of.warmup, 60u) << seed;
    EXPECT_NEAR(of.rest, 1000, 10);
    EXPECT_NEAR(of.all, 1100, 10);
  }
}

TEST(SteadyState, IsAfterADecay) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const SteadyState of = OfTimes(600, seed, [](double c) { return 1 + std::exp(-c / 40); });
    ASSERT_EQ(of.state, State::kAfterWarmup) << seed;
    EXPECT_GE(of.warmup, 60u) << seed;
    EXPECT_NEAR(of.rest, 1000, 60) << seed;
  }
}

TEST(SteadyState, IsFromTheStartIfNothingChanges) {
  std::size_t alarms = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
    alarms += OfTimes(200, seed, [](double) { return 1; }).state != State::kFromStart;
  EXPECT_LE(alarms, 3u);
}

TEST(SteadyState, IsNotThereIfTheTimesGrow) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed)
    EXPECT_EQ(OfTimes(300, seed, [](double c) { return 1 + c / 300; }).state, State::kNever);
}

TEST(SteadyState, IsAdvice) {
  const auto text = [](const std::vector<SteadyState>& states) {
    std::vector<steady::PointState> all;
    for (const SteadyState& of : states) all.push_back({nullptr, of});
    return steady::SteadyText(all);
  };
  const SteadyState short_one = {}, from_start = {State::kFromStart, 0, 100, 100},
                    after = {State::kAfterWarmup, 20, 100, 90}, never = {State::kNever, 80, 100};
  EXPECT_EQ(text({short_one}), "");
  EXPECT_EQ(text({from_start, short_one}), "The time of a step is steady from the first cycle on.");
  EXPECT_EQ(
      text({after}),
      "The time of a step is steady after at most 20 cycles: the rest takes 0.900 of the mean "
      "of all. `warmup 20` leaves the transient out.");
  EXPECT_EQ(text({from_start, after, never}),
            "The time of a step is steady after at most 20 cycles in 1 of 3 points: the rest takes "
            "0.900 of the mean of all. `warmup 20` leaves the transient out. The time of a step "
            "still changes in the second half of the cycles in 1 of 3 points: a mean is over the "
            "stages of the scene, and no warm-up makes it steady.");
}

TEST(SteadyState, NeedsCycles) {
  EXPECT_EQ(steady::FindSteadyState(std::vector<double>(20, 1)).state, State::kTooShort);
  EXPECT_EQ(steady::FindSteadyState(std::vector<double>(40, 1)).state, State::kFromStart);
}

}  // namespace
}  // namespace cdb::tests
