// Takes the samples of a run with soft bodies, in the pass without a clock: the state of each node,
// then of each rigid body that contacts move.
#pragma once

#include <cstdint>
#include <span>

#include "compiler/plan/plan.h"
#include "runtime/engine/soft/soft_world.h"
#include "runtime/protocol/recording.h"

namespace cdb::soft {

/// Requires that the scene asks for samples. World and recording must outlive it. Contacts and
/// pairs are not sampled: their observables are NaN. Not thread-safe.
class SoftSampler {
 public:
  SoftSampler(const plan::Scene& scene, const SoftWorld& world, protocol::Recording& recording);

  /// Call before the first step, then after each one.
  void Begin() { Take(); }
  void AfterStep();

 private:
  void Take();
  void TakeMotion();

  const SoftWorld& world_;
  const protocol::SampleShape shape_;
  const std::span<double> values_;
  const std::uint64_t cycles_per_sample_;
  std::uint64_t steps_ = 0;
  std::size_t taken_ = 0;
};

}  // namespace cdb::soft
