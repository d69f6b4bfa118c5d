// The formats of grids of cells and of point clouds, each as a function from bytes to a grid
// along the axes of the file. For voxel_grid.cc.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "library/terrain/voxel_grid.h"

namespace cdb::terrain {

VoxelGrid ReadRaw(std::string_view bytes, std::string_view name, const VoxelOptions& options);
VoxelGrid ReadBinvox(std::string_view bytes, std::string_view name, const VoxelOptions& options);
VoxelGrid ReadNpy(std::string_view bytes, std::string_view name, const VoxelOptions& options);
VoxelGrid ReadPlyPoints(std::string_view bytes, std::string_view name, const VoxelOptions& options);
VoxelGrid ReadPcd(std::string_view bytes, std::string_view name, const VoxelOptions& options);

/// The points of a .pcd file, in m.
std::vector<Eigen::Vector3d> PointsOfPcd(std::string_view bytes, std::string_view name);
/// The cells in which enough points lie; their corners are at multiples of the cell.
VoxelGrid GridOf(const std::vector<Eigen::Vector3d>& points, std::string_view name,
                 const VoxelOptions& options);

/// The side of a cell, for files that do not state it.
double GivenCell(std::string_view name, const VoxelOptions& options);
/// An empty grid of so many cells; throws if there are none or too many.
VoxelGrid EmptyGrid(const std::array<std::uint64_t, 3>& counts, std::string_view name);

}  // namespace cdb::terrain
