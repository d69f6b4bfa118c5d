// The volume of the intersection of two solids, and the rays that measure it.
//
// Measured along a square grid of rays, kRays in each direction, over the box around both: the
// lengths inside along a ray are exact; across the rays, the midpoint rule is of second order. A
// point is inside a solid if the winding number of the surface is at least 1, so that overlapping
// parts of a mesh count once. Lengths in the unit of the meshes, u; volumes u^3.
// Errors: none; both meshes must be closed. Threads: any. Deterministic.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct OverlapVolume {
  double first = 0, second = 0;  ///< of each separately
  double common = 0;
  double second_in_all = 0;  ///< of the second, where overlapping parts count several times
  /// 1 if the solids are equal.
  double IntersectionOverUnion() const { return common / (first + second - common); }
};

/// Along the longest axis of the box, so that the rays are close.
OverlapVolume OverlapVolumeOf(const Mesh& first, const Mesh& second);

inline constexpr int kRays = 256;

/// Rays along one axis, through the middles of the cells of a grid in the plane of the other two.
class Rays {
 public:
  struct Crossing {
    std::uint32_t ray;
    std::uint32_t label;  ///< of the triangle
    std::int8_t turns;    ///< 1 into the surface, -1 out of it
    double at;            ///< along the ray
  };

  explicit Rays(const Eigen::AlignedBox3d& box);

  double CellArea() const { return step_.prod(); }
  /// A point of a ray.
  Eigen::Vector3d PointAt(std::uint32_t ray, double at) const;
  /// Adds all crossings with a closed mesh, unordered. `labels`: by triangle.
  void Cast(const Mesh& mesh, std::span<const std::uint32_t> labels,
            std::vector<Crossing>& crossings) const;
  /// By ray, and along it.
  static void Sort(std::vector<Crossing>& crossings);

 private:
  struct Hit {
    std::int8_t turns;
    double at;
  };

  Eigen::Vector2d Flat(const Eigen::Vector3d& p) const {
    return {p[(along_ + 1) % 3], p[(along_ + 2) % 3]};
  }
  Eigen::Vector2d RayAt(int u, int v) const {
    return low_ + step_.cwiseProduct(Eigen::Vector2d(u + 0.5, v + 0.5));
  }
  int CellFrom(double coordinate, int axis, bool is_end) const;
  double Side(const Mesh& mesh, std::uint32_t from, std::uint32_t to,
              const Eigen::Vector2d& ray) const;
  std::optional<Hit> Cross(const Mesh& mesh, const Triangle& t, const Eigen::Vector2d& ray) const;
  void CastAside(const Mesh& mesh, std::span<const std::uint32_t> labels, std::uint32_t ray,
                 std::size_t begin, std::vector<Crossing>& crossings) const;

  int along_ = 0;
  Eigen::Vector2d low_, step_;
};

}  // namespace cdb::meshes
