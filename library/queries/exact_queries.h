// The truth about queries: every body that a ray or a shape meets, by brute force over all of them
// in double precision, without a tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/objects/solid.h"
#include "library/queries/line_shape.h"
#include "library/queries/scene_tree.h"

namespace cdb::queries {

/// A body, or one of its pieces, that a query finds.
struct ExactHit {
  std::int32_t body = -1;
  double distance = 0;  ///< m: the way of the ray or the shape; or their distance
  /// m: how far from missing it: the length of a line in the body, or the depth of the shape in it;
  /// infinite for a surface and for the nearest body.
  double inside = 0;
  double margin = 1;  ///< of a triangle: the least barycentric coordinate of the point
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, outwards
  double size = 0;                                    ///< m, of the body; of a wall, infinite
};

/// Not thread-safe.
class ExactQueries {
 public:
  struct Body {
    objects::Solid solid;
    objects::Pose pose;
    std::int32_t id = -1;
  };

  void Add(Body body);
  /// Adds {x : normal . x <= offset}.
  void AddHalfSpace(const Eigen::Vector3d& normal, double offset, std::int32_t id) {
    half_spaces_.push_back({normal, offset, id});
  }
  void Move(std::size_t index, const objects::Pose& pose) { bodies_[index].body.pose = pose; }

  /// Every crossing of the line of the ray with a body, by distance, from `slack` before its start
  /// to `slack` after its end.
  std::vector<ExactHit> Find(const Ray<double>& ray, double slack) const;
  /// Every body that the shape meets within `length`, by distance.
  std::vector<ExactHit> FindSwept(const Placed& from, const Eigen::Vector3d& along,
                                  double length) const;
  /// Every body that the shape overlaps or touches.
  std::vector<ExactHit> FindOverlaps(const Placed& at) const;
  /// Every body within `reach`, by distance.
  std::vector<ExactHit> FindNear(const Placed& at, double reach) const;
  /// m: the distance of a shape from a body or a wall, 0 if they overlap.
  double DistanceOf(std::int32_t body, const Placed& at) const;

 private:
  struct Row {
    Body body;
    const LineShape<double>* shape;
    double radius;  ///< m, of a ball around it
  };
  struct HalfSpace {
    Eigen::Vector3d normal;
    double offset;
    std::int32_t id;

    exact::HalfSpace exact() const { return {normal, offset}; }
  };

  /// Calls `visit(id, size, test)` for each wall, and each body whose ball comes within `reach` of
  /// the ball of the shape on its way; `test(by_solid, by_half_space)` calls one of the two.
  template <typename Visit>
  void ForBodies(const Placed& from, const Eigen::Vector3d& way, double reach, Visit visit) const;

  LineShapes<double> shapes_;
  std::vector<Row> bodies_;
  std::vector<HalfSpace> half_spaces_;
};

}  // namespace cdb::queries
