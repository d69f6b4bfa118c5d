// Grids of cells that are solid or empty, and the closed surface of the solid ones.
//
// Files, by the extension of the name: bytes (.raw), .binvox, arrays of NumPy (.npy), and clouds of
// points (.ply, .pcd), of which a cell is solid if enough points lie in it. Coordinates in m, those
// of the file, or turned so that y is up.
// Errors: SceneError with the file, the cause and the remedy. Threads: any.
// Sources: P. Min, binvox voxel file format; NEP 1, A Simple File Format for NumPy Arrays; Point
// Cloud Library, The PCD file format, 0.7; A. Hornung et al., OctoMap, Autonomous Robots 34, 2013,
// for occupancy.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::terrain {

using Cell = std::array<std::int64_t, 3>;  ///< numbers along x, y and z

struct VoxelGrid {
  Cell counts = {};                                 ///< cells along each axis; at least 1
  std::vector<bool> solid;                          ///< x fastest, then y, then z
  Eigen::Vector3d lower = Eigen::Vector3d::Zero();  ///< m: the corner of the first cell
  double cell = 1;                                  ///< m

  bool IsSolid(const Cell& at) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (at[i] < 0 || at[i] >= counts[i]) return false;
    return solid[static_cast<std::size_t>((at[2] * counts[1] + at[1]) * counts[0] + at[0])];
  }
  /// Whether a point is in a solid cell.
  bool Contains(const Eigen::Vector3d& point) const;
  std::size_t SolidCount() const;
};

struct VoxelOptions {
  bool is_z_up = false;  ///< turns (x, y, z) of the file to (x, z, -y)
  /// m; otherwise that of the file.
  std::optional<double> cell = {};
  /// Of a .raw file, along its x, y and z.
  std::array<std::optional<std::uint64_t>, 3> counts = {};
  /// The least value, or number of points, of a solid cell.
  std::uint64_t threshold = 1;
};

/// Larger grids are rejected. So many cells take 32 MB.
inline constexpr std::uint64_t kMaxCells = std::uint64_t{1} << 28;

/// `name` is the name of the file, which determines its format, and is for messages. At least one
/// cell is solid.
VoxelGrid ParseVoxels(std::string_view bytes, std::string_view name,
                      const VoxelOptions& options = {});

/// The faces of solid cells beside empty ones, each of two triangles, counter-clockwise from
/// outside, in the order of their cells. Cells beyond the grid are empty. Faces do not share
/// vertices, but these agree to the last bit. Rejects more than `most` triangles.
meshes::Mesh SurfaceOf(const VoxelGrid& grid, std::string_view name, std::size_t most);

}  // namespace cdb::terrain
