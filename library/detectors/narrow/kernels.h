// The kernels of the narrow phase: a function for each two kinds of pieces.
#pragma once

#include <cstdint>
#include <memory>

#include "library/detectors/narrow/manifold.h"
#include "library/detectors/narrow/memory.h"

namespace cdb::narrow {

/// What a kernel keeps of a pair of pieces from one cycle to the next: an axis along which they
/// were apart, or the features that touched. It saves time, and hardly ever changes a contact
/// (batch.h).
struct Hint {
  /// Of two boxes, its number in box_axes.h; -1: none.
  std::int32_t box_axis = -1;
  float axis[3] = {0, 0, 0};       ///< otherwise, in the frame of a, from b to a; zero: none
  std::unique_ptr<Memory> memory;  ///< of pieces that are near or overlap; null: none

  Vec3 Axis() const { return {axis[0], axis[1], axis[2]}; }
  void Set(const Vec3& of) {
    axis[0] = static_cast<float>(of.x);
    axis[1] = static_cast<float>(of.y);
    axis[2] = static_cast<float>(of.z);
  }
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
/// Any two pieces, neither a plane: GJK and an expanding polytope.
Kernel Polytopes;

/// Whether cores are farther apart than `reach` along the axis of the hint, if it has one.
bool AreApartAlong(const Placed& a, const Placed& b, const Hint& hint, double reach);

/// From the frame of a into world axes.
void TurnIntoWorld(const Pose& pose_a, Manifold& manifold);

}  // namespace cdb::narrow
