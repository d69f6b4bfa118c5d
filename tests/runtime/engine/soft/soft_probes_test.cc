// The series of runs with soft bodies.
#include "runtime/engine/soft/soft_probes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <tuple>

#include "compiler/lints/lints.h"
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
      "memory, vertices, counters; soft_world springs; objects { quantity 2; size 1; mass 1; "
      "margin 0.02; type cloth(columns: 4, rows: 3) } objects rope { quantity 1; size 1; mass 1; "
      "margin 0.02; type rope(segments: 5) } objects block { quantity 1; size 1; mass 1; "
      "margin 0.02; type block(columns: 1, rows: 1, layers: 2); soft { young_modulus 100 } }");
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
        ASSERT_TRUE(std::isfinite(value) || series.may_be_none) << series.name;
    }
  }
  EXPECT_GE(recorded, 15u);
  EXPECT_EQ(recording.Reals("vertex_positions").size(), 30u * (2 * 20 + 6 + 12) * 3);
}

TEST(SoftProbes, RopesHaveNoCrossings) {
  const plan::Run run = SoftRun(kHanging + std::string("soft { pin right } } cycles 5"));
  const protocol::Recording recording = RecordSoft(run);
  for (const std::int32_t count : recording.Ints("self_crossings")) EXPECT_EQ(count, -1);
  for (const std::int32_t count : recording.Ints("inverted_tetrahedra")) EXPECT_EQ(count, -1);
  for (const double ratio : recording.Reals("volume_ratio")) EXPECT_TRUE(std::isnan(ratio));
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

/// rad/s, of small motions about the start: the square root of the largest eigenvalue.
double HighestFrequencyOf(const soft::SoftWorld& world) {
  const soft::SoftObject& one = world.bodies()[0];
  const auto n = static_cast<Eigen::Index>(one.masses.size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (const auto& [a, b] : one.mesh.links) {
    const Eigen::Vector3d along =
        (NodeAt(world, static_cast<int>(b)) - NodeAt(world, static_cast<int>(a))).normalized();
    const Eigen::Matrix3d block = one.stiffness * along * along.transpose();
    for (const auto& [i, j, sign] : {std::tuple{a, a, 1}, {b, b, 1}, {a, b, -1}, {b, a, -1}})
      stiffness.block<3, 3>(3 * i, 3 * j) += sign * block;
  }
  return HighestFrequency(one.masses, std::move(stiffness));
}

/// Random ropes and cloths, from a third of the limit to three times it: those beyond it explode,
/// whatever the integrator's energy says, and only those; the lint knows it before.
TEST(SoftVerdict, ExplosionsAreSeenAndForeseen) {
  std::mt19937 random(7);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  int exploded = 0, sound = 0;
  for (int i = 0; i < 40; ++i) {
    const bool is_cloth = i % 2 == 1;
    const int columns = 1 + static_cast<int>(draw(0, 8)), rows = 1 + static_cast<int>(draw(0, 4));
    const std::string type = is_cloth ? fmt::format("cloth(columns: {}, rows: {})", columns, rows)
                                      : fmt::format("rope(segments: {})", columns);
    const double timestep = 1 / draw(60, 600), mass = std::pow(10, draw(-1, 1));
    const auto run_with = [&](double stiffness) {
      return SoftRun(fmt::format(
          "soft_world springs; timestep {}; cycles 200; world {{ side 100; walls none }} objects "
          "{{ "
          "quantity 1; size 2; mass {}; margin 0.01; type {}; location at(0, 0, 0); orientation "
          "(0.3, 0.2, 1); linear_velocity (1, 0.3, 0.2); soft {{ pin {}; stiffness {} }} }}",
          timestep, mass, type, is_cloth ? "corners" : "left", stiffness));
    };
    const double unit = HighestFrequencyOf(MakeSoftWorld(run_with(1)));
    if (unit == 0) continue;  // pinned at all corners
    const double factor = std::pow(3, draw(-1, 1));
    if (std::abs(factor - 1) < 0.1) continue;
    const plan::Run run = run_with(std::pow(2 * factor / (timestep * unit), 2));
    const protocol::Judgement judgement = JudgementOf(run);
    const bool is_bad = judgement.verdict >= protocol::Verdict::kExploded;
    EXPECT_EQ(is_bad, factor > 1) << i << " " << type << " " << factor;
    (is_bad ? exploded : sound) += 1;
    const auto numbers = lints::LintScene(run.scene);
    const bool is_foreseen =
        std::ranges::any_of(numbers, [](const lints::LintNumber& n) { return n.IsBad(); });
    EXPECT_EQ(is_foreseen, factor > 1) << i << " " << type << " " << factor;
    if (is_foreseen) {
      EXPECT_NEAR(numbers[0].value / (2 * factor), 1, 0.02) << type;
    }
  }
  EXPECT_GT(exploded, 10);
  EXPECT_GT(sound, 10);
}

/// Nothing moves, and what rounding does is no motion.
TEST(SoftVerdict, RoundingIsNoExplosion) {
  for (const char* type : {"rope(segments: 10)", "cloth(columns: 3, rows: 8)"}) {
    const plan::Run run = SoftRun(
        "soft_world springs; timestep 1/960; cycles 300; acceleration 0; world { side 100; walls "
        "none } objects { quantity 1; size 5; mass 1; margin 0.01; location at(0, 0, 0); "
        "orientation "
        "(0.3, 0.2, 1.4); soft { stiffness 5000 } type " +
        std::string(type) + " }");
    EXPECT_EQ(JudgementOf(run).verdict, protocol::Verdict::kStable) << type;
  }
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
