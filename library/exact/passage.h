// Whether two moving solids went through each other: what a simulation in steps may do unseen. In
// double, without any physics engine.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "library/objects/solid.h"

namespace cdb::exact {

/// A solid over a cycle, in which it moves and turns at a constant rate.
struct Motion {
  objects::Pose from;
  Eigen::Vector3d way = Eigen::Vector3d::Zero();   ///< m, of the centre of mass
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< rad, about world axes; any number of turns

  /// `part`: 0 at the start of the cycle, 1 at its end.
  objects::Pose At(double part) const;
};

/// False if balls around two solids, or a plane between them, show that they do not touch in the
/// cycle. Neither may be a surface. Threads: any.
bool MayMeet(const objects::Solid& a, const Motion& motion_a, const objects::Solid& b,
             const Motion& motion_b);

/// What is known of two solids in a cycle.
enum class Passing {
  kNone,
  kPassed,   ///< a pass ended in it
  kUnknown,  ///< neither a pass nor none: too far, too many poses, or beyond rounding
};

/// How two solids separate: seen from the axes of each.
struct Heading {
  struct Seen {
    Eigen::Vector3d normal;  ///< unit, from b to a
    Eigen::Vector3d offset;  ///< m: of the centre of mass of a from that of b
  };
  Seen from_a, from_b;
};

/// Follows two solids from cycle to cycle. Neither may be a surface.
///
/// An overlap begins where the solids touch, and ends where they are apart again; in a cycle of
/// slow motion, already where its depth, the length of the shortest translation that separates
/// them, is less than a tenth of the lesser of their least sides, as that of a contact at rest.
/// They have passed through each other if an overlap was deeper than a quarter of that side and
/// ended on the other side: the direction in which they separate, seen from the axes of both, is
/// more than a right angle away from the direction at the beginning. At the touch, it has no jumps,
/// as the direction of the shortest translation has. If they bounce, or slip off an edge, it is
/// not. Within one cycle, an overlap as deep as the whole side is a pass wherever it ends: no
/// contact can have acted on it. Motion is slow if they move by less than the side relative to each
/// other: no overlap begins then, as the cycle ends before their middles meet, and contacts push
/// them back.
///
/// All fractions are of the thinner solid, because solids that go through each other overlap at
/// least that deeply unless they only graze; so the criterion has no scale, and is the same for
/// both solids. Depths are known to a twentieth of the side, and computed only at poses that no
/// bound on the motion since the last one excludes; directions, at their poses, as depths to a
/// ten-thousandth of it. Cost: at most 1000 poses a cycle, each with at most 500 support points for
/// a pair of pieces. Threads: one. Source: conservative advancement, B. Mirtich, Impulse-based
/// Dynamic Simulation, 1996; least_height.h.
class Passage {
 public:
  /// Of relative motion in a cycle, in least sides: below it, no overlap begins.
  static constexpr double kLeastMotion = 1;

  /// The next cycle.
  Passing Follow(const objects::Solid& a, const Motion& motion_a, const objects::Solid& b,
                 const Motion& motion_b);
  /// True if the last cycle ended in an overlap. If not, it is as one that has just been made.
  bool Overlaps() const { return overlaps_; }

 private:
  bool HasPassed(const Heading& exit, double side, bool is_convex) const;

  double slack_ = 0;  ///< m of relative motion until the overlap can end
  bool overlaps_ = false, spans_cycles_ = false;
  double deepest_ = 0;  ///< m
  Heading entry_;
};

}  // namespace cdb::exact
