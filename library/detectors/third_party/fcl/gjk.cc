// FCL's narrow phase on convex shapes: closed forms if available (balls, boxes), otherwise GJK with
// an expanding polytope.
//
// Source: J. Pan, S. Chitta & D. Manocha, FCL, 2012; G. van den Bergen, Proximity queries and
// penetration depth computation on 3D game objects, 2001.
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include "library/detectors/third_party/fcl/narrow.h"
#include "library/detectors/third_party/piece_pairs.h"

namespace cdb::third_party {
namespace {

using Eigen::Vector3d;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

/// A geometry and its pose in the body's frame.
struct Part {
  Geometry geometry;
  fcl::Transform3d at = fcl::Transform3d::Identity();
};

Geometry ConvexOf(const Hull& hull) {
  auto vertices = std::make_shared<std::vector<fcl::Vector3d>>();
  for (const Vec3& vertex : hull.vertices) vertices->push_back(ToEigen(vertex));
  auto faces = std::make_shared<std::vector<int>>();
  for (const Face& face : hull.faces)
    faces->insert(faces->end(), {3, static_cast<int>(face.a), static_cast<int>(face.b),
                                 static_cast<int>(face.c)});
  return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(hull.faces.size()), faces);
}

/// FCL's shapes stand along z.
Part Upright(Geometry geometry, double middle) {
  Part part{.geometry = std::move(geometry)};
  part.at.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  part.at.translation() = Vector3d(0, middle, 0);
  return part;
}

Part PartOf(const Shape& shape, std::size_t piece) {
  const auto& [x, y, z] = shape.half;
  switch (shape.kind) {
    case ShapeKind::kBox:
      return {.geometry = std::make_shared<fcl::Boxd>(2 * x, 2 * y, 2 * z)};
    case ShapeKind::kCylinder:
      return Upright(std::make_shared<fcl::Cylinderd>(x, 2 * y), 0);
    case ShapeKind::kCone:
      return Upright(std::make_shared<fcl::Coned>(x, 2 * y), shape.centre.y);
    case ShapeKind::kCapsule:
      if (const double straight = StraightHalf(shape); straight > 0)
        return Upright(std::make_shared<fcl::Capsuled>(x, 2 * straight), 0);
      break;
    case ShapeKind::kHull:
    case ShapeKind::kCompound:
      return {.geometry = ConvexOf(shape.hulls[piece])};
    default:
      break;
  }
  if (x == y && y == z) return {.geometry = std::make_shared<fcl::Sphered>(x)};
  return {.geometry = std::make_shared<fcl::Ellipsoidd>(x, y, z)};
}

class Gjk final : public PiecePairs {
 private:
  bool Takes(const Shape& shape) const override {
    switch (shape.kind) {
      case ShapeKind::kPlane:
      case ShapeKind::kSurface:
      case ShapeKind::kSuperellipsoid:
        return false;
      case ShapeKind::kCylinder:
      case ShapeKind::kCone:
        return shape.half.x == shape.half.z;
      case ShapeKind::kCapsule:
        return shape.half.x == shape.half.z || StraightHalf(shape) == 0;
      default:
        return true;
    }
  }

  void AddForm(const Shape& shape) override {
    std::vector<Part>& parts = forms_.emplace_back();
    if (!Takes(shape)) return;
    for (std::size_t piece = 0; piece < PieceCount(shape); ++piece)
      parts.push_back(PartOf(shape, piece));
  }

  fcl::Transform3d PoseOf(const Scene& scene, const Place& place, const Part& part) const {
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.linear() = AxesOf(scene.poses[place.body]);
    pose.translation() = ToEigen(scene.poses[place.body].position);
    return pose * part.at;
  }

  void Touch(const Scene& scene, const Place& a, const Place& b,
             std::vector<Contact>& contacts) override {
    const Part &first = forms_[a.form][a.piece], &second = forms_[b.form][b.piece];
    const fcl::Transform3d at_first = PoseOf(scene, a, first), at_second = PoseOf(scene, b, second);
    constexpr std::size_t kMostContacts = 4;
    try {
      const fcl::CollisionRequestd request(kMostContacts, true);
      fcl::CollisionResultd result;
      fcl::collide(first.geometry.get(), at_first, second.geometry.get(), at_second, request,
                   result);
      for (std::size_t i = 0; i < result.numContacts(); ++i) {
        const fcl::Contactd& contact = result.getContact(i);
        Add(a, b, result.numContacts() > 1 ? contact.pos : Halfway(scene, a, b, contact),
            -contact.normal, -contact.penetration_depth, contacts);
      }
      if (result.numContacts() > 0) return;
      const fcl::DistanceRequestd how_far(true);
      fcl::DistanceResultd apart;
      fcl::distance(first.geometry.get(), at_first, second.geometry.get(), at_second, how_far,
                    apart);
      if (!(apart.min_distance > 0 && apart.min_distance <= kNear)) return;
      const Vector3d on_a = apart.nearest_points[0], on_b = apart.nearest_points[1];
      Add(a, b, (on_a + on_b) / 2, (on_a - on_b).stableNormalized(), apart.min_distance, contacts);
    } catch (const std::exception&) {
      // FCL's GJK fails for some poses and reports it by an exception: the pair gets no contact.
    }
  }

  /// FCL's contact point is on the line of the contact, but anywhere between the two surfaces.
  static Vector3d Halfway(const Scene& scene, const Place& a, const Place& b,
                          const fcl::Contactd& contact) {
    const PlacedPiece of_a(scene, a.body, a.piece), of_b(scene, b.body, b.piece);
    const Vector3d& way = contact.normal;
    const double middle = (of_a.Support(way) + of_b.Support(-way)).dot(way) / 2;
    return contact.pos + (middle - contact.pos.dot(way)) * way;
  }

  std::vector<std::vector<Part>> forms_;
};

}  // namespace

Detector* MakeFclGjk(const Options&) { return new Gjk; }

}  // namespace cdb::third_party
