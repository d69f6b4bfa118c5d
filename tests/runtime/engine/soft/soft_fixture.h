// Scenes with soft bodies, run in this process.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dsl/diagnostics.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "runtime/engine/soft/soft_probes.h"
#include "runtime/engine/soft/soft_world.h"
#include "runtime/engine/worker/run_soft.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/recording.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {

inline constexpr double kRelativeRounding = std::numeric_limits<btScalar>::epsilon();
inline constexpr bool kIsDouble = sizeof(btScalar) == 8;
/// m/s^2 of the default scene, and kg/m^3 of the bars of tests.
inline constexpr double kPull = 9.8, kDensity = 1000;

/// The first run of a benchmark, in the engine's precision.
inline plan::Run SoftRun(const std::string& statements) {
  const compiler::Compilation result =
      CompileText("benchmark b { " + statements + "; precision " + world::EnginePrecision() + " }");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.at(0).runs.at(0);
}

inline soft::SoftWorld MakeSoftWorld(const plan::Run& run) {
  layouts::InitialState state = layouts::DrawObjects(run.scene);
  layouts::Place(run.scene, state);
  return soft::SoftWorld(run.scene, std::move(state));
}

/// The recording of a run in this process.
inline protocol::Recording RecordSoft(const plan::Run& run) {
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  worker::RunSoft(run, recording);
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kDone)
      << recording.header().message.str();
  return recording;
}

inline Eigen::Vector3d NodeAt(const soft::SoftWorld& world, int node, std::size_t body = 0) {
  return world::ToEigen(world.bodies()[body].body->m_nodes[node].m_x);
}
inline Eigen::Vector3d NodeVelocity(const soft::SoftWorld& world, int node, std::size_t body = 0) {
  return world::ToEigen(world.bodies()[body].body->m_nodes[node].m_v);
}

/// m: the centre of mass of the first body.
inline Eigen::Vector3d CentreOf(const soft::SoftWorld& world) {
  const std::vector<double>& masses = world.bodies()[0].masses;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    sum += masses[i] * NodeAt(world, static_cast<int>(i));
    mass += masses[i];
  }
  return sum / mass;
}

/// kg m^2/s: of the first body about its centre of mass.
inline Eigen::Vector3d AngularMomentumOf(const soft::SoftWorld& world) {
  const Eigen::Vector3d centre = CentreOf(world);
  const std::vector<double>& masses = world.bodies()[0].masses;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const int node = static_cast<int>(i);
    sum += masses[i] * (NodeAt(world, node) - centre).cross(NodeVelocity(world, node));
  }
  return sum;
}

/// rad/s: the square root of the largest eigenvalue of small motions. `masses`: kg, of the nodes, 0
/// of pinned ones; `stiffness`: N/m, 3 rows and columns for each node.
inline double HighestFrequency(const std::vector<double>& masses, Eigen::MatrixXd stiffness) {
  for (std::size_t node = 0; node < masses.size(); ++node) {
    const double scale = masses[node] > 0 ? 1 / std::sqrt(masses[node]) : 0;
    const auto first = static_cast<Eigen::Index>(3 * node);
    stiffness.middleRows<3>(first) *= scale;
    stiffness.middleCols<3>(first) *= scale;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues().maxCoeff());
}

}  // namespace cdb::tests
