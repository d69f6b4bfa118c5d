// FCL's narrow phases on triangles: trees of boxes, of oriented boxes, of rectangle-swept spheres
// and of k-DOPs, which find intersecting triangles.
//
// FCL's depth and normal of two triangles hold for these two alone. Among the normals of all
// intersecting triangles, the one along which the pieces overlap least is used. Source: S.
// Gottschalk et al., OBBTree, 1996; E. Larsen et al., Fast proximity queries with swept sphere
// volumes, 1999; J. Klosowski et al., Efficient collision detection using bounding volume
// hierarchies of k-DOPs, 1998.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/detail/traversal/collision/mesh_collision_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/collision_node.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "library/detectors/third_party/fcl/narrow.h"
#include "library/detectors/third_party/piece_pairs.h"

namespace cdb::third_party {
namespace {

using Eigen::Vector3d;

struct Mesh {
  std::vector<fcl::Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;

  Vector3d Side(std::size_t triangle, int side) const {
    const fcl::Triangle& corners = triangles[triangle];
    return vertices[corners[(side + 1) % 3]] - vertices[corners[side]];
  }
  /// Points out of the piece.
  Vector3d Normal(std::size_t triangle) const { return Side(triangle, 0).cross(Side(triangle, 1)); }
};

Mesh MeshOf(const Hull& hull) {
  Mesh mesh;
  for (const Vec3& vertex : hull.vertices) mesh.vertices.push_back(ToEigen(vertex));
  for (const Face& face : hull.faces) mesh.triangles.emplace_back(face.a, face.b, face.c);
  return mesh;
}

/// A shape that is round about y, by its outline from the lower end to the upper: width, in half
/// extents, and height.
struct Ring {
  double width, y;
};

std::vector<Ring> OutlineOf(const Shape& shape) {
  const double low = shape.centre.y - shape.half.y, high = shape.centre.y + shape.half.y;
  if (shape.kind == ShapeKind::kCylinder) return {{0, low}, {1, low}, {1, high}, {0, high}};
  if (shape.kind == ShapeKind::kCone) return {{0, low}, {1, low}, {0, high}};
  const double straight = shape.kind == ShapeKind::kCapsule ? StraightHalf(shape) : 0;
  constexpr int kSteps = 12;  // from end to end
  std::vector<Ring> rings;
  for (int step = 0; step <= kSteps; ++step) {
    const double up = (step - kSteps / 2) * std::numbers::pi / kSteps;
    const double y = std::sin(up) * (shape.half.y - straight);
    const bool is_end = step == 0 || step == kSteps;
    if (straight > 0 && step == kSteps / 2) rings.push_back({1, -straight});
    rings.push_back({is_end ? 0 : std::cos(up), y + (step < kSteps / 2 ? -straight : straight)});
  }
  return rings;
}

Mesh RoundMesh(const Shape& shape) {
  constexpr std::size_t kSides = 24;
  Mesh mesh;
  const auto triangle = [&](std::size_t a, std::size_t b, std::size_t c) {
    mesh.triangles.emplace_back(a, b, c);
  };
  std::size_t before = 0;  // index of the first corner of the ring below, or the lower end
  for (const Ring& ring : OutlineOf(shape)) {
    const std::size_t first = mesh.vertices.size();
    const std::size_t sides = ring.width > 0 ? kSides : 1;
    for (std::size_t side = 0; side < sides; ++side) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(side) / kSides;
      mesh.vertices.emplace_back(shape.half.x * ring.width * std::cos(angle), ring.y,
                                 shape.half.z * ring.width * std::sin(angle));
    }
    const bool is_point_below = first - before == 1;
    for (std::size_t side = 0; first > 0 && side < kSides; ++side) {
      const std::size_t next = (side + 1) % kSides;
      if (is_point_below) {
        triangle(before, first + side, first + next);
      } else if (sides == 1) {
        triangle(before + side, first, before + next);
      } else {
        triangle(before + side, first + side, first + next);
        triangle(before + side, first + next, before + next);
      }
    }
    before = first;
  }
  return mesh;
}

Mesh BoxMesh(const Vec3& half) {
  Mesh mesh;
  // Corner i is on the upper side of x if bit 0 is set, of y if bit 1, of z if bit 2.
  for (const int corner : {0, 1, 2, 3, 4, 5, 6, 7})
    mesh.vertices.emplace_back((corner & 1) != 0 ? half.x : -half.x,
                               (corner & 2) != 0 ? half.y : -half.y,
                               (corner & 4) != 0 ? half.z : -half.z);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Mesh MeshOf(const Shape& shape, std::size_t piece) {
  if (!shape.hulls.empty()) return MeshOf(shape.hulls[piece]);
  return shape.kind == ShapeKind::kBox ? BoxMesh(shape.half) : RoundMesh(shape);
}

/// More intersections add little.
constexpr std::size_t kMostCrossings = 200;

/// `Volume`: the bounding volume of the tree. `tells_distance`: FCL can compute the distance of two
/// such trees.
template <typename Volume, bool tells_distance>
class Trees final : public PiecePairs {
  using Model = fcl::BVHModel<Volume>;

  struct Tree {
    std::unique_ptr<Model> model;
    Mesh mesh;
  };

  void AddForm(const Shape& shape) override {
    std::vector<Tree>& trees = forms_.emplace_back();
    if (!Takes(shape)) return;
    for (std::size_t piece = 0; piece < PieceCount(shape); ++piece) {
      Tree& tree = trees.emplace_back();
      tree.mesh = MeshOf(shape, piece);
      tree.model = std::make_unique<Model>();
      tree.model->beginModel();
      tree.model->addSubModel(tree.mesh.vertices, tree.mesh.triangles);
      tree.model->endModel();
    }
  }

  static fcl::Transform3d PoseOf(const PlacedPiece& piece) {
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.linear() = piece.axes;
    pose.translation() = piece.at;
    return pose;
  }

  /// The depth of the overlap of the pieces along `normal` (unit, from b to a).
  static double Overlap(const PlacedPiece& a, const PlacedPiece& b, const Vector3d& normal) {
    return normal.dot(b.Support(normal) - a.Support(-normal));
  }

  void Touch(const Scene& scene, const Place& a, const Place& b,
             std::vector<Contact>& contacts) override {
    const PlacedPiece of_a(scene, a.body, a.piece), of_b(scene, b.body, b.piece);
    const Tree &first = forms_[a.form][a.piece], &second = forms_[b.form][b.piece];
    const fcl::Transform3d at_a = PoseOf(of_a), at_b = PoseOf(of_b);
    fcl::CollisionResultd result;
    Cross(*first.model, at_a, *second.model, at_b, result);
    double least = std::numeric_limits<double>::infinity();
    Vector3d normal = Vector3d::Zero();
    const auto consider = [&](const Vector3d& way) {
      const Vector3d candidate = way.stableNormalized();
      if (candidate.isZero()) return;  // degenerate, or parallel sides
      const double overlap = Overlap(of_a, of_b, candidate);
      if (overlap >= least) return;
      least = overlap;
      normal = candidate;
    };
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      consider(of_a.axes * -first.mesh.Normal(result.getContact(i).b1));
      consider(of_b.axes * second.mesh.Normal(result.getContact(i).b2));
    }
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      for (int side = 0; side < 9; ++side) {
        const Vector3d of_first = of_a.axes * first.mesh.Side(result.getContact(i).b1, side / 3);
        const Vector3d of_second = of_b.axes * second.mesh.Side(result.getContact(i).b2, side % 3);
        const Vector3d across = of_first.cross(of_second);
        consider(across.dot(normal) < 0 ? -across : across);
      }
    }
    if constexpr (tells_distance) {
      if (result.numContacts() == 0) {
        // Meshes of round shapes lie inside the shapes.
        const double bound = kNear + 0.01 * (BallOf(a).radius + BallOf(b).radius);
        normal = WayBetween(*first.model, at_a, *second.model, at_b, bound);
        if (normal.isZero()) return;
        // The line between the nearest points of the meshes is not exactly the shortest either.
        least = std::min(Overlap(of_a, of_b, normal), 0.0);
      }
    }
    if (std::isfinite(least) && -least <= kNear)
      Add(a, b, MeetingPoint(of_a, of_b, normal), normal, -least, contacts);
  }

  /// Finds the intersecting triangles. For each pair, FCL's own function copies and refits both
  /// trees, except trees of oriented boxes; swept spheres do not need to be copied either.
  static void Cross(const Model& first, const fcl::Transform3d& at_first, const Model& second,
                    const fcl::Transform3d& at_second, fcl::CollisionResultd& result) {
    const fcl::CollisionRequestd request(kMostCrossings, false);
    if constexpr (tells_distance) {
      fcl::detail::MeshCollisionTraversalNodeRSS<double> node;
      if (fcl::detail::initialize(node, first, at_first, second, at_second, request, result))
        fcl::detail::collide(&node);
    } else {
      fcl::collide(&first, at_first, &second, at_second, request, result);
    }
  }

  /// The unit vector from the second to the first at the nearest points; 0 if they are farther
  /// apart than `bound`, which FCL uses as the initial minimum.
  static Vector3d WayBetween(const Model& first, const fcl::Transform3d& at_first,
                             const Model& second, const fcl::Transform3d& at_second, double bound) {
    const fcl::DistanceRequestd request(true);
    fcl::DistanceResultd result(bound);
    fcl::distance(&first, at_first, &second, at_second, request, result);
    if (!(result.min_distance > 0 && result.min_distance < bound)) return Vector3d::Zero();
    return (result.nearest_points[0] - result.nearest_points[1]).stableNormalized();
  }

  std::vector<std::vector<Tree>> forms_;
};

}  // namespace

Detector* MakeFclAabb(const Options&) { return new Trees<fcl::AABBd, false>; }
Detector* MakeFclObb(const Options&) { return new Trees<fcl::OBBd, false>; }
Detector* MakeFclRss(const Options&) { return new Trees<fcl::RSSd, true>; }
Detector* MakeFclKdop(const Options&) { return new Trees<fcl::KDOP<double, 18>, false>; }

}  // namespace cdb::third_party
