#include "runtime/engine/detection/scene_view.h"

#include <algorithm>
#include <limits>

#include "runtime/engine/detection/wall_pairs.h"

namespace cdb::detection {
namespace {

constexpr double kWorkOfPose = 40;  ///< ns, about
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Box kNoBox = {{kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}};

bool IsPlane(const btRigidBody& wall) {
  return wall.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
}

/// Walls are what MakeWall of the engine makes them.
Shape WallShape(const btRigidBody& wall) {
  if (IsPlane(wall)) {
    const auto& plane = static_cast<const btStaticPlaneShape&>(*wall.getCollisionShape());
    return {.kind = ShapeKind::kPlane,
            .half = {kInfinite, kInfinite, kInfinite},
            .centre = {0, 0, 0},
            .normal = bullet::ToVec3(plane.getPlaneNormal()),
            .hulls = {}};
  }
  const auto& box = static_cast<const btBoxShape&>(*wall.getCollisionShape());
  return {.kind = ShapeKind::kBox,
          .half = bullet::ToVec3(box.getHalfExtentsWithMargin()),
          .centre = {0, 0, 0},
          .normal = {0, 0, 0},
          .hulls = {}};
}

}  // namespace

SceneView::SceneView(const std::vector<std::unique_ptr<btRigidBody>>& objects,
                     const std::vector<std::unique_ptr<btRigidBody>>& walls,
                     const layouts::InitialState& state, unsigned threads)
    : parts_(threads), objects_(objects) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    bodies_.push_back(objects[i].get());
    shapes_.push_back(shape_parts_.Of(state.objects[i].solid));
  }
  first_plane_ = static_cast<Id>(objects.size() + walls.size());
  for (const auto& wall : walls) {
    if (IsPlane(*wall)) first_plane_ = static_cast<Id>(objects.size());
    bodies_.push_back(wall.get());
    shapes_.push_back(WallShape(*wall));
  }
  boxes_.assign(size(), {{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, kInfinite}});
  std::fill_n(boxes_.begin(), objects.size(), kNoBox);
  filters_.resize(size());
  is_asleep_.assign(size(), 0);
  box_pass_.emplace(std::span(bodies_).first(first_plane_));
  std::fill(is_asleep_.begin() + first_plane_, is_asleep_.end(), 1);
  for (Id id = 0; id < size(); ++id) {
    filters_[id].is_fixed = body(id).isStaticOrKinematicObject();
    filters_[id].is_kinematic = body(id).isKinematicObject();
  }
}

void SceneView::SetFilter(Id id, int group, int mask) {
  filters_[id].group = static_cast<std::uint32_t>(group);
  filters_[id].mask = static_cast<std::uint32_t>(mask);
}

void SceneView::RemoveBox(Id id) {
  boxes_[id] = kNoBox;
  is_asleep_[id] = 0;  // the next box is another one
}

Id SceneView::IdOf(const btCollisionObject& body) const {
  const auto index = static_cast<std::size_t>(body.getUserIndex());
  if (index < objects_.size()) return static_cast<Id>(index);
  return static_cast<Id>(std::ranges::find(bodies_, &body) - bodies_.begin());
}

void SceneView::CutPlanes() {
  for (Id id = first_plane_; id < size(); ++id) boxes_[id] = HalfSpaceBox(body(id), objects_);
}

void SceneView::TakePoses() {
  poses_.resize(size());
  was_asleep_.resize(size(), 0);
  const double work = kWorkOfPose * static_cast<double>(size());
  const kernels::ThreadPool::Session session = parts_.Begin(work);
  parts_.ForEach(work, 0, size(), 1, [&](unsigned, std::size_t from, std::size_t to) {
    for (std::size_t id = from; id < to; ++id) {
      if (was_asleep_[id] != 0 && is_asleep_[id] != 0) continue;
      was_asleep_[id] = is_asleep_[id];
      const btTransform& pose = bodies_[id]->getWorldTransform();
      const btMatrix3x3& basis = pose.getBasis();
      poses_[id] = {bullet::ToVec3(pose.getOrigin()), bullet::ToVec3(basis.getColumn(0)),
                    bullet::ToVec3(basis.getColumn(1)), bullet::ToVec3(basis.getColumn(2))};
    }
  });
  has_poses_ = true;
}

Scene SceneView::For(bool wants_poses) {
  Scene scene = {.size = size(),
                 .boxes = boxes_,
                 .filters = filters_,
                 .poses = {},
                 .shapes = shapes_,
                 .is_asleep = is_asleep_};
  if (!wants_poses) return scene;
  if (!has_poses_) TakePoses();
  scene.poses = poses_;
  return scene;
}

}  // namespace cdb::detection
