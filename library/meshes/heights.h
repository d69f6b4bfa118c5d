// Height fields: heights over a grid of equal cells, from a CSV file.
//
// A file has a line for each row along z, each with the heights along x, separated by commas; empty
// lines and lines that begin with # are skipped. Errors: SceneError with the file, the line, the
// cause and the remedy. Threads: any.
#pragma once

#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct HeightGrid {
  std::size_t columns = 0, rows = 0;  ///< along x and z; 2 at least
  std::vector<double> heights;        ///< row by row, in the file's own unit
  double cell = 1;                    ///< from one to the next, in the same unit
  bool operator==(const HeightGrid&) const = default;
};

/// `name` stands for the file.
HeightGrid ParseHeights(std::string_view csv, std::string_view name, double cell);

/// Two triangles for each cell, counter-clockwise from above, parted by the diagonal from +z to +x
/// of the cell's corner: those of a btHeightfieldTerrainShape.
Mesh MeshOf(const HeightGrid& grid);

}  // namespace cdb::meshes
