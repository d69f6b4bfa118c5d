#include "runtime/protocol/machine/noise.h"

#include <gtest/gtest.h>

#include <vector>

namespace cdb::tests {
namespace {

using machine::Noise;

schema::RunScalars QuietScalars() {
  schema::RunScalars scalars;
  scalars.cycles_wall_ns = 1e9;
  scalars.cycles_cpu_ns = 0.99e9;
  scalars.stolen_ns = 5e6;
  scalars.others_ns = 20e6;
  scalars.processors = 2;
  return scalars;
}

std::vector<double> EvenSteps() { return std::vector<double>(100, 1e6); }

TEST(Noise, IsNotSeenInAQuietRun) {
  const auto judged = machine::JudgeNoise(QuietScalars(), {2, 2}, 1, EvenSteps());
  EXPECT_EQ(judged.noise, Noise::kQuiet);
  EXPECT_EQ(judged.why, "");
  EXPECT_EQ(machine::JudgeNoise(QuietScalars(), {2, 2}, 1, {}).noise, Noise::kQuiet);
}

TEST(Noise, IsUnknownOfARunThatWasNotMeasured) {
  EXPECT_EQ(machine::JudgeNoise({}, {11, 2}, 1, EvenSteps()).noise, Noise::kUnknown);
}

TEST(Noise, IsTimeOffTheProcessor) {
  schema::RunScalars scalars = QuietScalars();
  scalars.cycles_cpu_ns = 0.4e9;
  const auto judged = machine::JudgeNoise(scalars, {1, 2}, 1, EvenSteps());
  EXPECT_EQ(judged.noise, Noise::kNoisy);
  EXPECT_EQ(judged.why, "60 % of the time not on a processor");
  // The measured thread waits for the others.
  EXPECT_EQ(machine::JudgeNoise(scalars, {1, 2}, 2, EvenSteps()).noise, Noise::kQuiet);
}

TEST(Noise, IsStolenTimeAndLoad) {
  schema::RunScalars scalars = QuietScalars();
  scalars.stolen_ns = 0.2e9;
  EXPECT_EQ(machine::JudgeNoise(scalars, {11, 2}, 1, EvenSteps()).why,
            "20 % stolen by other virtual machines, load 11.0 on 2 processors");
}

TEST(Noise, IsOtherProgramsOnOtherProcessors) {
  schema::RunScalars scalars = QuietScalars();
  scalars.others_ns = 0.95e9;
  EXPECT_EQ(machine::JudgeNoise(scalars, {1, 2}, 1, EvenSteps()).why,
            "other programs on 0.95 processors");
  scalars.cycles_wall_ns = scalars.cycles_cpu_ns = 10e6;
  scalars.stolen_ns = 0;
  scalars.others_ns = 30e6;
  EXPECT_EQ(machine::JudgeNoise(scalars, {1, 2}, 1, EvenSteps()).noise, Noise::kQuiet)
      << "three ticks of the system's clock say nothing";
}

TEST(Noise, IsAFewLongPausesAndNotASceneThatChanges) {
  std::vector<double> paused = EvenSteps();
  paused[17] = 3e9;
  EXPECT_EQ(machine::JudgeNoise(QuietScalars(), {1, 2}, 1, paused).why,
            "a few long pauses: the mean step is 31.0 medians");
  std::vector<double> collapses = EvenSteps();
  for (std::size_t i = 80; i < 100; ++i) collapses[i] = 1e8;
  EXPECT_EQ(machine::JudgeNoise(QuietScalars(), {1, 2}, 1, collapses).noise, Noise::kQuiet);
}

TEST(Noise, IsComparedByThePartThatOthersTook) {
  const machine::NoiseJudgement unknown, quiet = {Noise::kQuiet, "", 0.01},
                                         loud = {Noise::kNoisy, "", 0.3},
                                         louder = {Noise::kNoisy, "", 0.6};
  EXPECT_TRUE(quiet.IsQuieterThan(loud));
  EXPECT_TRUE(loud.IsQuieterThan(louder));
  EXPECT_FALSE(louder.IsQuieterThan(loud));
  EXPECT_FALSE(quiet.IsQuieterThan(quiet));
  EXPECT_TRUE(louder.IsQuieterThan(unknown)) << "it was measured at least";
  EXPECT_FALSE(unknown.IsQuieterThan(louder));
  schema::RunScalars scalars = QuietScalars();
  scalars.cycles_cpu_ns = 0.4e9;
  EXPECT_DOUBLE_EQ(machine::JudgeNoise(scalars, {1, 2}, 1, EvenSteps()).disturbed, 0.6);
  EXPECT_DOUBLE_EQ(machine::JudgeNoise(scalars, {1, 2}, 2, EvenSteps()).disturbed, 0.02);
}

}  // namespace
}  // namespace cdb::tests
