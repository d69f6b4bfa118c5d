#include <fmt/format.h>

#include "library/meshes/mesh_formats.h"

namespace cdb::meshes {
namespace {

/// Reads lines that are not empty.
class OffReader {
 public:
  OffReader(std::string_view bytes, std::string_view name) : lines_(bytes), name_(name) {}

  bool Next() {
    while (lines_.Next()) {
      SplitWords(lines_.line(), words_);
      if (!words_.empty()) return true;
    }
    return false;
  }
  void Require(std::string_view what) {
    if (!Next()) Refuse(name_, lines_.place(), fmt::format("the file ends before {}", what));
  }
  std::vector<std::string_view>& words() { return words_; }
  Place place() const { return lines_.place(); }

 private:
  Lines lines_;
  std::string_view name_;
  std::vector<std::string_view> words_;
};

/// True for OFF with the prefixes for additional vertex data: textures, colour, normal.
bool IsHeader(std::string_view word) {
  for (const std::string_view prefix : {"ST", "C", "N"})
    if (word.starts_with(prefix)) word.remove_prefix(prefix.size());
  return word == "OFF";
}

/// Reads the number of `what`.
std::uint64_t ReadCount(std::string_view word, std::string_view what, std::string_view bytes,
                        std::string_view name, Place place) {
  const std::int64_t count = Integer(word, name, place);
  // Each takes a separate line of at least two bytes.
  if (count < 0 || static_cast<std::uint64_t>(count) > bytes.size() / 2)
    Refuse(
        name, place,
        fmt::format("declares {} {}, which do not fit into {} bytes", count, what, bytes.size()));
  return static_cast<std::uint64_t>(count);
}

struct Counts {
  std::uint64_t vertices, faces;
};

Counts ReadHead(std::string_view bytes, std::string_view name, OffReader& reader) {
  reader.Require("its first word");
  auto& words = reader.words();
  if (!IsHeader(words[0]))
    Refuse(name, reader.place(),
           fmt::format("starts with `{}`; should start with OFF, STOFF, COFF or NOFF", words[0]));
  words.erase(words.begin());
  if (!words.empty() && words[0] == "BINARY")
    Refuse(name, reader.place(), "binary OFF is not supported; export the model as text");
  if (words.empty()) reader.Require("the numbers of vertices and faces");
  if (words.size() < 2 || words.size() > 3)
    Refuse(name, reader.place(), "should be the numbers of vertices, faces and edges");
  const std::uint64_t vertices = ReadCount(words[0], "vertices", bytes, name, reader.place());
  const std::uint64_t faces = ReadCount(words[1], "faces", bytes, name, reader.place());
  if (words.size() == 3) Integer(words[2], name, reader.place());
  return {vertices, faces};
}

void ReadVertex(std::string_view name, OffReader& reader, Mesh& mesh) {
  const auto& words = reader.words();
  if (words.size() < 3)
    Refuse(name, reader.place(), "should be a line with the 3 coordinates of a vertex");
  AddVertex({Number(words[0], name, reader.place()), Number(words[1], name, reader.place()),
             Number(words[2], name, reader.place())},
            mesh, name, reader.place());
}

/// Reads the corners of a face into `corners`.
void ReadCorners(std::uint64_t vertices, std::string_view name, OffReader& reader,
                 std::vector<std::uint32_t>& corners) {
  const auto& words = reader.words();
  const std::int64_t count = Integer(words[0], name, reader.place());
  // The colour of the face follows the corners.
  if (count < 0 || static_cast<std::uint64_t>(count) > words.size() - 1)
    Refuse(name, reader.place(),
           fmt::format("declares {} corners but has {}", count, words.size() - 1));
  corners.clear();
  for (std::int64_t k = 1; k <= count; ++k) {
    const std::int64_t corner = Integer(words[static_cast<std::size_t>(k)], name, reader.place());
    if (corner < 0 || static_cast<std::uint64_t>(corner) >= vertices)
      Refuse(
          name, reader.place(),
          fmt::format("a face has vertex {}, counted from 0, but there are {}", corner, vertices));
    corners.push_back(static_cast<std::uint32_t>(corner));
  }
}

}  // namespace

Mesh ParseOff(std::string_view bytes, std::string_view name) {
  OffReader reader(bytes, name);
  const Counts counts = ReadHead(bytes, name, reader);
  Mesh mesh;
  for (std::uint64_t i = 0; i < counts.vertices; ++i) {
    reader.Require(fmt::format("vertex {} of {}", i + 1, counts.vertices));
    ReadVertex(name, reader, mesh);
  }
  std::vector<std::uint32_t> corners;
  for (std::uint64_t i = 0; i < counts.faces; ++i) {
    reader.Require(fmt::format("face {} of {}", i + 1, counts.faces));
    ReadCorners(counts.vertices, name, reader, corners);
    AddPolygon(corners, mesh.vertices.size(), mesh, name, reader.place());
  }
  if (reader.Next())
    Refuse(name, reader.place(),
           fmt::format("continues after the {} faces that its header declares", counts.faces));
  return mesh;
}

}  // namespace cdb::meshes
