// Scenes with objects at chosen positions, and the engine in this process.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/worker/run_scene.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/engine.h"
#include "tests/support/scene.h"

namespace cdb::tests {

inline constexpr bool kIsSingle = sizeof(btScalar) == 4;
/// Relative spacing of numbers in the engine's precision.
inline constexpr double kEpsilon = std::numeric_limits<btScalar>::epsilon();

/// DefaultScene in the engine's precision.
inline plan::Scene EngineScene(std::uint64_t quantity, double side) {
  plan::Scene scene = DefaultScene(quantity, side);
  SetWorld(scene, "precision", Word(world::EnginePrecision()));
  return scene;
}

/// The scene's only object at `position`; call after the scene is complete.
inline layouts::InitialState OneObjectAt(const plan::Scene& scene,
                                         const Eigen::Vector3d& position) {
  layouts::InitialState state = layouts::DrawObjects(scene);
  state.objects.at(0).pose.position = position;
  return state;
}

using world::ToBullet;
using world::ToEigen;

inline Eigen::Vector3d Position(const world::Engine& engine, std::size_t object = 0) {
  return ToEigen(engine.objects()[object]->getWorldTransform().getOrigin());
}
inline Eigen::Vector3d Velocity(const world::Engine& engine, std::size_t object = 0) {
  return ToEigen(engine.objects()[object]->getLinearVelocity());
}

inline Eigen::Quaterniond Orientation(const world::Engine& engine, std::size_t object = 0) {
  const btQuaternion turn = engine.objects()[object]->getWorldTransform().getRotation();
  return Eigen::Quaterniond(turn.w(), turn.x(), turn.y(), turn.z()).normalized();
}

inline void Steps(world::Engine& engine, int count) {
  for (int i = 0; i < count; ++i) engine.Step();
}

/// The engine with every component, including those that the scene could omit.
inline world::Engine WholeEngine(const plan::Scene& scene, layouts::InitialState state) {
  return world::Engine(scene, std::move(state), omissions::KeepEverything(scene));
}

/// A run of the scene in this process, and its recording.
struct Recorded {
  protocol::Recording recording;
  std::unique_ptr<world::Engine> engine;
  const protocol::RecordingHeader& header() const { return recording.header(); }
  std::string hash() const { return recording.header().state_hash.str(); }
  std::string message() const { return recording.header().message.str(); }
  bool done() const { return header().outcome.load() == protocol::WorkerOutcome::kDone; }
};

inline Recorded RunHere(const plan::Scene& scene, worker::Streams streams = {}) {
  plan::Run run;
  run.scene = scene;
  Recorded recorded{protocol::Recording::Create(scene), nullptr};
  try {
    recorded.engine = worker::RunScene(run, recorded.recording, streams);
  } catch (const world::OmissionGuardTripped& tripped) {
    recorded.recording.Clear();
    recorded.engine = worker::RunScene(run, recorded.recording, streams, {"walls", tripped.what()});
  }
  return recorded;
}

/// Expects the same motion with all of the detectors that this build has.
inline void ExpectAlike(plan::Scene scene, const std::vector<std::string>& detectors) {
  std::string hash;
  for (const std::string& detector : detectors) {
    SetWorld(scene, "detector", Word(detector));
    const Recorded run = RunHere(scene);
    ASSERT_TRUE(run.done()) << run.message();
    if (hash.empty()) hash = run.hash();
    EXPECT_EQ(run.hash(), hash) << detector;
  }
}

}  // namespace cdb::tests
