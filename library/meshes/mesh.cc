#include "library/meshes/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "compiler/plan/foreign_model.h"
#include "compiler/plan/gltf_buffers.h"
#include "compiler/plan/input_file.h"
#include "library/meshes/cut.h"
#include "library/meshes/import.h"
#include "library/meshes/mesh_formats.h"
#include "library/meshes/polygon.h"
#include "library/scene_error.h"

namespace cdb::meshes {

void Refuse(std::string_view name, Place place, std::string_view what) {
  throw library::SceneError(place.unit == Place::Unit::kLine
                                ? fmt::format("{}:{}: {}", name, place.number, what)
                                : fmt::format("{}: byte {}: {}", name, place.number, what));
}

void CheckCoordinates(const Eigen::Vector3d& vertex, std::string_view name, Place place) {
  for (const double coordinate : vertex)
    if (!(std::abs(coordinate) <= kLargestCoordinate))
      Refuse(name, place,
             fmt::format("the coordinate {} is not a number up to {:g}; export the model again, or "
                         "in a larger unit",
                         coordinate, kLargestCoordinate));
}

double Number(std::string_view word, std::string_view name, Place place) {
  std::string_view digits = word;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  // Not a value for numbers that are too small as well as for those that are too large.
  if (error == std::errc::result_out_of_range)
    value = std::strtod(std::string(digits).c_str(), nullptr);
  if (error == std::errc::invalid_argument || end != digits.data() + digits.size() ||
      !std::isfinite(value))
    Refuse(name, place, fmt::format("`{}` should be a number", word));
  return value;
}

std::int64_t Integer(std::string_view word, std::string_view name, Place place) {
  std::string_view digits = word;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size())
    Refuse(name, place, fmt::format("`{}` should be a whole number", word));
  return value;
}

void AddVertex(const Eigen::Vector3d& vertex, Mesh& mesh, std::string_view name, Place place) {
  CheckCoordinates(vertex, name, place);
  if (mesh.vertices.size() >= kMaxVertices)
    Refuse(name, place,
           fmt::format("more than {} vertices; simplify the model first", kMaxVertices));
  mesh.vertices.push_back(vertex);
}

void CheckTriangles(std::size_t count, std::string_view name, Place place) {
  if (count > kMaxTriangles)
    Refuse(name, place,
           fmt::format("more than {} triangles; simplify the model first", kMaxTriangles));
}

void PolygonList::Add(std::span<const std::uint32_t> corners, Place place) {
  if (corners.size() < 3)
    Refuse(name_, place, fmt::format("a face needs 3 corners or more, not {}", corners.size()));
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  ends_.push_back(corners_.size());
  places_.push_back(place.number);
  CheckTriangles(corners_.size() - 2 * ends_.size(), name_, place);
}

void PolygonList::AddTo(Mesh& mesh) const {
  mesh.triangles.reserve(corners_.size() - 2 * ends_.size());
  for (std::size_t i = 0, begin = 0; i < ends_.size(); begin = ends_[i++]) {
    const auto corners = std::span(corners_).subspan(begin, ends_[i] - begin);
    const Place place{unit_, places_[i]};
    for (const std::uint32_t corner : corners)
      if (corner >= mesh.vertices.size())
        Refuse(name_, place,
               fmt::format("a face has vertex {}, counted from {}, but there are {}",
                           std::uint64_t{corner} + first_, first_, mesh.vertices.size()));
    if (corners.size() > kMaxCorners && !IsFan(corners, mesh.vertices))
      Refuse(name_, place,
             fmt::format("a face that is not convex has {} corners, more than {}; triangulate the "
                         "model first",
                         corners.size(), kMaxCorners));
    Triangulate(corners, mesh.vertices, mesh.triangles);
  }
}

bool Lines::Next() {
  if (offset_ >= text_.size()) return false;
  const std::size_t end = std::min(text_.find_first_of("\r\n", offset_), text_.size());
  line_ = text_.substr(offset_, end - offset_);
  offset_ = std::min(end + (text_.substr(end, 2) == "\r\n" ? 2 : 1), text_.size());
  ++number_;
  return true;
}

void SplitWords(std::string_view line, std::vector<std::string_view>& words) {
  constexpr std::string_view kBlank = " \t\v\f";
  words.clear();
  line = line.substr(0, line.find('#'));
  for (std::size_t begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlank, end);
  }
}

std::string_view WithoutMark(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  return text;
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

namespace {

Mesh ParseImported(std::string_view bytes, std::string_view name) {
  const Mesh mesh = ImportMesh(bytes, name);
  Mesh merged = MergeEqualVertices(mesh);
  merged.left_out = mesh.left_out;
  return merged;
}

Mesh ParseFormat(const std::string& extension, std::string_view bytes, std::string_view name) {
  if (extension == ".obj") return ParseObj(bytes, name);
  if (extension == ".off") return ParseOff(bytes, name);
  if (extension == ".ply") return ParsePly(bytes, name);
  if (extension == ".stl") return MergeEqualVertices(ParseStl(bytes, name));
  if (!plan::ImporterOf(extension).empty()) return ParseImported(bytes, name);
  throw library::SceneError(fmt::format(
      "{}: unknown format; the name of a model ends in .obj, .ply, .stl or .off", name));
}

}  // namespace

Mesh ParseMesh(std::string_view bytes, std::string_view name) {
  try {
    Mesh mesh =
        ParseFormat(LowerCase(std::filesystem::path(name).extension().string()), bytes, name);
    if (mesh.vertices.empty())
      throw library::SceneError(fmt::format("{}: has no faces and no vertices", name));
    return mesh;
  } catch (const library::SceneError&) {
    const auto [kind, remedy] = plan::ForeignModelOf(name, bytes);
    if (kind.empty()) throw;
    throw library::SceneError(fmt::format("{}: is {}", name, kind), remedy);
  }
}

Mesh ReadMesh(const std::filesystem::path& file) {
  return ParseMesh(ReadMeshFile(file), file.string());
}

std::string ReadMeshFile(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw library::SceneError(fmt::format("{}: there is no such file", name));
  if (!std::filesystem::is_regular_file(file, error))
    throw library::SceneError(fmt::format("{}: is not a file", name));
  std::string why;
  const auto read = [](const std::string& path, std::string& reason) {
    return plan::ReadInputFile(path, reason, kMaxFileBytes);
  };
  auto bytes = read(name, why);
  if (bytes) bytes = plan::WithGltfBuffers(name, *std::move(bytes), read, kMaxFileBytes, why);
  if (!bytes) throw library::SceneError(fmt::format("{}: {}", name, why));
  return std::move(*bytes);
}

namespace {

/// `first`: by vertex, the first of those that are merged with it.
Mesh Merged(const Mesh& mesh, std::span<const std::uint32_t> first) {
  Mesh merged;
  std::vector<std::uint32_t> number(first.size());
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    if (first[i] == i) {
      number[i] = static_cast<std::uint32_t>(merged.vertices.size());
      merged.vertices.push_back(mesh.vertices[i]);
    } else {
      number[i] = number[first[i]];
    }
  }
  for (const Triangle& t : mesh.triangles) {
    const Triangle next{number[t[0]], number[t[1]], number[t[2]]};
    if (next[0] != next[1] && next[1] != next[2] && next[2] != next[0])
      merged.triangles.push_back(next);
  }
  return merged;
}

}  // namespace

Mesh MergeEqualVertices(const Mesh& mesh) {
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    return std::lexicographical_compare(mesh.vertices[a].begin(), mesh.vertices[a].end(),
                                        mesh.vertices[b].begin(), mesh.vertices[b].end());
  };
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), less);
  // The first of several equal vertices represents all.
  std::vector<std::uint32_t> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && !less(order[i - 1], order[i]) ? first[order[i - 1]] : order[i];
  return Merged(mesh, first);
}

Mesh MergeCloseVertices(const Mesh& mesh, std::span<const std::uint32_t> vertices,
                        double distance) {
  std::vector<std::uint32_t> first(mesh.vertices.size());
  std::iota(first.begin(), first.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  // Vertices that are closer than half the side of a cell share one in at least one of these grids.
  for (int shift = 0; shift < 8 && distance > 0; ++shift) {
    std::vector<std::pair<std::array<double, 3>, std::uint32_t>> cells;
    for (const std::uint32_t i : vertices) {
      std::array<double, 3> cell;
      for (int axis = 0; axis < 3; ++axis)
        cell[static_cast<std::size_t>(axis)] =
            std::floor(mesh.vertices[i][axis] / (2 * distance) + (shift >> axis & 1) * 0.5);
      cells.emplace_back(cell, i);
    }
    std::ranges::sort(cells);
    for (std::size_t i = 1; i < cells.size(); ++i) {
      if (cells[i].first != cells[i - 1].first) continue;
      const std::uint32_t a = root(cells[i].second), b = root(cells[i - 1].second);
      first[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::uint32_t i = 0; i < first.size(); ++i) first[i] = root(i);
  return Merged(mesh, first);
}

Mesh SubMesh(const Mesh& mesh, std::span<const Triangle> triangles) {
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNoVertex);
  for (const Triangle& t : triangles)
    for (const std::uint32_t vertex : t) number[vertex] = 0;
  Mesh part;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == kNoVertex) continue;
    number[i] = static_cast<std::uint32_t>(part.vertices.size());
    part.vertices.push_back(mesh.vertices[i]);
  }
  for (const Triangle& t : triangles)
    part.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  return part;
}

std::vector<std::uint32_t> ConnectedParts(const Mesh& mesh) {
  UnionFind connected(mesh.vertices.size());
  for (const Triangle& triangle : mesh.triangles) {
    connected.Join(triangle[0], triangle[1]);
    connected.Join(triangle[0], triangle[2]);
  }
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNoVertex), parts;
  std::uint32_t count = 0;
  for (const Triangle& triangle : mesh.triangles) {
    std::uint32_t& part = number[connected.Root(triangle[0])];
    if (part == kNoVertex) part = count++;
    parts.push_back(part);
  }
  return parts;
}

std::vector<Mesh> ParseParts(std::string_view bytes, std::string_view name, std::size_t most) {
  const auto check = [&](std::size_t count) {
    if (count > most)
      throw library::SceneError(
          fmt::format("{}: has {} parts; at most {} can be taken as they are", name, count, most));
  };
  // Also checks that it is a mesh of this format.
  const Mesh mesh = ParseMesh(bytes, name);
  if (LowerCase(std::filesystem::path(name).extension().string()) == ".obj") {
    std::vector<Mesh> groups = ParseObjGroups(bytes, name);
    check(groups.size());
    if (groups.size() > 1) return groups;
  }
  const std::vector<std::uint32_t> numbers = ConnectedParts(mesh);
  std::vector<std::vector<Triangle>> triangles;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] == triangles.size()) triangles.emplace_back();
    triangles[numbers[i]].push_back(mesh.triangles[i]);
  }
  check(triangles.size());
  std::vector<Mesh> parts;
  for (const std::vector<Triangle>& part : triangles) parts.push_back(SubMesh(mesh, part));
  return parts;
}

}  // namespace cdb::meshes
