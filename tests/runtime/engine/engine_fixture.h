// Scenes with objects put where a test wants them.
#pragma once

#include <cmath>
#include <limits>
#include <string>

#include "library/layouts/initial_state.h"
#include "runtime/engine/conversions.h"
#include "runtime/engine/engine.h"
#include "runtime/engine/precision.h"
#include "runtime/engine/run_scene.h"
#include "tests/library/test_scene.h"

namespace cdb::test {

/// Relative distance of neighbouring numbers in the engine's precision.
inline constexpr double kEpsilon = std::numeric_limits<btScalar>::epsilon();

/// DefaultScene in the engine's precision.
inline compiler::Scene EngineScene(std::uint64_t quantity, double side) {
  compiler::Scene scene = DefaultScene(quantity, side);
  SetWorld(scene, "precision", Word(runtime::EnginePrecision()));
  return scene;
}

/// The scene's only object at `position`; call after the scene is complete.
inline library::InitialState OneObjectAt(const compiler::Scene& scene,
                                         const Eigen::Vector3d& position) {
  library::InitialState state = library::DrawObjects(scene);
  state.objects.at(0).pose.position = position;
  return state;
}

using runtime::ToBullet;
using runtime::ToEigen;

inline Eigen::Vector3d Position(const runtime::Engine& engine, std::size_t object = 0) {
  return ToEigen(engine.objects()[object]->getWorldTransform().getOrigin());
}
inline Eigen::Vector3d Velocity(const runtime::Engine& engine, std::size_t object = 0) {
  return ToEigen(engine.objects()[object]->getLinearVelocity());
}

inline Eigen::Quaterniond Orientation(const runtime::Engine& engine, std::size_t object = 0) {
  const btQuaternion turn = engine.objects()[object]->getWorldTransform().getRotation();
  return Eigen::Quaterniond(turn.w(), turn.x(), turn.y(), turn.z()).normalized();
}

inline void Steps(runtime::Engine& engine, int count) {
  for (int i = 0; i < count; ++i) engine.Step();
}

/// With everything in it, whatever the scene could do without.
inline runtime::Engine WholeEngine(const compiler::Scene& scene, library::InitialState state) {
  return runtime::Engine(scene, std::move(state), runtime::KeepEverything(scene));
}

/// A run of the scene in this process, and what it recorded.
struct Recorded {
  runtime::Recording recording;
  std::unique_ptr<runtime::Engine> engine;
  const runtime::RecordingHeader& header() const { return recording.header(); }
  std::string hash() const { return recording.header().state_hash; }
  std::string message() const { return recording.header().message; }
  bool done() const { return header().outcome.load() == runtime::WorkerOutcome::kDone; }
};

inline Recorded RunHere(const compiler::Scene& scene, int contacts_fd = -1) {
  compiler::Run run;
  run.scene = scene;
  Recorded recorded{runtime::Recording::Create(scene), nullptr};
  try {
    recorded.engine = runtime::RunScene(run, recorded.recording, contacts_fd);
  } catch (const runtime::Tripped& tripped) {
    recorded.recording.Clear();
    recorded.engine = runtime::RunScene(run, recorded.recording, contacts_fd, tripped.what());
  }
  return recorded;
}

}  // namespace cdb::test
