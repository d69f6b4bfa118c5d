// Height fields: heights over a grid of equal cells.
//
// Files: CSV, ESRI ASCII grid (.asc), PNG, GeoTIFF (.tif) and SRTM (.hgt), by the extension of the
// name. Columns run along x and rows along z, in the order of the file: in a map, east is +x and
// north is -z. A height takes 8 bytes.
// Errors: SceneError with the file, the line or byte, the cause and the remedy. Threads: any.
// Sources: ESRI ASCII raster format (ArcGIS); PNG, ISO/IEC 15948; TIFF 6.0; OGC GeoTIFF 1.1; SRTM,
// "SRTM Topography" (USGS, 2015).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace cdb::terrain {

struct HeightGrid {
  std::size_t columns = 0, rows = 0;  ///< along x and z; at least 2
  std::vector<double> heights;        ///< row by row, in the unit of the file; finite
  /// m: between columns, of one unit of height, and between rows.
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  /// Why the scale is not known, and the remedy. Empty if it is.
  std::string unknown_scale = {}, scale_remedy = {};

  std::size_t cells() const { return (columns - 1) * (rows - 1); }
  bool operator==(const HeightGrid&) const = default;
};

struct HeightOptions {
  /// m; otherwise that of the file, or 1 where it has none.
  std::optional<Eigen::Vector3d> scale = {};
  struct Refuse {};
  struct Lowest {};
  /// For heights without data: an error, the lowest height of the file, or this height, in its
  /// unit.
  std::variant<Refuse, Lowest, double> no_data = Refuse();
};

/// More heights are rejected. In a run of double precision, so many take 1 GB.
inline constexpr std::size_t kMaxHeights = std::size_t{1} << 26;

/// `name` is the name of the file, which determines its format, and is for messages.
HeightGrid ParseHeights(std::string_view bytes, std::string_view name,
                        const HeightOptions& options = {});

}  // namespace cdb::terrain
