// Finds contacts with surfaces whose normals the triangles do not allow, and the objects that they
// deflect: Bullet computes contacts triangle by triangle, and finds the edges between them.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/probes/body_states.h"

namespace cdb::probes {

/// Legal normals are those of exact::NearestLegalNormal, from the geometry of the scene. The part
/// of an impulse across the nearest legal normal is false. An object is deflected, from then on, if
/// the sum of its false impulses exceeds a twentieth of its largest momentum so far; for an object
/// that hardly moves, of that of a fall by a hundredth of its least side. Not checked: contacts
/// without an impulse in the cycle. The engine must outlive it. Not thread-safe.
class NormalWatch {
 public:
  explicit NormalWatch(world::Engine& engine);

  struct Seen {
    std::int32_t false_normals;  ///< contacts that had an impulse in this cycle
    std::int32_t deflected;      ///< objects so far
    double false_impulse;        ///< kg m/s: sum of the magnitudes in this cycle
  };
  /// Call after each cycle, with the states at its start and end.
  Seen After(const BodyStates& before, const BodyStates& now);

 private:
  struct Moving {
    double mass;              ///< kg
    double speed;             ///< m/s: the largest so far
    Eigen::Vector3d impulse;  ///< kg m/s: the false ones so far
    bool is_deflected;
  };
  void Check(const btPersistentManifold& manifold, const BodyStates& now, Seen& seen);

  world::Engine& engine_;
  bool has_surfaces_ = false;
  std::vector<Moving> objects_;  ///< by object
};

}  // namespace cdb::probes
