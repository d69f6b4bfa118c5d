// Tiles of SRTM: big-endian words of 16 bits, in cells of 3, 1 or half an arc second.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "library/terrain/height_formats.h"

namespace cdb::terrain {
namespace {

struct Tile {
  std::size_t columns, rows;
};
/// North of 50 degrees, tiles of an arc second have half as many columns.
constexpr Tile kTiles[] = {{1201, 1201}, {3601, 3601}, {1801, 3601}, {7201, 7201}};

/// Of the middle of the tile, by its name, such as `N47E008.hgt`; nullopt for other names.
std::optional<double> LatitudeOf(std::string_view name) {
  const std::string stem = std::filesystem::path(name).stem().string();
  const auto digit = [&](std::size_t i) { return stem[i] - '0'; };
  if (stem.size() < 3 || std::string_view("NSns").find(stem[0]) == std::string_view::npos ||
      digit(1) < 0 || digit(1) > 8 || digit(2) < 0 || digit(2) > 9)
    return std::nullopt;
  const double south = 10 * digit(1) + digit(2);
  return (std::tolower(stem[0]) == 's' ? -south : south) + 0.5;
}

}  // namespace

Raster ReadHgt(std::string_view bytes, std::string_view name) {
  const auto* const tile =
      std::ranges::find(kTiles, bytes.size(), [](const Tile& t) { return 2 * t.columns * t.rows; });
  if (tile == std::end(kTiles))
    RefuseFile(name,
               fmt::format("it has {} bytes, but a tile of SRTM has 2 for each of 1201 by 1201, "
                           "3601 by 3601 or 3601 by 1801 heights",
                           bytes.size()),
               "download it again");
  Raster raster;
  raster.columns = tile->columns;
  raster.rows = tile->rows;
  raster.heights.reserve(bytes.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    const auto word = static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[i]) << 8 |
                                                 static_cast<unsigned char>(bytes[i + 1]));
    const auto height = static_cast<std::int16_t>(word);
    raster.heights.push_back(height == INT16_MIN ? kNoData : height);
  }
  raster.cell = {1.0 / static_cast<double>(tile->columns - 1),
                 1.0 / static_cast<double>(tile->rows - 1)};
  raster.is_in_degrees = true;
  raster.latitude = LatitudeOf(name);
  return raster;
}

}  // namespace cdb::terrain
