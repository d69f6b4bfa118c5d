// The formats of height fields, each as a function from bytes to heights. For height_grid.cc.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "library/scene_error.h"

namespace cdb::terrain {

inline constexpr double kNoData = std::numeric_limits<double>::quiet_NaN();

/// What a file says.
struct Raster {
  std::size_t columns = 0, rows = 0;
  std::vector<double> heights;  ///< row by row; kNoData where there are none
  /// Between columns and rows, in m or degrees.
  std::optional<Eigen::Vector2d> cell = {};
  bool is_in_degrees = false;
  std::optional<double> latitude = {};  ///< degrees, of the middle; for remedies
  std::string unit = {};                ///< why the size of a cell in m is not known otherwise
  bool is_image = false;                ///< whose numbers are grey levels
};

Raster ReadCsv(std::string_view bytes, std::string_view name);
Raster ReadAsciiGrid(std::string_view bytes, std::string_view name);
Raster ReadPng(std::string_view bytes, std::string_view name);
Raster ReadTiff(std::string_view bytes, std::string_view name);
Raster ReadHgt(std::string_view bytes, std::string_view name);

[[noreturn]] void RefuseFile(std::string_view name, const std::string& cause,
                             const std::string& remedy);
[[noreturn]] void RefuseLine(std::string_view name, std::size_t line, const std::string& cause,
                             const std::string& remedy);
/// A remedy with the name of the file, {0}, and without its extension, {1}.
std::string CommandFor(std::string_view remedy, std::string_view name);
/// Throws unless there are from 2 by 2 to kMaxHeights heights.
void CheckSize(std::uint64_t columns, std::uint64_t rows, std::string_view name);

/// The height in a text, or kNoData for `nan`; nullopt if it is no number.
std::optional<double> HeightIn(std::string_view word);

}  // namespace cdb::terrain
