#include "library/meshes/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numeric>
#include <utility>

#include "compiler/plan/input_file.h"
#include "library/meshes/mesh_formats.h"
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
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
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

void AddPolygon(std::span<const std::uint32_t> corners, std::size_t vertices, Mesh& mesh,
                std::string_view name, Place place, std::uint32_t first) {
  if (corners.size() < 3)
    Refuse(name, place, fmt::format("a face needs 3 corners or more, not {}", corners.size()));
  for (const std::uint32_t corner : corners)
    if (corner >= vertices)
      Refuse(name, place,
             fmt::format("a face has vertex {}, counted from {}, but there are {}",
                         std::uint64_t{corner} + first, first, vertices));
  if (mesh.triangles.size() + corners.size() - 2 > kMaxTriangles)
    Refuse(name, place,
           fmt::format("more than {} triangles; simplify the model first", kMaxTriangles));
  for (std::size_t i = 2; i < corners.size(); ++i)
    mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
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

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

Mesh ParseMesh(std::string_view bytes, std::string_view name) {
  const std::string extension = LowerCase(std::filesystem::path(name).extension().string());
  Mesh mesh;
  if (extension == ".obj")
    mesh = ParseObj(bytes, name);
  else if (extension == ".off")
    mesh = ParseOff(bytes, name);
  else if (extension == ".ply")
    mesh = ParsePly(bytes, name);
  else if (extension == ".stl")
    mesh = MergeEqualVertices(ParseStl(bytes, name));
  else
    throw library::SceneError(fmt::format(
        "{}: unknown format; the name of a model ends in .obj, .ply, .stl or .off", name));
  if (mesh.triangles.empty()) throw library::SceneError(fmt::format("{}: has no faces", name));
  return mesh;
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
  auto bytes = plan::ReadInputFile(file, why, kMaxFileBytes);
  if (!bytes) throw library::SceneError(fmt::format("{}: {}", name, why));
  return std::move(*bytes);
}

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
  Mesh merged;
  std::vector<std::uint32_t> number(order.size());
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

}  // namespace cdb::meshes
