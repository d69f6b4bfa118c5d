// The samples of runs with soft bodies, and the errors that they show.
#include "runtime/engine/soft/soft_sampler.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/reference.h"
#include "tests/runtime/engine/soft/soft_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

protocol::Samples SamplesOf(const plan::Run& run, const protocol::Recording& recording) {
  return {*protocol::SampleShapeOf(run.scene), run.scene.world.Real("accuracy.interval"),
          recording.SampleValues()};
}

std::string Hanging(double hz, const std::string& statements) {
  return fmt::format(
      "timestep 1/{0}; cycles {0}/2; world {{ side 100; walls none }} accuracy {{ metrics "
      "position, "
      "energy; interval 0.1; reference {{ timestep 1/1920; iterations 300; precision {2} }} }} {1}",
      hz, statements, world::EnginePrecision());
}

constexpr const char* kSprings =
    "soft_world springs; objects { quantity 1; size 2; mass 1; margin 0.01; location at(0, 0, 0); "
    "orientation (0, 0, 1.4); type rope(segments: 8); soft { pin right; stiffness 500; damping 0.1 "
    "} }";

TEST(SoftSampler, SamplesAreTheNodes) {
  const plan::Run run = SoftRun(
      "timestep 0.01; cycles 40; world { side 100; walls none } accuracy { metrics position, "
      "energy, "
      "momentum; interval 0.1 } soft_world springs; objects a { quantity 2; size 2; mass 3; margin "
      "0.01; type rope(segments: 3); location line(gap: 1); linear_velocity (1, 2, 0); soft { pin "
      "left; stiffness 50 } } objects b { quantity 1; size 1; mass 2; margin 0.01; location at(0, "
      "10, 0); type cloth(columns: 2, rows: 2) }");
  const protocol::Recording recording = RecordSoft(run);
  const protocol::Samples samples = SamplesOf(run, recording);
  ASSERT_EQ(samples.shape.objects, 2u * 4 + 9);
  ASSERT_EQ(samples.shape.samples, 5u);
  soft::SoftWorld world = MakeSoftWorld(run);
  for (std::size_t sample = 0; sample < 5; ++sample) {
    if (sample > 0)
      for (int step = 0; step < 10; ++step) world.Step();
    std::size_t index = 0;
    double mass = 0, energy = 0;
    Vector3d momentum = Vector3d::Zero();
    for (std::size_t body = 0; body < world.bodies().size(); ++body) {
      const soft::SoftObject& one = world.bodies()[body];
      for (std::size_t i = 0; i < one.masses.size(); ++i, ++index) {
        const Vector3d x = NodeAt(world, static_cast<int>(i), body),
                       v = NodeVelocity(world, static_cast<int>(i), body);
        EXPECT_EQ(Vector3d(samples.position(sample, index)), x);
        EXPECT_EQ(Vector3d(samples.velocity(sample, index)), v);
        EXPECT_EQ(samples.mass(index), one.masses[i]);
        EXPECT_NEAR(samples.size(index), body < 2 ? 2 : 1, 0.03) << "with its margins";
        mass += one.masses[i];
        momentum += one.masses[i] * v;
        energy += one.masses[i] * (v.squaredNorm() / 2 - world.acceleration().dot(x));
      }
      for (std::size_t i = 0; i < one.mesh.links.size(); ++i) {
        const auto& [a, b] = one.mesh.links[i];
        const double length =
            (NodeAt(world, static_cast<int>(a), body) - NodeAt(world, static_cast<int>(b), body))
                .norm();
        energy += one.stiffness / 2 * std::pow(length - one.rest[i], 2);
      }
    }
    EXPECT_NEAR(samples.energy(sample), energy, 1e-9 * std::abs(energy));
    EXPECT_LT((samples.momentum(sample) - momentum).norm(), 1e-9 * momentum.norm());
    EXPECT_GT(mass, 0);
  }
  EXPECT_EQ(recording.header().cycles_done.load(), 40u);
}

TEST(SoftSampler, RigidBodiesThatMoveFollowTheNodes) {
  const plan::Run run = SoftRun(
      "timestep 0.01; cycles 20; world { side 100; walls none } accuracy { metrics position, "
      "momentum, angular_momentum; interval 0.1 } objects box { quantity 1; type cuboid; size 0.5; "
      "mass 3; location at(0, 9, 0); linear_velocity (1, 0, 0); angular_velocity (0, 2, 0) } "
      "objects stays { quantity 1; size 1; mass fixed; location at(0, -9, 0) } objects rope { "
      "quantity 1; "
      "size 2; mass 1; margin 0.01; type rope(segments: 2); location at(0, 0, 0) }");
  const protocol::Recording recording = RecordSoft(run);
  const protocol::Samples samples = SamplesOf(run, recording);
  ASSERT_EQ(samples.shape.objects, 3u + 1);
  EXPECT_EQ(samples.mass(3), 3);
  EXPECT_NEAR(samples.size(3), 0.5, 1e-6);
  EXPECT_NEAR(samples.position(2, 3).x(), 0.2, 1e-5);
  EXPECT_NEAR(samples.momentum(2).x(), 3, 1e-4);
  EXPECT_NEAR(samples.orientation(2, 3).angularDistance(samples.orientation(0, 3)), 0.4, 1e-4);
  // The common centre of mass is at rest along z; the box turns about y.
  EXPECT_NEAR(samples.angular_momentum(2).y(), 3 * 0.25 / 6 * 2, 1e-3);
}

/// Both of Bullet's worlds are of first order in the time step, against a finer run.
TEST(SoftSampler, ErrorsFallWithTheTimeStep) {
  const char* positions =
      "solver.iterations 300; objects { quantity 1; size 2; mass 1; margin 0.01; location at(0, 0, "
      "0); orientation (0, 0, 0.3); type rope(segments: 8); soft { pin right } }";
  for (const char* statements : {kSprings, positions}) {
    // In single precision, the motion of a short step is lost in the rounding of positions.
    if (statements == positions && std::string_view(world::EnginePrecision()) == "single") continue;
    std::vector<double> errors;
    for (const double hz : {120, 480}) {
      const compiler::Compilation made =
          CompileText("benchmark b { " + Hanging(hz, statements) + "; precision " +
                      world::EnginePrecision() + " }");
      ASSERT_FALSE(made.diagnostics.has_errors()) << dsl::Render(made.diagnostics);
      const plan::Plan& plan = made.plans.at(0);
      const plan::Run &run = plan.runs.at(0), &reference = plan.references.at(0);
      ASSERT_EQ(reference.scene.role, plan::Role::kReference);
      const protocol::Recording of_run = RecordSoft(run), of_reference = RecordSoft(reference);
      EXPECT_FALSE(of_reference.Reals("stretch").empty()) << "it has a verdict";
      const protocol::Samples ran = SamplesOf(run, of_run),
                              truth = SamplesOf(reference, of_reference);
      ASSERT_EQ(ran.shape, truth.shape);
      double sum = 0;
      const std::size_t last = ran.shape.samples - 1;
      for (std::size_t i = 0; i < ran.shape.objects; ++i)
        sum += (ran.position(last, i) - truth.position(last, i)).squaredNorm();
      errors.push_back(std::sqrt(sum / static_cast<double>(ran.shape.objects)));
    }
    const double order = std::log(errors[0] / errors[1]) / std::log(4);
    EXPECT_GT(errors[1], 1e-5) << statements;
    EXPECT_GT(order, 0.6) << errors[0] << " " << errors[1] << statements;
    EXPECT_LT(order, 1.4) << errors[0] << " " << errors[1] << statements;
  }
}

TEST(SoftSampler, TheTwinStartsElsewhereAndEndsNearby) {
  const compiler::Compilation made = CompileText("benchmark b { " + Hanging(120, kSprings) +
                                                 "; precision " + world::EnginePrecision() + " }");
  const plan::Plan& plan = made.plans.at(0);
  const plan::Run &reference = plan.references.at(0), &twin = plan.references.at(1);
  const protocol::Recording a = RecordSoft(reference), b = RecordSoft(twin);
  const protocol::Samples first = SamplesOf(reference, a), second = SamplesOf(twin, b);
  ASSERT_EQ(first.shape, second.shape);
  const std::size_t last = first.shape.samples - 1, node = 0;
  const double apart = (first.position(last, node) - second.position(last, node)).norm();
  EXPECT_GT(apart, 0);
  EXPECT_LT(apart, 0.01);
}

}  // namespace
}  // namespace cdb::tests
