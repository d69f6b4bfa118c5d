#include "library/meshes/mesh_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <map>
#include <utility>

#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

// Names, groups, materials, normals, textures and display: none of them affects the faces.
constexpr std::string_view kNoSurface[] = {
    "vt", "vn",    "vp",  "s",        "mg",    "usemtl", "mtllib",   "usemap",    "maplib",    "l",
    "p",  "bevel", "lod", "c_interp", "ctech", "stech",  "d_interp", "trace_obj", "shadow_obj"};

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

/// Reads the vertices into `mesh`, and each face into the list of its group: the `o` and the `g`
/// that precede it, as written.
void ReadObj(std::string_view bytes, std::string_view name, Mesh& mesh,
             const std::function<PolygonList&(const std::string& group)>& faces_of) {
  std::vector<std::uint32_t> corners;
  std::string object, group;
  PolygonList* faces = nullptr;
  Lines lines(WithoutMark(bytes));
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
      corners.clear();
      for (std::size_t i = 1; i < words.size(); ++i)
        corners.push_back(ReadCorner(words[i], mesh.vertices.size(), name, place));
      if (faces == nullptr) faces = &faces_of(object + group);
      faces->Add(corners, place);
    } else if (words[0] == "o" || words[0] == "g") {
      (words[0] == "o" ? object : group) = text;
      faces = nullptr;
    } else if (std::find(std::begin(kNoSurface), std::end(kNoSurface), words[0]) ==
               std::end(kNoSurface)) {
      Refuse(name, place, fmt::format("cannot read `{}`; export the model as polygons", words[0]));
    }
  }
}

}  // namespace

Mesh ParseObj(std::string_view bytes, std::string_view name) {
  // A face may precede its vertices.
  PolygonList faces(name, Place::Unit::kLine, 1);
  Mesh mesh;
  ReadObj(bytes, name, mesh, [&](const std::string&) -> PolygonList& { return faces; });
  faces.AddTo(mesh);
  return mesh;
}

std::vector<Mesh> ParseObjGroups(std::string_view bytes, std::string_view name) {
  Mesh all;
  std::map<std::string, std::size_t> numbers;
  std::vector<PolygonList> groups;
  ReadObj(bytes, name, all, [&](const std::string& group) -> PolygonList& {
    const auto [at, is_new] = numbers.try_emplace(group, groups.size());
    if (is_new) groups.emplace_back(name, Place::Unit::kLine, 1);
    return groups[at->second];
  });
  std::vector<Mesh> parts;
  for (const PolygonList& faces : groups) {
    faces.AddTo(all);
    parts.push_back(SubMesh(all, std::exchange(all.triangles, {})));
  }
  return parts;
}

namespace {

/// The words of a text; each may be on any line.
class Words {
 public:
  Words(std::string_view text, std::string_view name) : lines_(text), name_(name) {}

  /// Empty at the end.
  std::string_view Peek() {
    while (at_ == words_.size()) {
      if (!lines_.Next()) return {};
      SplitWords(lines_.line(), words_);
      at_ = 0;
    }
    return words_[at_];
  }
  template <typename... What>
  std::string_view Take(fmt::format_string<What...> what, What&&... values) {
    const std::string_view word = Peek();
    if (word.empty())
      Refuse(name_, place(),
             "the file ends before " + fmt::format(what, std::forward<What>(values)...));
    ++at_;
    return word;
  }
  void SkipLine() { at_ = words_.size(); }
  bool IsAtEndOfLine() const { return at_ == words_.size(); }
  Place place() const { return lines_.place(); }
  std::string_view name() const { return name_; }

 private:
  Lines lines_;
  std::string_view name_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
};

/// Reads OFF, with the prefixes for additional vertex data: textures, colour, normal.
class OffParser {
 public:
  /// `by_line`: each vertex and each face begins a line, and the rest of its last line is ignored:
  /// colours, mostly. Otherwise nothing is, and line ends have no meaning.
  OffParser(std::string_view bytes, std::string_view name, bool by_line)
      : size_(bytes.size()), words_(WithoutMark(bytes), name), by_line_(by_line) {}

  Mesh Parse() {
    ReadHead();
    Mesh mesh;
    for (std::uint64_t i = 1; i <= vertices_; ++i) {
      Eigen::Vector3d vertex;
      for (double& x : vertex) x = ReadNumber(i);
      AddVertex(vertex, mesh, words_.name(), words_.place());
      for (int k = 0; !by_line_ && k < further_numbers_; ++k) ReadNumber(i);
      if (by_line_) words_.SkipLine();
    }
    PolygonList faces(words_.name(), Place::Unit::kLine, 0);
    for (std::uint64_t i = 1; i <= faces_; ++i) ReadFace(i, faces);
    if (!words_.Peek().empty())
      Refuse(words_.name(), words_.place(),
             fmt::format("continues after the {} faces that its header declares", faces_));
    faces.AddTo(mesh);
    return mesh;
  }

 private:
  double ReadNumber(std::uint64_t vertex) {
    const std::string_view word = words_.Take("vertex {} of {}", vertex, vertices_);
    return Number(word, words_.name(), words_.place());
  }

  void ReadHead() {
    const std::string_view written = words_.Take("its first word");
    std::string_view word = written;
    struct Prefix {
      std::string_view letters;
      int numbers;
    };
    for (const auto& [letters, numbers] : {Prefix{"ST", 2}, Prefix{"C", 4}, Prefix{"N", 3}}) {
      if (!word.starts_with(letters)) continue;
      word.remove_prefix(letters.size());
      further_numbers_ += numbers;
    }
    const bool is_off = word.starts_with("OFF");
    if (is_off) word.remove_prefix(3);
    if (!is_off || !(word.empty() || (word[0] >= '0' && word[0] <= '9')))
      Refuse(words_.name(), words_.place(),
             fmt::format("starts with `{}`; should start with OFF, STOFF, COFF or NOFF", written));
    if (words_.Peek() == "BINARY")
      Refuse(words_.name(), words_.place(),
             "binary OFF is not supported; export the model as text");
    vertices_ = ReadCount(word, "vertices");
    faces_ = ReadCount({}, "faces");
    if (by_line_ && words_.IsAtEndOfLine()) return;
    Integer(words_.Take("the number of edges"), words_.name(), words_.place());
    if (by_line_ && !words_.IsAtEndOfLine())
      Refuse(words_.name(), words_.place(), "should be the numbers of vertices, faces and edges");
  }

  /// `word`: empty if it comes next.
  std::uint64_t ReadCount(std::string_view word, std::string_view what) {
    if (word.empty()) word = words_.Take("the number of {}", what);
    const std::int64_t count = Integer(word, words_.name(), words_.place());
    // Each takes at least a digit and a separator.
    if (count < 0 || static_cast<std::uint64_t>(count) > size_ / 2)
      Refuse(words_.name(), words_.place(),
             fmt::format("declares {} {}, which do not fit into {} bytes", count, what, size_));
    return static_cast<std::uint64_t>(count);
  }

  void ReadFace(std::uint64_t number, PolygonList& faces) {
    const auto next = [&] {
      const std::string_view word = words_.Take("the end of face {} of {}", number, faces_);
      return Integer(word, words_.name(), words_.place());
    };
    const std::int64_t count = next();
    const Place place = words_.place();
    if (count < 1 || static_cast<std::uint64_t>(count) > size_ / 2)
      Refuse(words_.name(), place, fmt::format("a face cannot have {} corners", count));
    corners_.clear();
    for (std::int64_t k = 0; k < count; ++k) {
      const std::int64_t corner = next();
      if (corner < 0 || static_cast<std::uint64_t>(corner) >= vertices_)
        Refuse(words_.name(), words_.place(),
               fmt::format("a face has vertex {}, counted from 0, but there are {}", corner,
                           vertices_));
      corners_.push_back(static_cast<std::uint32_t>(corner));
    }
    if (by_line_) words_.SkipLine();
    // OFF writes points and edges as faces too.
    if (count >= 3) faces.Add(corners_, place);
  }

  std::size_t size_;
  Words words_;
  bool by_line_;
  int further_numbers_ = 0;  ///< of each vertex
  std::uint64_t vertices_ = 0, faces_ = 0;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Mesh ParseOff(std::string_view bytes, std::string_view name) {
  try {
    return OffParser(bytes, name, true).Parse();
  } catch (const library::SceneError&) {
    try {
      return OffParser(bytes, name, false).Parse();
    } catch (const library::SceneError&) {
    }
    throw;
  }
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
  mesh.triangles.push_back({count - 3, count - 2, count - 1});
  CheckTriangles(mesh.triangles.size(), name, place);
}

Mesh ParseBinary(std::string_view bytes, std::string_view name) {
  Mesh mesh;
  const std::size_t end = kHead + 4 + kTriangle * std::size_t{Word(bytes, kHead)};
  for (std::size_t at = kHead + 4; at < end; at += kTriangle) {
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

/// Takes the next of the words, which have a fixed order, if it is this one.
bool TakeIf(Words& words, std::string_view word) {
  // A `#` does not begin a comment here, but text after it would be invalid anyway.
  if (LowerCase(words.Peek()) != word) return false;
  words.Take("it");
  return true;
}

void Expect(Words& words, std::string_view word) {
  if (TakeIf(words, word)) return;
  const std::string_view got = words.Take("`{}`", word);
  Refuse(words.name(), words.place(), fmt::format("`{}` instead of `{}`", got, word));
}

Mesh ParseText(std::string_view bytes, std::string_view name) {
  Mesh mesh;
  Words words(WithoutMark(bytes), name);
  // Whatever follows the last solid is ignored, as after binary triangles.
  for (bool is_first = true; is_first || LowerCase(words.Peek()) == "solid"; is_first = false) {
    Expect(words, "solid");
    words.SkipLine();  // its name can be any words, or missing
    while (TakeIf(words, "facet")) {
      Expect(words, "normal");
      // Often zero or NaN; the order of the corners determines the outside.
      for (int i = 0; i < 3; ++i) words.Take("a normal");
      Expect(words, "outer");
      Expect(words, "loop");
      for (int corner = 0; corner < 3; ++corner) {
        Expect(words, "vertex");
        Eigen::Vector3d vertex;
        for (double& x : vertex) {
          const std::string_view word = words.Take("a coordinate");
          x = Number(word, name, words.place());
        }
        AddVertex(vertex, mesh, name, words.place());
      }
      Expect(words, "endloop");
      Expect(words, "endfacet");
      AddLastThree(mesh, name, words.place());
    }
    Expect(words, "endsolid");
    words.SkipLine();
  }
  return mesh;
}

}  // namespace

Mesh ParseStl(std::string_view bytes, std::string_view name) {
  const std::string_view text = WithoutMark(bytes);
  const std::string_view word =
      text.substr(std::min(text.find_first_not_of(" \t\r\n"), text.size()), 5);
  // Binary files may begin with `solid` too, but have zero bytes: in their number of triangles.
  if (LowerCase(word) == "solid" && bytes.substr(0, kHead + 4).find('\0') == bytes.npos)
    return ParseText(bytes, name);
  if (bytes.size() < kHead + 4)
    Refuse(name, {Place::Unit::kByte, bytes.size()},
           "the file ends before the number of triangles; it is not an STL file, or truncated");
  const std::uint32_t count = Word(bytes, kHead);
  if (bytes.size() < kHead + 4 + std::uint64_t{kTriangle} * count)
    Refuse(name, {Place::Unit::kByte, kHead},
           fmt::format("declares {} triangles, which take {} bytes, but the file has {}; it is "
                       "truncated, or not an STL file",
                       count, kHead + 4 + std::uint64_t{kTriangle} * count, bytes.size()));
  return ParseBinary(bytes, name);
}

}  // namespace cdb::meshes
