// Pieces of which at least one is a hull or has a curved surface, and boxes with capsules.
#include <algorithm>

#include "library/detectors/narrow/kernels.h"

namespace cdb::narrow {

bool AreApartAlong(const Placed& a, const Placed& b, const Hint& hint, double reach) {
  const Vec3 local = hint.Axis();
  const double square = SquaredNorm(local);
  if (square == 0) return false;
  const Vec3 axis = AxesOf(a.pose) * local;
  const double gap = Dot(axis, a.pose.position - b.pose.position) - Extent(a.piece, -local) -
                     Extent(b.piece, Inverse(AxesOf(b.pose), axis));
  return gap > 0 && gap * gap > reach * reach * square * (1 + 1e-6);  // a float is no unit vector
}

void TurnIntoWorld(const Pose& pose_a, Manifold& manifold) {
  const Rotation axes = AxesOf(pose_a);
  for (Point& point : manifold.points()) {
    point.on_b = axes * point.on_b;
    point.normal = axes * point.normal;
  }
}

namespace {

Separation Search(const Couple& couple, double reach, Hint& hint) {
  Vec3 axis = couple.a.centre - couple.ToA(couple.b.centre);
  if (SquaredNorm(axis) == 0) axis = {0, 1, 0};
  Memory memory;
  const Separation separation = Separate(couple, axis, reach, &memory);
  if (memory.features.kind == Features::Kind::kNone) {
    hint.memory = nullptr;
  } else if (hint.memory == nullptr) {
    hint.memory = std::make_unique<Memory>(memory);
  } else {
    *hint.memory = memory;
  }
  return separation;
}

}  // namespace

void Polytopes(const Placed& a, const Placed& b, Hint& hint, Manifold& manifold) {
  const double reach = kNear + a.piece.radius + b.piece.radius;
  if (hint.memory == nullptr && AreApartAlong(a, b, hint, reach)) return;
  const Couple couple(a.piece, a.pose, b.piece, b.pose);
  Recalled found;
  if (hint.memory != nullptr) found = Recall(couple, *hint.memory, hint.Axis(), reach);
  if (!found.is_proven) found = {Search(couple, reach, hint), true, true};
  hint.Set(found.separation.normal);
  if (found.separation.gap > reach) {
    hint.memory = nullptr;
    return;
  }
  if (!AddFacingPoints(couple, found.separation, manifold)) {
    if (!found.has_points) found.separation = Search(couple, reach, hint);
    AddNearest(couple, found.separation, manifold);
  }
  manifold.Reduce(1e-3 * std::min(a.piece.bound, b.piece.bound));
  TurnIntoWorld(a.pose, manifold);
}

}  // namespace cdb::narrow
