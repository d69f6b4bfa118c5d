#include <fmt/format.h>

#include <algorithm>

#include "library/meshes/mesh_formats.h"

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

}  // namespace cdb::meshes
