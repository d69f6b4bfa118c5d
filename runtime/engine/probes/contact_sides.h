// The least sides by which the depths of contacts are judged.
//
// A compound has that of the piece that is touched, since a thin piece elsewhere makes no contact
// worse. Lengths in m. Threads: any, once made.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "library/objects/solid.h"
#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// The least side of the pieces that contain a point near their surface, in the axes of the body;
/// that of the thinnest piece if none does. Not for the triangles of a surface.
double TouchedSide(const objects::Compound& compound, const Eigen::Vector3d& point);

class ContactSides {
 public:
  /// The engine must outlive it.
  explicit ContactSides(const world::Engine& engine);

  /// By body, of its thinnest piece; infinite for walls.
  std::span<const double> least() const { return least_; }
  /// Of two bodies, by their thinnest pieces: never more than At.
  double Least(std::size_t a, std::size_t b) const { return std::min(least_[a], least_[b]); }
  /// Of the smaller of the two pieces that touch.
  double At(const btPersistentManifold& manifold, const btManifoldPoint& point) const;

 private:
  const world::Engine& engine_;
  std::vector<double> least_;
};

}  // namespace cdb::probes
