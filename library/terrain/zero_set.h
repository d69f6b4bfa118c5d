// Ground by formulae: the heights of a function of x and z, and the zero set of one of x, y and z
// as triangles, with the distance from the formula that was measured.
//
// The zero set is the boundary of where the function is negative. It is meshed by dual contouring:
// one vertex for each cell of a grid that the boundary passes, so that edges and corners stay
// sharp, and a quadrilateral for each edge of the grid whose ends have different signs. Cells
// without thickness close the grid, so that the mesh ends at the sides of the box. What is thinner
// than a cell may be missed. Source: Ju, Losasso, Schaefer, Warren, Dual Contouring of Hermite
// Data, SIGGRAPH 2002. Lengths in m. Errors: SceneError. Threads: any, with functions of their own.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <functional>

#include "library/meshes/mesh.h"
#include "library/terrain/height_grid.h"

namespace cdb::terrain {

using Function = std::function<double(const Eigen::Vector3d&)>;

/// More points of a grid are refused.
inline constexpr std::size_t kMaxGridPoints = std::size_t{1} << 23;

/// How far the triangles are from the formula.
struct Deviation {
  double most = 0;         ///< m; of the points compared
  std::size_t points = 0;  ///< evenly over triangles; of the largest grids, over a part of them
};

/// The heights of `function`, which ignores y, over a rectangle about the origin. The distance
/// between heights is at most `cell`. Deviations are vertical.
HeightGrid HeightsOf(const Function& function, double width, double depth, double cell,
                     Deviation& deviation);

/// Deviations are along the normals of the triangles, to the next change of sign, or a cell's
/// diagonal if there is none.
meshes::Mesh ZeroSetOf(const Function& function, const Eigen::AlignedBox3d& box, double cell,
                       Deviation& deviation);

}  // namespace cdb::terrain
