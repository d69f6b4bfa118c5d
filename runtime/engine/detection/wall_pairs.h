// Pairs of objects and planes: all there are, or those whose box reaches the half-space.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <span>
#include <string>

#include "compiler/plan/plan.h"
#include "library/detectors/detector.h"

namespace cdb::detection {

using Bodies = std::span<const std::unique_ptr<btRigidBody>>;

/// Why every object has to be in a pair with every plane for all bodies to move as they do in
/// Bullet, to the bit; empty if only those whose boxes reach the half-space need to be. In the
/// order `sorted` a pair without a contact has no effect, since Bullet 3.24 orders contacts by
/// body; in the order `listed`, and among the contacts of one compound, it orders them by all pairs
/// that there are.
std::string WhyAllWallPairs(const plan::Scene& scene, Bodies objects);

/// A plane with a box of our own in place of Bullet's infinite one, such that the box in a broad
/// phase, around which Bullet adds gContactBreakingThreshold, is the one that is set.
class HalfSpaceShape final : public btStaticPlaneShape {
 public:
  using btStaticPlaneShape::btStaticPlaneShape;
  void SetBox(const Box& box);
  void getAabb(const btTransform& pose, btVector3& lower, btVector3& upper) const override;

 private:
  btVector3 lower_ = {0, 0, 0}, upper_ = {0, 0, 0};
};

/// The box that stands for the half-space behind a plane, for broad phases: what it does not
/// overlap is too far from the plane for a contact with it, new or old. It reaches before the plane
/// by the distance up to which Bullet keeps contacts, less what the boxes of objects have around
/// them, and a rounding. Infinite on the other sides, and on all if the plane is not normal to an
/// axis. Its finite side is a number of Bullet's precision.
Box HalfSpaceBox(const btRigidBody& plane, Bodies objects);

}  // namespace cdb::detection
