#include "library/exact/legal_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <vector>

namespace cdb::exact {
namespace {

using Eigen::Vector3d;

constexpr double kSamePoint = 1e-5;  ///< of the surface's longest side
constexpr double kLevel = 1e-4;      ///< rad: rounding of the corners in a file

struct SurfaceTriangle {
  std::array<Vector3d, 3> corners;
  std::array<Vector3d, 3> edges;   ///< unit, from corner i to the next
  std::array<Vector3d, 3> inward;  ///< unit, in the plane, from edge i into the triangle
  Vector3d normal;

  explicit SurfaceTriangle(const std::array<Vector3d, 3>& points) : corners(points) {
    normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    for (std::size_t i = 0; i < 3; ++i) {
      edges[i] = (corners[(i + 1) % 3] - corners[i]).normalized();
      inward[i] = normal.cross(edges[i]);
    }
  }

  double HeightOver(std::size_t edge, const Vector3d& point) const {
    return inward[edge].dot(point - corners[edge]);
  }
  Vector3d NearestOnEdge(std::size_t edge, const Vector3d& point) const {
    const double length = (corners[(edge + 1) % 3] - corners[edge]).norm();
    return corners[edge] +
           std::clamp(edges[edge].dot(point - corners[edge]), 0.0, length) * edges[edge];
  }
  double DistanceTo(const Vector3d& point) const {
    bool is_over = true;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
      is_over = is_over && HeightOver(i, point) >= 0;
      least = std::min(least, (NearestOnEdge(i, point) - point).norm());
    }
    return is_over ? std::abs(normal.dot(point - corners[0])) : least;
  }

  /// Whether no part of the triangle next to `point` rises above the plane through it. True if the
  /// point is not on the triangle.
  bool IsBelow(const Vector3d& point, const Vector3d& up, double tolerance) const {
    if (DistanceTo(point) > tolerance) return true;
    std::array<std::size_t, 3> on = {};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if (HeightOver(i, point) <= tolerance) on[count++] = i;
    if (count == 0) return up.cross(normal).norm() <= kLevel;
    if (count == 1)
      return std::abs(up.dot(edges[on[0]])) <= kLevel && up.dot(inward[on[0]]) <= kLevel;
    if (count == 3) return true;  // smaller than the tolerance
    // At a corner: edge i begins at corner i and ends at the next.
    const std::size_t corner = (on[0] + 1) % 3 == on[1] ? on[1] : on[0];
    return up.dot(edges[corner]) <= kLevel && up.dot(edges[(corner + 2) % 3]) >= -kLevel;
  }
};

class NormalSearch {
 public:
  NormalSearch(const objects::Compound& surface, const Vector3d& point, const Vector3d& normal,
               double reach)
      : point_(point),
        normal_(normal),
        reach_(reach),
        tolerance_(kSamePoint * surface.sides().maxCoeff()) {
    const Vector3d half = Vector3d::Constant(reach + 2 * tolerance_);
    surface.AnyPieceIn({point - half, point + half}, [&](std::size_t piece) {
      triangles_.emplace_back(
          std::array{surface.Corner(piece, 0), surface.Corner(piece, 1), surface.Corner(piece, 2)});
      return false;
    });
  }

  std::optional<Vector3d> Run() {
    for (const SurfaceTriangle& triangle : triangles_)
      if (triangle.DistanceTo(point_) <= reach_) {
        Consider(triangle.normal);
        Consider(-triangle.normal);
      }
    if (!best_ || most_ >= 1 - kLevel * kLevel / 2) return best_;
    for (const SurfaceTriangle& triangle : triangles_)
      for (std::size_t i = 0; i < 3; ++i) {
        ConsiderAt(triangle.corners[i], normal_);
        const Vector3d across = normal_ - normal_.dot(triangle.edges[i]) * triangle.edges[i];
        if (across.norm() > kLevel)
          ConsiderAt(triangle.NearestOnEdge(i, point_), across.normalized());
      }
    return best_;
  }

 private:
  void Consider(const Vector3d& legal) {
    if (legal.dot(normal_) <= most_) return;
    most_ = legal.dot(normal_);
    best_ = legal;
  }
  void ConsiderAt(const Vector3d& place, const Vector3d& up) {
    if (up.dot(normal_) <= most_ || (place - point_).norm() > reach_) return;
    const bool is_legal = std::ranges::all_of(triangles_, [&](const SurfaceTriangle& triangle) {
      return triangle.IsBelow(place, up, tolerance_);
    });
    if (is_legal) Consider(up);
  }

  const Vector3d point_, normal_;
  const double reach_, tolerance_;
  std::vector<SurfaceTriangle> triangles_;
  std::optional<Vector3d> best_;
  double most_ = -2;  ///< cosine of the angle of `best_`
};

}  // namespace

namespace {

/// Around a point of a solid's surface: how high other solids rise above the plane across a normal.
class Skyline {
 public:
  Skyline(const Region& own, const Region& others, const Vector3d& normal, double radius)
      : own_(own), others_(others), normal_(normal), radius_(radius) {
    const Vector3d across = normal.unitOrthogonal(), along = normal.cross(across);
    for (int i = 0; i < kAzimuths; ++i) {
      const double angle = 2 * M_PI * i / kAzimuths;
      tangents_[static_cast<std::size_t>(i)] = std::cos(angle) * across + std::sin(angle) * along;
    }
  }

  /// The point along the normal through `point`, within `reach`, at which it leaves the solid: the
  /// highest of those of close lines, because the one through the point may only touch the solid.
  std::optional<Vector3d> SurfaceAt(const Vector3d& point, double reach) const {
    std::optional<Vector3d> highest = SurfaceAlong(point, reach);
    for (std::size_t i = 0; i < tangents_.size(); i += tangents_.size() / 8) {
      const auto other = SurfaceAlong(point + kClose * radius_ * tangents_[i], reach);
      if (other && (!highest || other->dot(normal_) > highest->dot(normal_))) highest = other;
    }
    return highest;
  }

  /// The highest direction in each azimuth that leads from `place` into another solid.
  std::vector<Vector3d> DirectionsAt(const Vector3d& place) const {
    std::vector<Vector3d> directions;
    for (const Vector3d& tangent : tangents_) {
      const auto at = [&](double angle) -> Vector3d {
        return place + radius_ * (std::cos(angle) * tangent + std::sin(angle) * normal_);
      };
      std::optional<double> inside;
      for (int i = kSteps; i > -kSteps && !inside; --i)
        if (others_(at(M_PI / 2 * i / kSteps))) inside = M_PI / 2 * i / kSteps;
      if (!inside) continue;
      const double highest =
          LastIn(others_, at, *inside, std::min(*inside + M_PI / 2 / kSteps, M_PI / 2), kFine);
      directions.push_back((at(highest) - place) / radius_);
    }
    return directions;
  }

  bool IsFree(const std::vector<Vector3d>& directions) const {
    return std::ranges::all_of(
        directions, [&](const Vector3d& direction) { return direction.dot(normal_) <= kFlush; });
  }

  /// Whether the normal is legal there, or at a point beside it on the same face or edge.
  bool IsLegalNear(const Vector3d& place) const {
    if (IsFree(DirectionsAt(place))) return true;
    for (std::size_t i = 0; i < tangents_.size(); i += tangents_.size() / 8) {
      const Vector3d beside = place + 3 * radius_ * tangents_[i];
      const Vector3d up = kFlush * radius_ * normal_;
      if (own_(beside - up) && !own_(beside + up) && IsFree(DirectionsAt(beside))) return true;
    }
    return false;
  }

 private:
  std::optional<Vector3d> SurfaceAlong(const Vector3d& point, double reach) const {
    const auto at = [&](double height) -> Vector3d { return point + height * normal_; };
    std::optional<double> inside;
    for (int i = kSteps; i >= -kSteps && !inside; --i)
      if (own_(at(reach * i / kSteps))) inside = reach * i / kSteps;
    if (!inside || own_(at(*inside + reach))) return std::nullopt;
    return at(LastIn(own_, at, *inside, *inside + reach, kFine * radius_));
  }

  /// The last x, from `inside` on, for which the point `at(x)` is in the region.
  static double LastIn(const Region& region, const auto& at, double inside, double outside,
                       double fineness) {
    while (outside - inside > fineness) {
      const double middle = (inside + outside) / 2;
      (region(at(middle)) ? inside : outside) = middle;
    }
    return inside;
  }

  static constexpr int kAzimuths = 32, kSteps = 8;
  static constexpr double kFine = 1e-3, kClose = 1e-2;
  static constexpr double kFlush = 0.02;  ///< sine of an angle; less does not rise

  const Region &own_, &others_;
  const Vector3d normal_;
  const double radius_;
  std::array<Vector3d, kAzimuths> tangents_;
};

}  // namespace

std::optional<Vector3d> NearestLegalNormal(const Region& own, const Region& others,
                                           const Vector3d& point, const Vector3d& normal,
                                           double reach, double radius) {
  const Skyline skyline(own, others, normal, radius);
  const std::optional<Vector3d> place = skyline.SurfaceAt(point, reach);
  if (!place) return std::nullopt;
  if (skyline.IsLegalNear(*place)) return normal;
  // Onto the cone of the vectors that have no component along any direction into another solid.
  constexpr double kSmall = 0.02;
  const std::vector<Vector3d> directions = skyline.DirectionsAt(*place);
  Vector3d legal = normal;
  for (int i = 0; i < 200; ++i) {
    const Vector3d& steepest = *std::ranges::max_element(
        directions, {}, [&](const Vector3d& direction) { return direction.dot(legal); });
    const double rise = steepest.dot(legal);
    if (rise <= 1e-3) break;
    legal -= rise * steepest;
  }
  return legal.norm() > kSmall ? legal.normalized() : Vector3d::Zero();
}

std::optional<Vector3d> NearestLegalNormal(const objects::Compound& surface, const Vector3d& point,
                                           const Vector3d& normal, double reach) {
  return NormalSearch(surface, point, normal, reach).Run();
}

}  // namespace cdb::exact
