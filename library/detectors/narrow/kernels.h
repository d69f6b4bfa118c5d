// The kernels of the narrow phase: a function for each two kinds of pieces.
#pragma once

#include <cstdint>

#include "library/detectors/narrow/manifold.h"

namespace cdb::narrow {

/// What a kernel keeps of a pair of pieces from one cycle to the next: an axis along which they
/// were apart. It saves time and changes no result.
struct Hint {
  float axis[3] = {0, 0, 0};    ///< in the frame of a, from b to a; zero: none
  std::int32_t box_axis = -1;  ///< of two boxes: its number in box_box.cc; -1: none
};

/// A piece and the pose of its body.
struct Placed {
  const Piece& piece;
  const Pose& pose;
};

/// Adds the points of two pieces that are at most kNear apart. Points are in world axes, relative
/// to the position of a's body.
using Kernel = void(const Placed& a, const Placed& b, Hint& hint, Manifold& manifold);

/// Closed forms. The kind of a is that of the name's first part.
Kernel BallBall, BallCapsule, CapsuleCapsule, BallBox, AnyPlane;
/// Boxes: 15 separating axes (Gottschalk, Lin & Manocha 1996).
Kernel BoxBox;
/// Boxes, hulls, and balls and capsules with either: GJK and an expanding polytope.
Kernel Polytopes;

/// From the frame of a into world axes.
void TurnIntoWorld(const Pose& pose_a, Manifold& manifold);

}  // namespace cdb::narrow
