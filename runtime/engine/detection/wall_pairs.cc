#include "runtime/engine/detection/wall_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace cdb::detection {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Of the coordinates that Bullet computes a distance from.
constexpr double kRounding = 16 * static_cast<double>(std::numeric_limits<btScalar>::epsilon());

/// How far before a plane a contact can be, beyond the box of its object; m.
double ReachBefore(const btRigidBody& plane, Bodies objects) {
  const auto around = static_cast<double>(gContactBreakingThreshold);
  double reach = 0, largest = 0;
  for (const auto& object : objects) {
    const btCollisionShape& shape = *object->getCollisionShape();
    const auto breaking =
        static_cast<double>(shape.getContactBreakingThreshold(gContactBreakingThreshold));
    reach = std::max(reach, breaking - around);
    largest = std::max(largest, static_cast<double>(shape.getAngularMotionDisc()));
  }
  const double far = static_cast<double>(plane.getWorldTransform().getOrigin().length());
  return reach + kRounding * (far + largest);
}

}  // namespace

std::string WhyAllWallPairs(const plan::Scene& scene, Bodies objects) {
  if (scene.world.WordOr("pair_order") != "sorted")
    return "with pair_order listed, contacts are solved in an order that depends on all pairs; use "
           "pair_order sorted";
  for (const auto& object : objects) {
    if (object->getCollisionShape()->isCompound())
      return fmt::format(
          "object {} has several convex pieces, whose contacts are solved in an order that depends "
          "on all pairs",
          object->getUserIndex() + 1);
    if (object->getCcdMotionThreshold() > 0)
      return fmt::format("object {} has ccd, which looks for planes along its path",
                         object->getUserIndex() + 1);
  }
  return "";
}

void HalfSpaceShape::SetBox(const Box& box) {
  // Bullet has no infinity: this is the side of its planes' boxes. Around every box it adds the
  // threshold, which is taken off before, rounded outwards.
  const auto side = [](double x, btScalar outwards) {
    constexpr auto kFar = static_cast<double>(BT_LARGE_FLOAT);
    if (std::fabs(x) >= kFar) return std::copysign(BT_LARGE_FLOAT, static_cast<btScalar>(x));
    const auto inner =
        static_cast<btScalar>(x) - std::copysign(gContactBreakingThreshold, outwards);
    return std::nextafter(inner, outwards);
  };
  const btScalar down = -BT_LARGE_FLOAT, up = BT_LARGE_FLOAT;
  lower_ = {side(box.lower.x, down), side(box.lower.y, down), side(box.lower.z, down)};
  upper_ = {side(box.upper.x, up), side(box.upper.y, up), side(box.upper.z, up)};
}

void HalfSpaceShape::getAabb(const btTransform& /*pose*/, btVector3& lower,
                             btVector3& upper) const {
  lower = lower_;
  upper = upper_;
}

Box HalfSpaceBox(const btRigidBody& plane, Bodies objects) {
  Box box = {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
  const auto& shape = static_cast<const btStaticPlaneShape&>(*plane.getCollisionShape());
  const btTransform& pose = plane.getWorldTransform();
  const btVector3 normal = pose.getBasis() * shape.getPlaneNormal();
  const btVector3 point = pose(shape.getPlaneNormal() * shape.getPlaneConstant());
  const double reach = ReachBefore(plane, objects);
  double* lower = &box.lower.x;
  double* upper = &box.upper.x;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::fabs(normal[axis]) != 1 || normal.length2() != 1) continue;
    const auto end = static_cast<btScalar>(static_cast<double>(point[axis]) +
                                           static_cast<double>(normal[axis]) * reach);
    const double side = static_cast<double>(std::nextafter(end, normal[axis] * BT_LARGE_FLOAT));
    (normal[axis] > 0 ? upper : lower)[axis] = side;
  }
  return box;
}

}  // namespace cdb::detection
