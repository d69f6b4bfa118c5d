#include "library/meshes/heights.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "dsl/text/utf8.h"
#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

std::string_view WithoutBlanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

[[noreturn]] void RefuseHeights(std::string_view name, std::size_t line, const std::string& cause,
                                const std::string& remedy) {
  throw library::SceneError(fmt::format("{}:{}: {}", name, line, cause), remedy);
}

double HeightOf(std::string_view cell, std::string_view name, std::size_t line) {
  const std::string_view digits = cell.starts_with('+') ? cell.substr(1) : cell;
  double height = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), height);
  if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(height) ||
      std::abs(height) > kLargestCoordinate)
    RefuseHeights(name, line, fmt::format("`{}` is not a height", text::Printable(cell)),
                  "write numbers, separated by commas");
  return height;
}

}  // namespace

HeightGrid ParseHeights(std::string_view csv, std::string_view name, double cell) {
  HeightGrid grid;
  grid.cell = cell;
  if (csv.starts_with("\xEF\xBB\xBF")) csv.remove_prefix(3);
  for (std::size_t number = 1; !csv.empty(); ++number) {
    const std::size_t end = std::min(csv.find('\n'), csv.size());
    std::string_view line = WithoutBlanks(csv.substr(0, end));
    csv.remove_prefix(std::min(end + 1, csv.size()));
    if (line.empty() || line.front() == '#') continue;
    const std::size_t before = grid.heights.size();
    for (std::size_t comma = 0; comma != line.npos;) {
      comma = line.find(',');
      grid.heights.push_back(HeightOf(WithoutBlanks(line.substr(0, comma)), name, number));
      line.remove_prefix(std::min(comma, line.size() - 1) + 1);
    }
    const std::size_t columns = grid.heights.size() - before;
    if (grid.rows == 0) grid.columns = columns;
    if (columns != grid.columns)
      RefuseHeights(
          name, number,
          fmt::format("{} heights in this row, but {} in the first", columns, grid.columns),
          "write as many in each row");
    ++grid.rows;
  }
  if (grid.rows < 2 || grid.columns < 2)
    throw library::SceneError(
        fmt::format("{}: it has {} by {} heights", name, grid.rows, grid.columns),
        "a height field needs at least 2 by 2");
  return grid;
}

Mesh MeshOf(const HeightGrid& grid) {
  Mesh mesh;
  for (std::size_t z = 0; z < grid.rows; ++z)
    for (std::size_t x = 0; x < grid.columns; ++x)
      mesh.vertices.emplace_back(grid.cell * static_cast<double>(x),
                                 grid.heights[z * grid.columns + x],
                                 grid.cell * static_cast<double>(z));
  for (std::size_t z = 0; z + 1 < grid.rows; ++z)
    for (std::size_t x = 0; x + 1 < grid.columns; ++x) {
      const auto a = static_cast<std::uint32_t>(z * grid.columns + x);
      const auto b = a + static_cast<std::uint32_t>(grid.columns);
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  return mesh;
}

}  // namespace cdb::meshes
