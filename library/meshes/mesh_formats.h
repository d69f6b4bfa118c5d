// The parsers of ParseMesh, one source file each, and their common parts. Only for library/meshes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

Mesh ParseObj(std::string_view bytes, std::string_view name);
/// The faces of each group, which is named by `o` and `g`, in the order of the file.
std::vector<Mesh> ParseObjGroups(std::string_view bytes, std::string_view name);
Mesh ParseOff(std::string_view bytes, std::string_view name);
Mesh ParsePly(std::string_view bytes, std::string_view name);
Mesh ParseStl(std::string_view bytes, std::string_view name);

/// A location in a file.
struct Place {
  enum class Unit { kLine, kByte };
  Unit unit = Unit::kLine;
  std::size_t number = 0;  ///< lines from 1, bytes from 0
};

/// Throws SceneError `name:12: what` or `name: byte 84: what`.
[[noreturn]] void Refuse(std::string_view name, Place place, std::string_view what);

/// Rejects coordinates that are not finite or exceed kLargestCoordinate.
void CheckCoordinates(const Eigen::Vector3d& vertex, std::string_view name, Place place);
/// Parses `word` as a number; rejects other text.
double Number(std::string_view word, std::string_view name, Place place);
/// The same for integers.
std::int64_t Integer(std::string_view word, std::string_view name, Place place);

/// The faces of a file, which become triangles when all of its vertices are known.
class PolygonList {
 public:
  /// `first`: the format's number of the first vertex.
  PolygonList(std::string_view name, Place::Unit unit, std::uint32_t first)
      : name_(name), unit_(unit), first_(first) {}
  /// Rejects fewer than three corners, and too many triangles.
  void Add(std::span<const std::uint32_t> corners, Place place);
  /// Rejects corners that the mesh does not have.
  void AddTo(Mesh& mesh) const;

 private:
  std::string_view name_;
  Place::Unit unit_;
  std::uint32_t first_;
  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> ends_, places_;  ///< by face
};

/// Rejects more than kMaxTriangles.
void CheckTriangles(std::size_t count, std::string_view name, Place place);
void AddVertex(const Eigen::Vector3d& vertex, Mesh& mesh, std::string_view name, Place place);

/// The lines of a text, with any of the three line ends.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  /// False at the end of the text.
  bool Next();
  std::string_view line() const { return line_; }
  Place place() const { return {Place::Unit::kLine, number_}; }
  /// The offset of the first byte that Next has not passed.
  std::size_t offset() const { return offset_; }

 private:
  std::string_view text_, line_;
  std::size_t offset_ = 0, number_ = 0;
};

/// The text without the mark that may begin UTF-8.
std::string_view WithoutMark(std::string_view text);
/// The words of a line, up to a `#`.
void SplitWords(std::string_view line, std::vector<std::string_view>& words);
std::string LowerCase(std::string_view text);

}  // namespace cdb::meshes
