// Finds contacts with the ground whose normals its shape does not allow, and the objects that they
// deflect: Bullet computes contacts with one triangle, hull or tile at a time, and finds the edges
// between them, which the ground as a whole does not have.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "library/objects/compound.h"

#include "runtime/engine/probes/body_states.h"

namespace cdb::probes {

/// The ground is all surfaces and fixed objects. Legal normals are those of
/// exact::NearestLegalNormal, from the geometry of the scene. The part
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
  /// A convex piece of a fixed object.
  struct FixedPiece {
    std::size_t object, piece;
  };
  void Check(const btPersistentManifold& manifold, const BodyStates& now, Seen& seen);
  /// The legal normal nearest to that of a contact, both in world axes and out of the ground;
  /// nullopt if it is not known.
  std::optional<Eigen::Vector3d> LegalOnSurface(std::size_t surface, const Eigen::Vector3d& place,
                                                const Eigen::Vector3d& normal, double depth) const;
  /// `margin` (m): Bullet's, by which edges are rounded.
  std::optional<Eigen::Vector3d> LegalOnSolid(std::size_t object, const Eigen::Vector3d& point,
                                              const Eigen::Vector3d& normal, double depth,
                                              double margin) const;
  bool Contains(const FixedPiece& piece, const Eigen::Vector3d& point) const;

  world::Engine& engine_;
  bool has_surfaces_ = false;
  std::vector<FixedPiece> pieces_;
  std::optional<objects::BoxTree> tree_;  ///< of the boxes of pieces_, if there are several
  std::vector<Moving> objects_;           ///< by object
};

}  // namespace cdb::probes
