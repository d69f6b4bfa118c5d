// The union of solid cells in closed form, as the truth of voxel ground. Shares no code with
// library/.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace cdb::tests {

/// Cells of side 1, the first with a corner at the origin; x fastest, then y, then z.
struct SolidCells {
  std::array<int, 3> counts;
  std::string bytes;  ///< not 0: solid

  bool IsSolid(int x, int y, int z) const {
    return bytes[static_cast<std::size_t>((z * counts[1] + y) * counts[0] + x)] != 0;
  }
  /// Calls `visit(lower corner)`.
  void ForEach(auto visit) const {
    for (int z = 0; z < counts[2]; ++z)
      for (int y = 0; y < counts[1]; ++y)
        for (int x = 0; x < counts[0]; ++x)
          if (IsSolid(x, y, z)) visit(Eigen::Vector3d(x, y, z));
  }
  /// Of a point; 0 inside.
  double DistanceTo(const Eigen::Vector3d& point) const {
    double least = std::numeric_limits<double>::infinity();
    ForEach([&](const Eigen::Vector3d& lower) {
      const Eigen::Vector3d nearest =
          point.cwiseMax(lower).cwiseMin(lower + Eigen::Vector3d::Ones());
      least = std::min(least, (nearest - point).norm());
    });
    return least;
  }
  /// The largest depth in a cell, negative if there is a gap: of a box with these half sides and
  /// columns of `axes`, by the axes that may separate two boxes.
  double DepthOfBox(const Eigen::Vector3d& centre, const Eigen::Matrix3d& axes,
                    const Eigen::Vector3d& half) const {
    double most = -std::numeric_limits<double>::infinity();
    ForEach([&](const Eigen::Vector3d& lower) {
      const Eigen::Vector3d between = centre - lower - Eigen::Vector3d::Constant(0.5);
      if (between.norm() > half.norm() + 1) return;
      double least = std::numeric_limits<double>::infinity();
      const auto along = [&](Eigen::Vector3d axis) {
        if (axis.norm() < 1e-9) return;
        axis.normalize();
        least = std::min(least, 0.5 * axis.cwiseAbs().sum() +
                                    (axes.transpose() * axis).cwiseAbs().dot(half) -
                                    std::abs(axis.dot(between)));
      };
      for (int i = 0; i < 3; ++i) {
        along(Eigen::Vector3d::Unit(i));
        along(axes.col(i));
        for (int j = 0; j < 3; ++j) along(Eigen::Vector3d::Unit(i).cross(axes.col(j)));
      }
      most = std::max(most, least);
    });
    return most;
  }
};

/// Random cells, many of which touch only along an edge or at a corner, over a floor and beside a
/// block of 4 x 4 x 4.
inline SolidCells MixedCells(unsigned seed) {
  SolidCells cells{{9, 7, 8}, std::string(9 * 7 * 8, '\0')};
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < cells.bytes.size(); ++i) {
    const int x = static_cast<int>(i % 9), y = static_cast<int>(i / 9 % 7),
              z = static_cast<int>(i / 63);
    const bool is_block = x < 4 && y < 4 && z < 4;
    cells.bytes[i] = is_block || y == 0 || random() % 4 == 0;
  }
  return cells;
}

}  // namespace cdb::tests
