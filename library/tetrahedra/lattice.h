// A body-centred cubic lattice around a mesh, and where the surface of the mesh crosses its edges.
//
// The lattice is two cubic grids, each with its corners in the middles of the cells of the other.
// Its points have integer coordinates of half a cell, all even or all odd. Long edges join
// neighbours of one grid, short ones neighbours of both. Lengths in the unit of the mesh, u.
// Errors: none; the mesh must be closed. Threads: any.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::tetrahedra {

using Point = Eigen::Vector3i;

class Lattice {
 public:
  /// `cells`, at least 2: along the longest side of the box around the mesh. Whole cells, and one
  /// more at each side, are about the middle of the box.
  Lattice(const meshes::Mesh& mesh, std::size_t cells);

  double cell() const { return cell_; }
  const Point& size() const { return size_; }  ///< the coordinates of a point are less
  std::size_t IndexCount() const { return static_cast<std::size_t>(size_.prod()); }
  std::size_t IndexOf(const Point& point) const {
    return (static_cast<std::size_t>(point.y()) * static_cast<std::size_t>(size_.z()) +
            static_cast<std::size_t>(point.z())) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(point.x());
  }
  bool Has(const Point& point) const {
    return (point.array() >= 0).all() && (point.array() < size_.array()).all();
  }
  Eigen::Vector3d PlaceOf(const Point& point) const {
    return corner_ + cell_ / 2 * point.cast<double>();
  }
  /// In coordinates of points, which need not be whole.
  Eigen::Vector3d CoordinatesOf(const Eigen::Vector3d& place) const {
    return (place - corner_) * (2 / cell_);
  }

  /// Along x, then z, then y.
  template <typename Visit>
  void ForEachPoint(const Visit& visit) const {
    for (int y = 0; y < size_.y(); ++y)
      for (int z = y % 2; z < size_.z(); z += 2)
        for (int x = y % 2; x < size_.x(); x += 2) visit(Point(x, y, z));
  }

  /// From a point to its 14 neighbours; the first seven are the opposites of the others.
  static std::span<const Point> Steps();
  /// True for the step between two points of one grid.
  static bool IsLong(const Point& step) { return step.x() % 2 == 0; }

 private:
  double cell_;
  Eigen::Vector3d corner_;
  Point size_;
};

/// Which points are inside, and where edges cross the surface.
class Crossings {
 public:
  Crossings(const Lattice& lattice, const meshes::Mesh& mesh);

  /// 1 inside, -1 outside, 0 on the surface.
  int SignOf(const Point& point) const { return sign_[lattice_.IndexOf(point)]; }
  /// Of a corner that moves there.
  void PutOnSurface(const Point& point) { sign_[lattice_.IndexOf(point)] = 0; }
  /// The part of the edge between two points, one inside and one outside, from the first to the
  /// crossing closest to the one inside.
  double CutFrom(const Point& from, const Point& to) const;

 private:
  struct Cut {
    double first, last;  ///< from the point at which the edge starts
  };

  bool FindInside(const meshes::Mesh& mesh, double aside);
  void FindCuts(const meshes::Mesh& mesh);
  void CutBy(const std::array<Eigen::Vector3d, 3>& triangle);
  std::uint64_t KeyOf(const Point& point, std::size_t step) const {
    return std::uint64_t{lattice_.IndexOf(point)} * 7 + step;
  }

  const Lattice& lattice_;
  std::vector<std::int8_t> sign_;
  std::unordered_map<std::uint64_t, Cut> cuts_;
};

}  // namespace cdb::tetrahedra
