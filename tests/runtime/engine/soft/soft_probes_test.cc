// The series of runs with soft bodies.
#include "runtime/engine/soft/soft_probes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/soft/soft_fixture.h"

namespace cdb::tests {
namespace {

protocol::Judgement JudgementOf(const plan::Run& run) {
  const protocol::Recording recording = RecordSoft(run);
  return protocol::Judge(run.scene, recording, run.scene.world.Count("cycles"));
}

constexpr const char* kHanging =
    "world { side 100; walls none } objects { quantity 1; size 2; mass 2; margin 0.01; location "
    "at(0, 0, 0); orientation (0, 0, 1.5707963267948966); type rope(segments: 20); ";

TEST(SoftProbes, EverySeriesHasAValueInEveryCycle) {
  plan::Run run = SoftRun(
      "cycles 30; world { side 4; wall_shape box } record timing, counts, energy, stability, "
      "memory, vertices; objects { quantity 2; size 1; mass 1; margin 0.02; type cloth(columns: "
      "4, rows: 3) } objects rope { quantity 1; size 1; mass 1; margin 0.02; type rope(segments: "
      "5) }");
  const protocol::Recording recording = RecordSoft(run);
  std::size_t recorded = 0;
  for (const protocol::Series& series : protocol::AllSeries()) {
    ASSERT_EQ(protocol::IsRecordedBy(series, run.scene), series.on_soft != schema::OnSoft::kNo)
        << series.name;
    if (!protocol::IsRecordedBy(series, run.scene)) continue;
    ++recorded;
    if (series.type == protocol::SeriesType::kInt32) {
      for (const std::int32_t value : recording.Values<std::int32_t>(series))
        ASSERT_GE(value, 0) << series.name;
    } else {
      for (const double value : recording.Values<double>(series))
        ASSERT_TRUE(std::isfinite(value)) << series.name;
    }
  }
  EXPECT_GE(recorded, 15u);
  EXPECT_EQ(recording.Reals("vertex_positions").size(), 30u * (2 * 20 + 6) * 3);
}

TEST(SoftProbes, RopesHaveNoCrossings) {
  const plan::Run run = SoftRun(kHanging + std::string("soft { pin right } } cycles 5"));
  const protocol::Recording recording = RecordSoft(run);
  for (const std::int32_t count : recording.Ints("self_crossings")) EXPECT_EQ(count, -1);
}

TEST(SoftProbes, VerticesAreTheNodes) {
  const plan::Run run = SoftRun(
      "cycles 20; record vertices; world { side 100; walls none } objects "
      "{ quantity 1; size 2; mass 2; margin 0.01; type rope(segments: 3) "
      "}");
  const protocol::Recording recording = RecordSoft(run);
  soft::SoftWorld world = MakeSoftWorld(run);
  for (int i = 0; i < 20; ++i) world.Step();
  for (int node = 0; node < 4; ++node)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(
          recording.Reals("vertex_positions")[static_cast<std::size_t>((19 * 4 + node) * 3 + axis)],
          NodeAt(world, node)[axis]);
}

TEST(SoftProbes, EnergyIsKeptBySprings) {
  // Stretched at first by its weight, and without damping.
  const plan::Run run = SoftRun(
      kHanging +
      std::string("soft { pin right; stiffness 4000 } } soft_world springs; timestep 0.0005; "
                  "cycles 4000; record energy"));
  const protocol::Recording recording = RecordSoft(run);
  const auto energy = recording.Reals("energy"), kinetic = recording.Reals("kinetic_energy");
  const double swing = *std::ranges::max_element(kinetic);
  EXPECT_GT(swing, 0.05);
  const auto [low, high] = std::ranges::minmax(energy);
  EXPECT_LT(high - low, 0.1 * swing);
}

TEST(SoftProbes, PhasesAreStampedByThemselves) {
  for (const char* kind : {"positions", "springs"}) {
    const plan::Run run = SoftRun(
        "cycles 50; timestep 1/2000; world { side 4; walls floor; wall_shape box } soft_world " +
        std::string(kind) +
        "; objects { quantity 1; size 1; mass 1; margin 0.02; type cloth(columns: 10, rows: 10); "
        "location at(0, -1.95, 0) }");
    const protocol::Recording recording = RecordSoft(run);
    const auto at = [&](protocol::Phase phase, std::size_t cycle) {
      return recording.Reals("duration")[protocol::IndexOf(phase) * 50 + cycle];
    };
    using enum protocol::Phase;
    for (std::size_t cycle = 0; cycle < 50; ++cycle) {
      for (const protocol::Phase phase : {kBroad, kNarrow, kSolve, kIntegrate})
        EXPECT_GT(at(phase, cycle), 0) << kind;
      EXPECT_EQ(at(kDetect, cycle), at(kBroad, cycle) + at(kNarrow, cycle));
      EXPECT_GE(at(kStep, cycle), at(kDetect, cycle) + at(kSolve, cycle) + at(kIntegrate, cycle));
    }
  }
}

// w timestep must stay below 2, w the highest angular frequency of a chain, 2 sqrt(k / m).
TEST(SoftVerdict, SpringsExplodeBeyondTheirLimit) {
  // m = 0.1 kg of each node: w timestep = 2 at k = 0.1 / timestep^2 = 1000 N/m.
  const auto verdict = [](const char* stiffness) {
    return JudgementOf(SoftRun(kHanging + std::string("soft { pin right; stiffness ") + stiffness +
                               " } } soft_world springs; timestep 0.01; cycles 400"))
        .verdict;
  };
  EXPECT_EQ(verdict("900"), protocol::Verdict::kStable);
  EXPECT_GE(verdict("1200"), protocol::Verdict::kExploded);
}

TEST(SoftVerdict, StretchedBeyondItsLimitDrifts) {
  const auto judged = [](const char* iterations) {
    return JudgementOf(SoftRun(kHanging +
                               std::string("soft { pin right } } cycles 300; "
                                           "solver.iterations ") +
                               iterations));
  };
  EXPECT_EQ(judged("1").verdict, protocol::Verdict::kDrifting);
  EXPECT_EQ(judged("1").criterion, "stretch");
  EXPECT_EQ(judged("100").verdict, protocol::Verdict::kStable);
}

TEST(SoftVerdict, NodesInsideAFixedBodyPenetrate) {
  // The pinned end is at the centre of a ball.
  const plan::Run run = SoftRun(
      "cycles 30; world { side 100; walls none } objects ball { quantity 1; type sphere; size 0.3; "
      "mass fixed; location at(-1, 0, 0); overlap on } objects rope { quantity 1; size 2; mass 2; "
      "margin 0.01; type rope(segments: 4); location at(0, 0, 0); overlap on; soft { pin left } }");
  const protocol::Recording recording = RecordSoft(run);
  for (const std::int32_t count : recording.Ints("inside")) EXPECT_EQ(count, 1);
  for (const double depth : recording.Reals("max_penetration"))
    EXPECT_NEAR(depth, 0.15 + 0.01, 1e-6);
  const protocol::Judgement judgement = protocol::Judge(run.scene, recording, 30);
  EXPECT_EQ(judgement.verdict, protocol::Verdict::kPenetrating);
  EXPECT_EQ(judgement.criterion, "inside");
}

}  // namespace
}  // namespace cdb::tests
