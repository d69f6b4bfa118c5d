#include "library/meshes/mesh_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace cdb::meshes {
namespace {

// Names, groups, materials, normals, textures and display: none of them affects the faces.
constexpr std::string_view kNoSurface[] = {
    "vt",     "vn",       "vp",     "g",      "o",        "s",         "mg",
    "usemtl", "mtllib",   "usemap", "maplib", "l",        "p",         "bevel",
    "lod",    "c_interp", "ctech",  "stech",  "d_interp", "trace_obj", "shadow_obj"};

/// Reads a line, and joins the lines that a backslash continues.
bool NextLine(Lines& lines, std::string& text, Place& place) {
  if (!lines.Next()) return false;
  place = lines.place();
  text = lines.line();
  while (text.ends_with('\\')) {
    text.back() = ' ';
    if (!lines.Next()) break;
    text += lines.line();
  }
  return true;
}

/// The vertex of `vertex/texture/normal`, counted from 0; the last two parts may be missing.
/// `vertices`: the number of vertices before this line.
std::uint32_t ReadCorner(std::string_view word, std::size_t vertices, std::string_view name,
                         Place place) {
  std::string_view rest = word;
  const std::size_t slash = std::min(rest.find('/'), rest.size());
  const std::int64_t index = Integer(rest.substr(0, slash), name, place);
  for (int part = 1; slash < word.size() && part <= 3; ++part) {
    rest.remove_prefix(std::min(rest.find('/'), rest.size()));
    if (rest.empty()) break;
    rest.remove_prefix(1);
    const std::string_view other = rest.substr(0, rest.find('/'));
    if (part == 3) Refuse(name, place, fmt::format("`{}` has too many parts", word));
    if (!other.empty()) Integer(other, name, place);
  }
  const auto count = static_cast<std::int64_t>(vertices);
  const std::int64_t from_zero = index < 0 ? count + index : index - 1;
  if (index == 0 || from_zero < 0 || index > static_cast<std::int64_t>(kMaxVertices))
    Refuse(name, place,
           fmt::format("a face has vertex {}; they count from 1, or back from -1 with {} before "
                       "this line",
                       index, count));
  return static_cast<std::uint32_t>(from_zero);
}

}  // namespace

Mesh ParseObj(std::string_view bytes, std::string_view name) {
  // A face may precede its vertices, so faces are kept until the number of vertices is known.
  struct Face {
    std::size_t begin;  ///< of its corners
    Place place;
  };
  std::vector<Face> faces;
  std::vector<std::uint32_t> corners;
  Mesh mesh;
  Lines lines(bytes);
  std::string text;
  std::vector<std::string_view> words;
  for (Place place; NextLine(lines, text, place);) {
    SplitWords(text, words);
    if (words.empty()) continue;
    if (words[0] == "v") {
      // More than three: a weight or a colour.
      if (words.size() < 4) Refuse(name, place, "a vertex needs 3 coordinates");
      AddVertex({Number(words[1], name, place), Number(words[2], name, place),
                 Number(words[3], name, place)},
                mesh, name, place);
    } else if (words[0] == "f" || words[0] == "fo") {
      faces.push_back({corners.size(), place});
      for (std::size_t i = 1; i < words.size(); ++i)
        corners.push_back(ReadCorner(words[i], mesh.vertices.size(), name, place));
    } else if (std::find(std::begin(kNoSurface), std::end(kNoSurface), words[0]) ==
               std::end(kNoSurface)) {
      Refuse(name, place, fmt::format("cannot read `{}`; export the model as polygons", words[0]));
    }
  }
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const std::size_t end = i + 1 < faces.size() ? faces[i + 1].begin : corners.size();
    AddPolygon(std::span(corners).subspan(faces[i].begin, end - faces[i].begin),
               mesh.vertices.size(), mesh, name, faces[i].place, 1);
  }
  return mesh;
}

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

namespace {

constexpr std::size_t kHead = 80;      ///< bytes of free text before the number of triangles
constexpr std::size_t kTriangle = 50;  ///< a normal, three corners and two spare bytes

std::uint32_t Word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
  return value;
}

void AddLastThree(Mesh& mesh, std::string_view name, Place place) {
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  AddPolygon(std::array{count - 3, count - 2, count - 1}, count, mesh, name, place);
}

Mesh ParseBinary(std::string_view bytes, std::string_view name) {
  Mesh mesh;
  for (std::size_t at = kHead + 4; at < bytes.size(); at += kTriangle) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Eigen::Vector3d vertex;
      const std::size_t begin = at + 12 + 12 * corner;
      for (std::size_t axis = 0; axis < 3; ++axis)
        vertex[static_cast<int>(axis)] = std::bit_cast<float>(Word(bytes, begin + 4 * axis));
      AddVertex(vertex, mesh, name, {Place::Unit::kByte, begin});
    }
    AddLastThree(mesh, name, {Place::Unit::kByte, at});
  }
  return mesh;
}

/// The words of the text form, which have a fixed order.
class StlText {
 public:
  StlText(std::string_view bytes, std::string_view name) : lines_(bytes), name_(name) {}

  /// Empty at the end.
  std::string_view Peek() {
    while (at_ == words_.size()) {
      if (!lines_.Next()) return {};
      // A `#` does not begin a comment here, but text after it would be invalid anyway.
      SplitWords(lines_.line(), words_);
      at_ = 0;
    }
    return words_[at_];
  }
  bool Take(std::string_view word) {
    if (LowerCase(Peek()) != word) return false;
    ++at_;
    return true;
  }
  void Expect(std::string_view word) {
    if (Take(word)) return;
    const std::string_view got = Peek();
    Refuse(name_, place(),
           got.empty() ? fmt::format("the file ends before `{}`", word)
                       : fmt::format("`{}` instead of `{}`", got, word));
  }
  std::string_view TakeAny(std::string_view what) {
    const std::string_view word = Peek();
    if (word.empty()) Refuse(name_, place(), fmt::format("the file ends before {}", what));
    ++at_;
    return word;
  }
  /// The name of a solid can be any words, or missing.
  void SkipLine() { at_ = words_.size(); }
  Place place() const { return lines_.place(); }

 private:
  Lines lines_;
  std::string_view name_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
};

Mesh ParseText(std::string_view bytes, std::string_view name) {
  Mesh mesh;
  StlText text(bytes, name);
  do {
    text.Expect("solid");
    text.SkipLine();
    while (text.Take("facet")) {
      text.Expect("normal");
      // Often zero or NaN; the order of the corners determines the outside.
      for (int i = 0; i < 3; ++i) text.TakeAny("a normal");
      text.Expect("outer");
      text.Expect("loop");
      for (int corner = 0; corner < 3; ++corner) {
        text.Expect("vertex");
        Eigen::Vector3d vertex;
        for (double& coordinate : vertex)
          coordinate = Number(text.TakeAny("a coordinate"), name, text.place());
        AddVertex(vertex, mesh, name, text.place());
      }
      text.Expect("endloop");
      text.Expect("endfacet");
      AddLastThree(mesh, name, text.place());
    }
    text.Expect("endsolid");
    text.SkipLine();
  } while (!text.Peek().empty());
  return mesh;
}

}  // namespace

Mesh ParseStl(std::string_view bytes, std::string_view name) {
  // Binary files may begin with `solid` too; only their length distinguishes them.
  if (bytes.size() >= kHead + 4 &&
      bytes.size() == kHead + 4 + std::uint64_t{kTriangle} * Word(bytes, kHead))
    return ParseBinary(bytes, name);
  if (LowerCase(bytes.substr(0, 5)) == "solid") return ParseText(bytes, name);
  if (bytes.size() < kHead + 4)
    Refuse(name, {Place::Unit::kByte, bytes.size()},
           "the file ends before the number of triangles; it is not an STL file, or truncated");
  const std::uint32_t count = Word(bytes, kHead);
  Refuse(name, {Place::Unit::kByte, kHead},
         fmt::format("declares {} triangles, which take {} bytes, but the file has {}; it is "
                     "truncated, or not an STL file",
                     count, kHead + 4 + std::uint64_t{kTriangle} * count, bytes.size()));
}

}  // namespace cdb::meshes
