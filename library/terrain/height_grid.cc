#include "library/terrain/height_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <utility>

#include "compiler/plan/foreign_model.h"
#include "library/terrain/height_formats.h"

namespace cdb::terrain {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Larger heights are rejected, as their squares would overflow in single precision.
constexpr double kLargestHeight = 1e15;

struct Format {
  std::string_view extension, other_extension;
  Raster (*read)(std::string_view bytes, std::string_view name);
};
constexpr Format kFormats[] = {{".csv", "", ReadCsv},
                               {".asc", "", ReadAsciiGrid},
                               {".png", "", ReadPng},
                               {".tif", ".tiff", ReadTiff},
                               {".hgt", "", ReadHgt}};

Raster Read(std::string_view bytes, std::string_view name) {
  std::string extension = std::filesystem::path(name).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  try {
    const auto* const format = std::ranges::find_if(kFormats, [&](const Format& row) {
      return row.extension == extension || row.other_extension == extension;
    });
    if (extension.empty() || format == std::end(kFormats))
      RefuseFile(name, "unknown format", "its name ends in .csv, .asc, .png, .tif or .hgt");
    return format->read(bytes, name);
  } catch (const library::SceneError&) {
    const auto [kind, remedy] = plan::ForeignHeightsOf(name, bytes);
    if (kind.empty()) throw;
    RefuseFile(name, fmt::format("is {}", kind), remedy);
  }
}

/// The numbers that mark missing heights by custom; real ones are never so low or so large.
bool IsMissing(double height) {
  constexpr double kMarks[] = {-9999, -99999, -32767, -32768};
  return std::isnan(height) || std::abs(height) > kLargestHeight ||
         std::ranges::find(kMarks, height) != std::end(kMarks);
}

void FillMissing(Raster& raster, std::string_view name, const HeightOptions& options) {
  std::vector<double>& heights = raster.heights;
  const auto missing = static_cast<std::size_t>(std::ranges::count_if(heights, IsMissing));
  if (missing == 0) return;
  if (missing == heights.size()) RefuseFile(name, "no height has data", "name another file");
  const auto first =
      static_cast<std::size_t>(std::ranges::find_if(heights, IsMissing) - heights.begin());
  if (std::holds_alternative<HeightOptions::Refuse>(options.no_data))
    RefuseFile(
        name,
        fmt::format("{} of {} heights {} no data, the first in row {}, column {}{}", missing,
                    heights.size(), missing == 1 ? "has" : "have", first / raster.columns + 1,
                    first % raster.columns + 1,
                    std::isnan(heights[first]) ? "" : fmt::format(" ({:g})", heights[first])),
        "`no_data: lowest` fills them with the lowest height, `no_data: 0` with this one");
  double fill = std::numeric_limits<double>::infinity();
  if (const double* given = std::get_if<double>(&options.no_data)) {
    fill = *given;
  } else {
    for (const double height : heights)
      if (!IsMissing(height)) fill = std::min(fill, height);
  }
  std::ranges::replace_if(heights, IsMissing, fill);
}

/// Of a cell in degrees, m: about, on a sphere as large as the earth.
Vector2d MetresOf(const Vector2d& degrees, double latitude) {
  constexpr double kDegree = 6371009 * std::numbers::pi / 180;
  const double shrink = std::cos(std::clamp(latitude, -89.0, 89.0) * std::numbers::pi / 180);
  return {degrees.x() * kDegree * shrink, degrees.y() * kDegree};
}

void FindScale(const Raster& raster, std::string_view name, HeightGrid& grid) {
  constexpr std::string_view kOr =
      "or set the sides by `size` and an `aspect` other than 1 : 1 : 1";
  if (raster.is_in_degrees) {
    const Vector2d metres = MetresOf(*raster.cell, raster.latitude.value_or(0));
    grid.unknown_scale = fmt::format("{}: its cells are {:.4g} by {:.4g} degrees, not metres", name,
                                     raster.cell->x(), raster.cell->y());
    grid.scale_remedy =
        raster.latitude
            ? fmt::format(
                  "`scale: ({:.4g}, 1, {:.4g})` is about their size at latitude {:.3g}; or "
                  "project the file to metres by `gdalwarp -t_srs`",
                  metres.x(), metres.y(), *raster.latitude)
            : "give their size in m: `scale: (x, 1, z)`; or project the file by `gdalwarp -t_srs`";
  } else if (!raster.unit.empty()) {
    grid.unknown_scale = fmt::format("{}: {}", name, raster.unit);
    grid.scale_remedy =
        fmt::format("give the size of a cell in m, `scale: (x, height, z)`; {}", kOr);
  } else if (raster.is_image) {
    grid.unknown_scale =
        fmt::format("{}: an image does not say how large its pixels and grey levels are", name);
    const double most = *std::ranges::max_element(raster.heights) > 255 ? 65535 : 255;
    grid.scale_remedy = fmt::format(
        "give the size of a pixel and of a grey level in m, such as `scale: (2, 300 / {:g}, 2)`; "
        "{}",
        most, kOr);
  } else if (raster.cell) {
    grid.scale = {raster.cell->x(), 1, raster.cell->y()};
  }
}

}  // namespace

void RefuseFile(std::string_view name, const std::string& cause, const std::string& remedy) {
  throw library::SceneError(fmt::format("{}: {}", name, cause), remedy);
}

void RefuseLine(std::string_view name, std::size_t line, const std::string& cause,
                const std::string& remedy) {
  throw library::SceneError(fmt::format("{}:{}: {}", name, line, cause), remedy);
}

std::string CommandFor(std::string_view remedy, std::string_view name) {
  const std::filesystem::path path(name);
  return fmt::format(fmt::runtime(remedy), path.filename().string(), path.stem().string());
}

void CheckSize(std::uint64_t columns, std::uint64_t rows, std::string_view name) {
  if (columns < 2 || rows < 2)
    RefuseFile(name, fmt::format("it has {} by {} heights", rows, columns),
               "a height field needs at least 2 by 2");
  if (columns > kMaxHeights / rows)
    RefuseFile(
        name, fmt::format("it has {} by {} heights; the limit is {}", rows, columns, kMaxHeights),
        CommandFor("take fewer: `gdal_translate -r average -outsize 50% 50% {0} {1}_half.tif`",
                   name));
}

std::optional<double> HeightIn(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  if (word.starts_with('+')) return std::nullopt;
  double height = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, height);
  // Too small, which is 0, or too large.
  if (error == std::errc::result_out_of_range && stop == end)
    return std::strtod(std::string(word).c_str(), nullptr);
  if (error != std::errc() || stop != end) return std::nullopt;
  return height;
}

HeightGrid ParseHeights(std::string_view bytes, std::string_view name,
                        const HeightOptions& options) {
  Raster raster = Read(bytes, name);
  CheckSize(raster.columns, raster.rows, name);
  FillMissing(raster, name, options);
  HeightGrid grid;
  grid.columns = raster.columns;
  grid.rows = raster.rows;
  if (options.scale) {
    grid.scale = *options.scale;
  } else {
    FindScale(raster, name, grid);
  }
  grid.heights = std::move(raster.heights);
  return grid;
}

}  // namespace cdb::terrain
