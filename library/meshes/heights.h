// Height fields: heights over a grid of equal cells, from a CSV file.
//
// A file has one line for each row along z, with the heights along x, separated by commas; empty
// lines and lines that begin with # are skipped. Errors: SceneError with the file, the line, the
// cause and the remedy. Threads: any.
#pragma once

#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct HeightGrid {
  std::size_t columns = 0, rows = 0;  ///< along x and z; at least 2
  std::vector<double> heights;        ///< row by row, in the unit of the file
  double cell = 1;                    ///< spacing, in the same unit
  bool operator==(const HeightGrid&) const = default;
};

/// `name` is the name of the file, for messages.
HeightGrid ParseHeights(std::string_view csv, std::string_view name, double cell);

/// Two triangles for each cell, counter-clockwise from above, divided by the diagonal from +z to +x
/// of the cell's corner: those of a btHeightfieldTerrainShape.
Mesh MeshOf(const HeightGrid& grid);

}  // namespace cdb::meshes
