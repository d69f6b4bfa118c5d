// The counters of a run, as `record counters` has them.
#include <gtest/gtest.h>

#include <cmath>

#include "runtime/engine/world/clock.h"
#include "runtime/protocol/machine/event_counters.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/new_pages.h"

namespace cdb::tests {
namespace {

constexpr std::uint64_t kCycles = 20;

plan::Scene CountedScene() {
  plan::Scene scene = EngineScene(60, 320);
  SetWorld(scene, "cycles", kCycles);
  SetWorld(scene, "record", schema::WordList{"counters", "counts"});
  return scene;
}

double CountIn(const protocol::Recording& recording, schema::Counter counter, protocol::Phase phase,
               std::uint64_t cycle) {
  return recording.Reals("counters")[(static_cast<std::size_t>(counter) * protocol::kPhaseCount +
                                      protocol::IndexOf(phase)) *
                                         kCycles +
                                     cycle];
}

class PhaseStamps : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { world::CountEvents(); }
};

TEST_F(PhaseStamps, HoldTheEventsBetweenThem) {
  const plan::Scene scene = CountedScene();
  protocol::Recording recording = protocol::Recording::Create(scene);
  NewPages pages;
  for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
    world::PhaseStamps phases = {};
    const world::Stamp begin = world::TakeStamp();
    pages.Touch(cycle + 1);
    const world::Stamp middle = world::TakeStamp();
    pages.Touch(2 * cycle + 2);
    const world::Stamp end = world::TakeStamp();
    phases[protocol::IndexOf(protocol::Phase::kBroad)] = middle - begin;
    phases[protocol::IndexOf(protocol::Phase::kNarrow)] = end - middle;
    phases[protocol::IndexOf(protocol::Phase::kDetect)] = (middle - begin) + (end - middle);
    world::RecordPhases(phases, cycle, recording);
  }
  const bool is_counted = !std::isnan(
      machine::EventCounters().Read()[static_cast<std::size_t>(schema::Counter::kPageFaults)]);
  for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
    const auto faults = [&](protocol::Phase phase) {
      return CountIn(recording, schema::Counter::kPageFaults, phase, cycle);
    };
    EXPECT_TRUE(std::isnan(faults(protocol::Phase::kStep)));  // was not measured
    if (!is_counted) {
      EXPECT_TRUE(std::isnan(faults(protocol::Phase::kBroad)));
      continue;
    }
    const auto touched = static_cast<double>(cycle + 1);
    EXPECT_EQ(faults(protocol::Phase::kBroad), touched);
    EXPECT_EQ(faults(protocol::Phase::kNarrow), 2 * touched);
    EXPECT_EQ(faults(protocol::Phase::kDetect), 3 * touched);
  }
}

TEST_F(PhaseStamps, OfARunAddUpAsItsTimesDo) {
  const Recorded run = RunHere(CountedScene());
  ASSERT_TRUE(run.done()) << run.message();
  EXPECT_TRUE(run.recording.Reals("duration").empty());
  const machine::Counts counted = machine::EventCounters().Read();
  for (std::size_t i = 0; i < counted.size(); ++i)
    for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
      const auto of = [&](protocol::Phase phase) {
        return CountIn(run.recording, static_cast<schema::Counter>(i), phase, cycle);
      };
      if (std::isnan(counted[i])) {
        EXPECT_TRUE(std::isnan(of(protocol::Phase::kStep))) << schema::kCounters[i];
        continue;
      }
      EXPECT_EQ(of(protocol::Phase::kDetect),
                of(protocol::Phase::kBroad) + of(protocol::Phase::kNarrow));
      EXPECT_GE(of(protocol::Phase::kStep), of(protocol::Phase::kDetect) +
                                                of(protocol::Phase::kSolve) +
                                                of(protocol::Phase::kIntegrate));
    }
}

TEST_F(PhaseStamps, DoNotChangeTheMotion) {
  plan::Scene scene = CountedScene();
  const std::string counted = RunHere(scene).hash();
  SetWorld(scene, "record", schema::WordList{"counts"});
  EXPECT_EQ(RunHere(scene).hash(), counted);
}

}  // namespace
}  // namespace cdb::tests
