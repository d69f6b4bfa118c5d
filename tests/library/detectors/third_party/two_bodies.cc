#include "tests/library/detectors/third_party/two_bodies.h"

#include <Eigen/Core>

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

Vec3 FromEigen(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Corner i is on the upper side along x if bit 0 is set, along y if bit 1 is, and along z if bit 2
// is.
constexpr Face kFaces[] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};

}  // namespace

TwoBodies::TwoBodies(const objects::Solid& a, const objects::Pose& pose_a, const objects::Solid& b,
                     const objects::Pose& pose_b, CuboidAs cuboids)
    : filters_(2) {
  Place(a, pose_a, cuboids);
  Place(b, pose_b, cuboids);
}

void TwoBodies::Place(const objects::Solid& solid, const objects::Pose& pose, CuboidAs cuboids) {
  const std::size_t body = shapes_.size();
  const Vector3d half = solid.HalfExtents();
  Shape shape = {.kind = solid.IsBall() ? ShapeKind::kEllipsoid : ShapeKind::kBox,
                 .half = FromEigen(half),
                 .centre = {},
                 .normal = {},
                 .hulls = {}};
  if (solid.shape == objects::Shape::kCuboid && cuboids == CuboidAs::kHull) {
    shape.kind = ShapeKind::kHull;
    for (int i = 0; i < 8; ++i)
      corners_[body].push_back({(i & 1) != 0 ? half.x() : -half.x(),
                                (i & 2) != 0 ? half.y() : -half.y(),
                                (i & 4) != 0 ? half.z() : -half.z()});
    hulls_[body] = {.vertices = corners_[body], .faces = kFaces};
    shape.hulls = {&hulls_[body], 1};
  } else if (solid.shape == objects::Shape::kCuboid) {
    shape.kind = ShapeKind::kBox;
  }
  shapes_.push_back(shape);
  const Eigen::Matrix3d axes = pose.orientation.toRotationMatrix();
  poses_.push_back({FromEigen(pose.position), FromEigen(axes.col(0)), FromEigen(axes.col(1)),
                    FromEigen(axes.col(2))});
  const objects::Box box = objects::Bounds(solid, pose.orientation);
  const Vector3d margin = Vector3d::Constant(0.02);  // like the contact margin of an engine
  boxes_.push_back({FromEigen(pose.position + box.lower - margin),
                    FromEigen(pose.position + box.upper + margin)});
}

Scene TwoBodies::View() const {
  return {.size = 2,
          .boxes = boxes_,
          .filters = filters_,
          .poses = poses_,
          .shapes = shapes_,
          .is_asleep = {}};
}

std::vector<Contact> ContactsOf(Detector& detector, const TwoBodies& bodies) {
  const Scene scene = bodies.View();
  std::vector<Contact> contacts;
  detector.Prepare(scene);
  const Pair pair = {0, 1};
  if (detector.Handles(scene, 0, 1)) detector.FindContacts(scene, {&pair, 1}, contacts);
  return contacts;
}

}  // namespace cdb::tests
