#include <fmt/format.h>

#include <bit>

#include "library/meshes/mesh_formats.h"

namespace cdb::meshes {
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
