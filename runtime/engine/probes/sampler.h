// Takes the samples of a run between cycles, in the pass without a clock.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/probes/pair_referee.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/recording.h"

namespace cdb::probes {

/// Requires that the scene asks for samples. Engine and recording must outlive it. Not thread-safe.
class Sampler {
 public:
  Sampler(const plan::Scene& scene, world::Engine& engine, protocol::Recording& recording);

  /// Call before the first step, then before and after each one.
  void Begin();
  void BeforeStep();
  void AfterStep();
  /// True if all samples have been taken.
  bool IsComplete() const { return taken_ == shape_.samples; }

 private:
  void Take();
  void TakeStates();
  void TakeMotion();
  void TakeContacts();
  void TakePairs();
  void TakeGeometry();
  double& Value(protocol::Observable which);
  double SizeOf(const btCollisionObject* body) const;

  world::Engine& engine_;
  const protocol::SampleShape shape_;
  const std::span<double> values_;
  const std::uint64_t cycles_per_sample_;
  const bool wants_pairs_, wants_geometry_;
  std::uint64_t steps_ = 0;
  std::size_t taken_ = 0;
  std::vector<BodyPair> exact_;  ///< pairs whose exact boxes overlapped in the last detection
  ExactContacts overlaps_;       ///< in the last detection
};

}  // namespace cdb::probes
