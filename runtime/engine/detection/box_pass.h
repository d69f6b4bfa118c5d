// The boxes of rigid bodies, computed in one pass over their poses.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/pair_buffer.h"

namespace cdb::detection {

/// The boxes that btCollisionWorld::updateAabbs gives a broad phase, to the bit: around a body
/// where it is and, unless it is fixed or kinematic, where it is predicted, plus
/// gContactBreakingThreshold on each side. Balls, boxes, cylinders, capsules, convex pieces and
/// compounds are computed here, provided that a trial at the start agrees with the virtual getAabb
/// of their shape; all other shapes are asked. Not thread-safe, except that one call may use
/// several threads.
class BoxPass {
 public:
  /// The bodies, their shapes and the sizes of those must outlive it and not change; nor may a body
  /// become fixed or kinematic, or cease to be. Fixed bodies must not move.
  explicit BoxPass(std::span<btRigidBody* const> bodies);

  /// Writes the boxes of active bodies, and, if `updates_all`, of the others. Skips those that were
  /// asleep in the last call too, because they have not moved, and fixed ones whose boxes are
  /// written. `is_asleep` has the last call's values and gets this one's; fixed bodies are always
  /// asleep, kinematic ones never. A body whose box exceeds Bullet's limit of 10^6 m keeps its box
  /// and is switched off, as by Bullet. Both spans have a value for each body. `parts` share the
  /// bodies; their number changes nothing.
  void Update(bool updates_all, std::span<Box> boxes, std::span<std::uint8_t> is_asleep,
              kernels::PairParts& parts);

  /// The number of bodies whose boxes are computed here.
  std::size_t computed() const { return computed_; }

 private:
  enum class Kind : std::uint8_t {
    kBall,       ///< the same in every orientation
    kCentred,    ///< a box around the origin
    kOffCentre,  ///< a box around another point
    kVirtual,
  };
  struct ShapeBox {
    btVector3 half;    ///< with margin
    btVector3 centre;  ///< in the body's frame
    const btCollisionShape* shape;
    Kind kind;
  };
  struct Body {
    btRigidBody* body;
    std::uint32_t shape;  ///< in shapes_
    Id id;
    bool needs_basis;  ///< not only the place of its pose
    bool is_static, is_kinematic;
  };
  struct Corners;

  static ShapeBox Describe(const btCollisionShape& shape);
  static Corners Around(const ShapeBox& shape, const btTransform& pose);
  static bool Agrees(const ShapeBox& shape);
  static bool Write(const ShapeBox& shape, const Body& at, Box& box);
  bool Visit(const Body& at, bool updates_all, std::span<Box> boxes,
             std::span<std::uint8_t> is_asleep) const;
  void VisitMoving(std::size_t from, std::size_t to, bool updates_all, std::span<Box> boxes,
                   std::span<std::uint8_t> is_asleep) const;

  std::vector<ShapeBox> shapes_;  ///< each once
  std::vector<Body> moving_;
  std::vector<Body> unwritten_;  ///< fixed bodies whose boxes are not written yet
  std::size_t computed_ = 0;
};

}  // namespace cdb::detection
