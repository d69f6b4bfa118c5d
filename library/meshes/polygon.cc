#include "library/meshes/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cdb::meshes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d NormalOf(std::span<const std::uint32_t> corners, std::span<const Vector3d> vertices) {
  Vector3d normal = Vector3d::Zero();
  const Vector3d& origin = vertices[corners[0]];
  for (std::size_t i = 2; i < corners.size(); ++i)
    normal += (vertices[corners[i - 1]] - origin).cross(vertices[corners[i]] - origin);
  return normal;
}

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Twice the signed area of a triangle.
double Turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) { return Cross(b - a, c - b); }

/// The corners in the plane across the normal, counter-clockwise.
std::vector<Vector2d> Projected(std::span<const std::uint32_t> corners,
                                std::span<const Vector3d> vertices, const Vector3d& normal) {
  // Along an axis, so that coordinates stay as they are.
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const double sign = normal[axis] < 0 ? -1 : 1;
  std::vector<Vector2d> flat;
  flat.reserve(corners.size());
  for (const std::uint32_t corner : corners)
    flat.emplace_back(sign * vertices[corner][u], vertices[corner][v]);
  return flat;
}

/// Clips ears off one polygon. Corners are numbers in the order of the polygon, in a ring.
class EarClipper {
 public:
  explicit EarClipper(std::vector<Vector2d> corners) : points_(std::move(corners)) {
    const std::size_t count = points_.size();
    for (std::size_t i = 0; i < count; ++i) {
      next_.push_back((i + 1) % count);
      previous_.push_back((i + count - 1) % count);
    }
    for (std::size_t i = 0; i < count; ++i)
      if (TurnAt(i) <= 0) blunt_.push_back(i);
  }

  /// Calls `add(a, b, c)` for each triangle.
  template <typename Add>
  void Clip(const Add& add) {
    std::size_t left = points_.size(), at = 0;
    // Strict ears first; then corners that only touch; then, if the polygon crosses itself, any.
    for (int laxness = 0; laxness <= 2 && left > 3; ++laxness) {
      is_ear_.resize(points_.size());
      for (std::size_t i = 0; i < left; ++i, at = next_[at]) is_ear_[at] = IsEar(at, laxness);
      for (std::size_t passed = 0; left > 3 && passed < left;) {
        if (!is_ear_[at]) {
          ++passed;
          at = next_[at];
          continue;
        }
        const std::size_t before = previous_[at], after = next_[at];
        add(before, at, after);
        Remove(at);
        --left;
        // Clipping an ear changes no other corner. The next one to try is not a neighbour, so that
        // the ears do not become a fan of slivers.
        for (const std::size_t i : {before, after}) is_ear_[i] = IsEar(i, laxness);
        passed = 0;
        at = next_[after];
      }
    }
    add(previous_[at], at, next_[at]);
  }

 private:
  double TurnAt(std::size_t i) const {
    return Turn(points_[previous_[i]], points_[i], points_[next_[i]]);
  }

  bool IsEar(std::size_t at, int laxness) const {
    if (laxness == 2) return true;
    const Vector2d &a = points_[previous_[at]], &b = points_[at], &c = points_[next_[at]];
    if (!(Turn(a, b, c) > 0)) return false;
    const Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    return std::ranges::none_of(blunt_, [&](std::size_t i) {
      const Vector2d& p = points_[i];
      if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) return false;
      if (p == a || p == b || p == c) return false;
      const double least = std::min({Turn(a, b, p), Turn(b, c, p), Turn(c, a, p)});
      return laxness == 0 ? least >= 0 : least > 0;
    });
  }

  void Remove(std::size_t at) {
    const std::size_t before = previous_[at], after = next_[at];
    next_[before] = after;
    previous_[after] = before;
    // A corner with a positive turn blocks no ear.
    std::erase_if(blunt_, [&](std::size_t i) {
      return i == at || ((i == before || i == after) && TurnAt(i) > 0);
    });
  }

  std::vector<Vector2d> points_;
  std::vector<std::size_t> next_, previous_;
  std::vector<std::size_t> blunt_;  ///< corners that do not turn to the left
  std::vector<char> is_ear_;
};

}  // namespace

bool IsFan(std::span<const std::uint32_t> corners, std::span<const Vector3d> vertices) {
  if (corners.size() == 3) return true;
  const Vector3d normal = NormalOf(corners, vertices);
  // Without an area, no triangulation is better than another.
  if (!(normal.squaredNorm() > 0)) return true;
  const std::vector<Vector2d> flat = Projected(corners, vertices, normal);
  for (std::size_t i = 2; i < flat.size(); ++i)
    if (!(Turn(flat[0], flat[i - 1], flat[i]) > 0)) return false;
  return true;
}

void Triangulate(std::span<const std::uint32_t> corners, std::span<const Vector3d> vertices,
                 std::vector<Triangle>& triangles) {
  if (IsFan(corners, vertices)) {
    for (std::size_t i = 2; i < corners.size(); ++i)
      triangles.push_back({corners[0], corners[i - 1], corners[i]});
    return;
  }
  EarClipper(Projected(corners, vertices, NormalOf(corners, vertices)))
      .Clip([&](std::size_t a, std::size_t b, std::size_t c) {
        triangles.push_back({corners[a], corners[b], corners[c]});
      });
}

}  // namespace cdb::meshes
