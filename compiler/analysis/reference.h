// Samples and references of a scene: the runs that serve as ground truth. They follow from the
// scenes alone, so that every process derives the same ones.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/schema/metrics.h"

namespace cdb::analysis {

/// The times at which a run is sampled: at the start, then every `interval_s` of simulated time.
struct Sampling {
  double interval_s = 0;
  std::uint64_t cycles = 0;  ///< from one sample to the next, including warm-up cycles
  std::uint64_t count = 0;   ///< including the sample at the start
  bool operator==(const Sampling&) const = default;
};

/// The reason why the requested errors of a scene cannot be measured; no parameter if they can.
struct AccuracyFault {
  const schema::Parameter* parameter = nullptr;  ///< to be changed: `accuracy.interval`, `cycles`
  std::string message;                           ///< the fault
  std::string help;                              ///< a value that would be accepted
};
AccuracyFault FindAccuracyFault(const plan::Scene& scene);

/// The functions below require a scene without such a fault (CDB_CHECK).

/// Nullopt if the scene requests no errors.
std::optional<Sampling> SamplingOf(const plan::Scene& scene);

/// The number of steps of `timestep_s` that equals `span_s` to a part in 10^9; nullopt if there is
/// none.
std::optional<std::uint64_t> WholeSteps(double span_s, double timestep_s);

/// True if a requested error needs the ground truth, and the scene names no closed form.
bool NeedsReference(const plan::Scene& scene);

/// The scene that provides the ground truth for `scene`: the same start and the same time, with the
/// settings `accuracy.reference`; samples are recorded, and `stability` for its verdict. Scenes
/// that differ only in replaced settings share one reference.
plan::Scene ReferenceOf(const plan::Scene& scene);

/// The reference run with twice its time step, and from a displaced start: every object with mass
/// is moved by kDisplacement of its size. If twice the time step divides neither the interval nor
/// the schedules, it is half. The distance between the two shows how far and how long the reference
/// can be trusted: of a method of first order, it is the error of the reference.
plan::Scene TwinOf(const plan::Scene& reference);
inline constexpr double kDisplacement = 1e-9;

/// Fills `references` of the plan, and enters their ids in its runs.
void AddReferences(plan::Plan& plan);

// The errors that a scene or a plan requests by `accuracy.metrics`.

/// In the order of the table; empty if the scene requests none.
std::vector<const schema::ErrorInfo*> ErrorsOf(const plan::Scene& scene);
/// Those of all runs together.
std::vector<const schema::ErrorInfo*> ErrorsOf(const plan::Plan& plan);

// The number of bodies in a scene, which detectors limit.

/// The objects of all groups, plus the walls in use.
std::uint64_t BodyCount(const plan::Scene& scene);
/// The largest number of bodies of any run.
std::uint64_t MaxBodyCount(const plan::Plan& plan);

/// The largest part of the acceleration that may point aside while a pile settles.
inline constexpr double kMostTiltOfPiles = 0.1;

// Constants of Bullet and of the walls that lints, pruning and the engine rely on.

/// The walls of a cube; pruning and results list them as -x +x -y +y -z +z.
inline constexpr int kWallCount = 6;
/// Thickness of a box wall, as a fraction of the side of the cube.
inline constexpr double kWallThickness = 0.1;

/// Bullet puts a body to sleep after it has been slower than both speeds, m/s and rad/s, for this
/// time, s (btRigidBody::updateDeactivation).
inline constexpr double kSlowSpeed = 0.8, kSlowSpin = 1.0, kSleepAfter = 2.0;

/// Bullet disables a body whose box has at least this diagonal, m
/// (btCollisionWorld::updateSingleAabb).
inline constexpr double kLargestBox = 1e6;

}  // namespace cdb::analysis
