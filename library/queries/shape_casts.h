// A solid that is somewhere, or moves without turning, and a body: where they touch, and how far
// they are apart. In double, for every pair of convex pieces. Threads: any.
//
// A sweep is solved by conservative advancement: the gap of convex solids is a convex function of
// the way, so that a step of the gap over its rate of change never goes too far, and converges as
// Newton's method does. Source: B. Mirtich, Impulse-based Dynamic Simulation, 1996.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "library/exact/signed_distance.h"
#include "library/objects/solid.h"

namespace cdb::queries {

/// The place of a solid that is not turned.
struct Placed {
  const objects::Solid& solid;
  Eigen::Vector3d position;  ///< of its centre of mass

  objects::Pose pose() const { return {position, Eigen::Quaterniond::Identity()}; }
};

struct Touch {
  double distance;         ///< m: the way until they touch, or their distance
  Eigen::Vector3d normal;  ///< unit, of the body, outwards; zero if they overlap
};

/// Where the solid first touches the body within `length`; at 0 if it overlaps it there.
std::optional<Touch> SweepTo(const Placed& from, const Eigen::Vector3d& along, double length,
                             const objects::Solid& body, const objects::Pose& pose);
std::optional<Touch> SweepTo(const Placed& from, const Eigen::Vector3d& along, double length,
                             const exact::HalfSpace& body);

/// How far they are apart; 0 if they overlap. Nullopt if that is more than `reach`.
std::optional<Touch> DistanceTo(const Placed& at, double reach, const objects::Solid& body,
                                const objects::Pose& pose);
std::optional<Touch> DistanceTo(const Placed& at, double reach, const exact::HalfSpace& body);

}  // namespace cdb::queries
