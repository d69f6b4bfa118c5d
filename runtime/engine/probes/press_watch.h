// Finds pairs of objects that a load crushes: contacts that began shallow and were pressed deep,
// and an upper object that ends below the lower one that bore it.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// Depths are those of the contacts; a centre of mass inside the other solid counts as deep, with
/// or without a contact. Pairs are those of the broad phase, so that the work is linear in what it
/// lists. Pairs that overlap in the first cycle are left out, as are soft contacts. The engine must
/// outlive it. Not for several threads.
class PressWatch {
 public:
  /// `least_sides`: by body, infinite for walls; must outlive it.
  PressWatch(world::Engine& engine, std::span<const double> least_sides, bool is_driven);

  struct Seen {
    /// Pairs of objects, or of a wall and an object that touches another, that have been deeper in
    /// each other than a quarter of the smaller one's least side for six cycles, after at least
    /// three less deep ones: their contact does not hold. Where an impact went as deep at once, a
    /// contact has half a second to push them apart.
    std::int32_t pressed = 0;
    /// Pairs of which the object that lay on the other in the first cycles is now below its centre,
    /// and less far aside than the inner radius of the larger. Not of driven scenes.
    std::int32_t inverted = 0;
  };

  /// Call after each cycle.
  Seen After();

 private:
  using Bodies = std::pair<std::uint32_t, std::uint32_t>;  ///< by user index, the smaller first
  struct Pair {
    Bodies bodies;
    double depth = 0;         ///< over the smaller one's least side
    int cycles = 0;           ///< that it has been shallow or deep without a break
    int deep = 0;             ///< cycles that it has been deep without a break
    bool by_impact = false;   ///< was deep before a contact could do anything
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
  const std::span<const double> least_sides_;
  const bool is_driven_;
  const int patience_;  ///< cycles for which an impact may be deep
  int cycle_ = 0;
  std::vector<double> inner_, outer_;  ///< m: radii, by object
  std::vector<Pair> pairs_, last_;     ///< overlapping, sorted by their bodies; the cycle before
  std::vector<char> loaded_;           ///< by object: touches another
  std::map<Bodies, Load> loads_;
};

}  // namespace cdb::probes
