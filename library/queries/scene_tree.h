// cdb's own answers to queries: a tree of the bodies' boxes, refitted to their poses in each cycle;
// a closed form for each shape that a ray meets, and the gap of convex pieces for shapes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/queries/line_shape.h"
#include "library/queries/shape_casts.h"
#include "library/queries/wide_tree.h"

namespace cdb::queries {

/// Which hits a query asks for.
enum class Hits {
  kClosest,
  kAny,
  kAll,  ///< a hit of each body, its nearest, in no order
};

/// The points from + t along, 0 <= t <= length; `along` is a unit vector.
template <typename Real>
struct Ray {
  Vec<Real> from, along;
  Real length;
};

template <typename Real>
struct Hit {
  std::int32_t body;
  Real distance;     ///< m, from the start of the ray
  Vec<Real> normal;  ///< unit, outwards
};

/// Not thread-safe.
template <typename Real>
class SceneTree {
 public:
  using Axes = Eigen::Matrix<Real, 3, 3>;

  /// Adds a body, which `id` stands for in hits, and returns its index. A ray that starts inside a
  /// solid, or one of its pieces, does not hit that.
  std::size_t Add(const objects::Solid& solid, std::int32_t id);
  /// Adds {x : normal . x <= offset}, which never moves.
  void AddHalfSpace(const Vec<Real>& normal, Real offset, std::int32_t id) {
    half_spaces_.push_back({normal, offset, id});
  }
  /// `axes`: those of the body, as columns.
  void Move(std::size_t index, const Vec<Real>& position, const Axes& axes);
  /// Adapts the tree to the poses, if any body has moved: refits it, or builds it anew if it has
  /// become worse by half.
  void Update();

  /// Appends the hits of a ray.
  void Cast(const Ray<Real>& ray, Hits hits, std::vector<Hit<Real>>& found) const;
  /// Of a shape that moves along the unit vector; a body that it overlaps from the start is 0 away.
  void Sweep(const Placed& from, const Eigen::Vector3d& along, double length, Hits hits,
             std::vector<Hit<Real>>& found) const;
  /// The bodies that the shape overlaps or touches, or any one of them.
  void Overlap(const Placed& at, Hits hits, std::vector<Hit<Real>>& found) const;
  /// The nearest body within `reach`; 0 away if the shape overlaps it.
  void Nearest(const Placed& at, double reach, std::vector<Hit<Real>>& found) const;

 private:
  struct Body {
    objects::Solid solid;
    const LineShape<Real>* shape;
    std::int32_t id;
    Vec<Real> position;
    Axes axes;

    objects::Pose pose() const {
      return {position.template cast<double>(),
              Eigen::Quaterniond(Eigen::Matrix3d(axes.template cast<double>())).normalized()};
    }
  };
  struct HalfSpace {
    Vec<Real> normal;
    Real offset;
    std::int32_t id;

    exact::HalfSpace exact() const {
      return {normal.template cast<double>(), static_cast<double>(offset)};
    }
  };
  static Hit<Real> HitOf(std::int32_t id, const Touch& touch) {
    return {id, static_cast<Real>(touch.distance), touch.normal.template cast<Real>()};
  }

  /// The first point of the body within `limit`, which is reduced to it; false if there is none.
  bool HitBody(const Body& body, const Ray<Real>& ray, float& limit, Real& most,
               Hit<Real>& hit) const;
  bool HitHalfSpace(const HalfSpace& space, const Ray<Real>& ray, Real most, Hit<Real>& hit) const;

  LineShapes<Real> shapes_;
  std::vector<Body> bodies_;
  std::vector<HalfSpace> half_spaces_;
  std::vector<FloatBox> boxes_;  ///< by body
  WideTree tree_;
  double built_cost_ = -1;  ///< negative: not built
  bool has_moved_ = false;
};

extern template class SceneTree<float>;
extern template class SceneTree<double>;

}  // namespace cdb::queries
