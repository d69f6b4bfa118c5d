// Records the series of a scene between cycles. Nothing here runs inside a timed cycle, and only
// the requested series are computed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/engine/probes/motion_watch.h"
#include "runtime/engine/probes/soundness.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/recording.h"

namespace cdb::probes {

/// Engine and recording must outlive it. Not thread-safe.
class Probes {
 public:
  /// `contacts_fd` receives the ContactRecords of `record contacts`; otherwise it is not used.
  Probes(const plan::Scene& scene, world::Engine& engine, protocol::Recording& recording,
         int contacts_fd);

  /// Call once before the first recorded cycle: displacements are relative to the positions then.
  void Begin();
  /// Call after each recorded cycle. Throws std::system_error if a contact cannot be written.
  void Record(std::uint64_t cycle);

 private:
  void RecordManifolds(std::uint64_t cycle);
  void RecordStability(std::uint64_t cycle);
  void RecordEnergy(std::uint64_t cycle);
  void SetScales();
  void RecordPoses(std::uint64_t cycle);
  void RecordBoxes(std::uint64_t cycle);
  void RecordFilters();
  std::size_t PlaceOfWall(const btRigidBody& wall) const;
  void RecordMotion(std::uint64_t cycle);
  void RecordSoundness(std::uint64_t cycle);
  bool IsBeyondWall(const btVector3& centre) const;
  bool IsTooLarge(const btRigidBody& body) const;
  double SmallerSide(int a, int b) const;

  world::Engine& engine_;
  protocol::Recording& recording_;
  protocol::RecordingHeader& header_;
  const std::uint64_t cycles_;
  const bool is_driven_, streams_contacts_, all_walls_, floor_;
  const int contacts_fd_;
  const unsigned standing_walls_;
  std::optional<MotionWatch> motion_watch_;  ///< for `record stability`, as is the next member
  std::optional<Soundness> soundness_;
  std::vector<char> touches_;        ///< by body, including walls: has a contact in this cycle
  std::vector<double> least_sides_;  ///< by body; infinite for walls
  std::vector<protocol::ContactRecord> contact_records_;
};

}  // namespace cdb::probes
