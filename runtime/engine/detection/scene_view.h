// The bodies of an engine as a cdb::Scene, the input of detectors.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "library/detectors/bullet/vectors.h"
#include "library/detectors/detector.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/detection/box_pass.h"
#include "runtime/engine/detection/detector_shapes.h"

namespace cdb::detection {

/// Objects, then the walls of the world, numbered consecutively in the order in which they are
/// added to the world. Boxes are Bullet's, including the 0.02 m that it adds on each side for
/// future contacts, except those of planes, which are infinite or, after CutPlanes, HalfSpaceBox,
/// and those of objects that are not in the world, which are NaN.
/// Not thread-safe.
class SceneView {
 public:
  /// The bodies must outlive it. `threads` share the reading of boxes and poses, which are the same
  /// with any number of them.
  SceneView(const std::vector<std::unique_ptr<btRigidBody>>& objects,
            const std::vector<std::unique_ptr<btRigidBody>>& walls,
            const layouts::InitialState& state, unsigned threads = 1);

  std::size_t size() const { return bodies_.size(); }
  btRigidBody& body(Id id) const { return *bodies_[id]; }
  /// Has no effect on the box of a plane.
  void SetBox(Id id, const btVector3& lower, const btVector3& upper) {
    if (id >= first_plane_) return;
    boxes_[id] = {bullet::ToVec3(lower), bullet::ToVec3(upper)};
  }
  /// What btCollisionWorld::updateAabbs does, for all bodies at once; see BoxPass. To be called in
  /// its place, before BeginCycle.
  void UpdateBoxes(bool updates_all) { box_pass_->Update(updates_all, boxes_, is_asleep_, parts_); }
  const Box& box(Id id) const { return boxes_[id]; }
  void SetFilter(Id id, int group, int mask);
  /// The body is no longer in the world: it has a box of NaN, which overlaps none.
  void RemoveBox(Id id);
  Id IdOf(const btCollisionObject& body) const;
  /// From now on, the box of a plane is that of its half-space.
  void CutPlanes();

  /// Begins a new cycle: poses must be read again.
  void BeginCycle() {
    ++cycle_;
    has_poses_ = false;
  }
  /// From 1, including the warm-up; 0 before the first cycle.
  std::uint64_t cycle() const { return cycle_; }
  /// The current input of a detector. Poses are read once per cycle, and only on request; those of
  /// bodies that have been asleep since they were read, and of fixed ones, are kept: after each
  /// UpdateBoxes, they must be asked for before the bodies move.
  Scene For(bool wants_poses);

 private:
  void TakePoses();

  kernels::PairParts parts_;
  std::vector<btRigidBody*> bodies_;
  const std::vector<std::unique_ptr<btRigidBody>>& objects_;
  Id first_plane_;  ///< planes come last
  DetectorShapes shape_parts_;
  std::vector<Shape> shapes_;
  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
  std::vector<Pose> poses_;
  std::vector<std::uint8_t> is_asleep_;
  std::vector<std::uint8_t> was_asleep_;  ///< as is_asleep_ was when the poses were read
  std::optional<BoxPass> box_pass_;       ///< of all bodies but planes
  std::uint64_t cycle_ = 0;
  bool has_poses_ = false;
};

}  // namespace cdb::detection
