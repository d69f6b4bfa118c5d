// Finds pairs of objects that a load crushes: contacts that began shallow and were pressed deep,
// and objects that sink below the one they lay on.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "library/objects/solid.h"
#include "runtime/engine/probes/contact_sides.h"
#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// Depths are those of the contacts; a centre of mass inside the other solid counts as deep, with
/// or without a contact. Pairs are those of the broad phase, so the work is linear in their number.
/// Pairs that overlap in the first cycle and soft contacts are left out. The engine must outlive
/// it. Not thread-safe.
class PressWatch {
 public:
  /// `contact_sides` must outlive it.
  PressWatch(world::Engine& engine, const ContactSides& contact_sides, bool is_driven);

  struct Seen {
    /// Pairs of objects, or of a wall and an object that touches another, whose contact does not
    /// hold: they overlap by more than a quarter of their side in ContactSides for six cycles,
    /// after at least three shallower ones. If an impact went that deep at once, the contact has
    /// half a second to separate them.
    std::int32_t pressed = 0;
    /// Pairs in which the object that lay on the other in the first cycles is now below its centre,
    /// and closer to it sideways than the inner radius of the larger. Not for driven scenes.
    std::int32_t inverted = 0;
  };

  /// Call after each cycle.
  Seen After();

 private:
  using Bodies = std::pair<std::uint32_t, std::uint32_t>;  ///< by user index, the smaller first
  struct Pair {
    Bodies bodies;
    double depth = 0;         ///< in sides of ContactSides
    int cycles = 0;           ///< consecutive cycles in which it has been shallow or deep
    int deep = 0;             ///< consecutive cycles in which it has been deep
    bool by_impact = false;   ///< was deep before a contact could act
    bool from_start = false;  ///< overlapped in the first cycle
  };
  /// One object that lay on another.
  struct Load {
    std::uint32_t upper, lower;
  };

  void CollectContacts();
  void CollectCentres();
  void Follow();
  void FindLoads();
  std::int32_t CountInverted() const;
  Eigen::Vector3d PositionOf(std::uint32_t body) const;
  bool IsObject(std::uint32_t body) const { return body < engine_.objects().size(); }
  bool IsSoft(std::uint32_t body) const;

  world::Engine& engine_;
  const ContactSides& contact_sides_;
  const bool is_driven_;
  const int patience_;  ///< cycles for which an impact may stay deep
  int cycle_ = 0;
  std::vector<double> inner_, outer_;  ///< m: radii, by object
  std::vector<Pair> pairs_, last_;     ///< overlapping, sorted by their bodies; the cycle before
  std::vector<char> loaded_;           ///< by object: touches another
  std::map<Bodies, Load> loads_;
};

/// True if the point, in the axes of the body, lies in the solid or on its surface. Threads: any.
bool Contains(const objects::Solid& solid, const Eigen::Vector3d& point);

}  // namespace cdb::probes
