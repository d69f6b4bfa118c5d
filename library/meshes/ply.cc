#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <optional>

#include "library/meshes/mesh_formats.h"

namespace cdb::meshes {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct TypeName {
  std::string_view name;
  Type type;
};
constexpr TypeName kTypes[] = {
    {"char", Type::kInt8},       {"int8", Type::kInt8},       {"uchar", Type::kUint8},
    {"uint8", Type::kUint8},     {"short", Type::kInt16},     {"int16", Type::kInt16},
    {"ushort", Type::kUint16},   {"uint16", Type::kUint16},   {"int", Type::kInt32},
    {"int32", Type::kInt32},     {"uint", Type::kUint32},     {"uint32", Type::kUint32},
    {"float", Type::kFloat32},   {"float32", Type::kFloat32}, {"double", Type::kFloat64},
    {"float64", Type::kFloat64},
};

std::size_t BytesOf(Type type) {
  switch (type) {
    case Type::kInt8:
    case Type::kUint8:
      return 1;
    case Type::kInt16:
    case Type::kUint16:
      return 2;
    case Type::kFloat64:
      return 8;
    default:
      return 4;
  }
}

bool IsFloat(Type type) { return type == Type::kFloat32 || type == Type::kFloat64; }

struct Property {
  std::string_view name;
  Type type;
  std::optional<Type> count;  ///< for a list: the type of its length
};

struct Element {
  std::string_view name;
  std::uint64_t count;
  std::vector<Property> properties;
  Place place;
};

/// The values after the header. All types fit exactly into a double.
class Values {
 public:
  virtual ~Values() = default;
  virtual double Next(Type type) = 0;
  /// Passes a value that need not be a number.
  virtual void Skip(Type type) = 0;
  virtual Place place() = 0;
  virtual std::size_t BytesLeft() = 0;
  /// The minimum number of bytes of a value.
  virtual std::size_t LeastBytes(Type type) const = 0;
};

class TextValues : public Values {
 public:
  TextValues(std::string_view body, std::size_t header_lines, std::string_view name)
      : lines_(body), size_(body.size()), header_lines_(header_lines), name_(name) {}

  double Next(Type) override {
    const std::string_view word = Take();
    return Number(word, name_, place());
  }
  void Skip(Type) override { Take(); }
  /// The location of the next value, which may be some lines below.
  Place place() override {
    IsAtEnd();
    return {Place::Unit::kLine, header_lines_ + lines_.place().number};
  }
  std::size_t BytesLeft() override { return size_ - lines_.offset() + lines_.line().size() + 1; }
  std::size_t LeastBytes(Type) const override { return 2; }  // a digit and a separator

 private:
  std::string_view Take() {
    if (IsAtEnd()) Refuse(name_, place(), "the file ends before the data that its header declares");
    return words_[at_++];
  }
  bool IsAtEnd() {
    while (at_ == words_.size()) {
      if (!lines_.Next()) return true;
      SplitWords(lines_.line(), words_);
      at_ = 0;
    }
    return false;
  }

  Lines lines_;
  std::size_t size_, header_lines_;
  std::string_view name_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
};

class BinaryValues : public Values {
 public:
  BinaryValues(std::string_view bytes, std::size_t offset, bool big_endian, std::string_view name)
      : bytes_(bytes), at_(offset), big_endian_(big_endian), name_(name) {}

  double Next(Type type) override {
    const std::size_t size = BytesOf(type);
    if (size > BytesLeft())
      Refuse(name_, place(), "the file ends before the data that its header declares");
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t from = big_endian_ ? at_ + i : at_ + size - 1 - i;
      bits = bits << 8 | static_cast<unsigned char>(bytes_[from]);
    }
    at_ += size;
    switch (type) {
      case Type::kInt8:
        return static_cast<std::int8_t>(bits);
      case Type::kInt16:
        return static_cast<std::int16_t>(bits);
      case Type::kInt32:
        return static_cast<std::int32_t>(bits);
      case Type::kFloat32:
        return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      case Type::kFloat64:
        return std::bit_cast<double>(bits);
      default:
        return static_cast<double>(bits);
    }
  }
  void Skip(Type type) override { Next(type); }
  Place place() override { return {Place::Unit::kByte, at_}; }
  std::size_t BytesLeft() override { return bytes_.size() - at_; }
  std::size_t LeastBytes(Type type) const override { return BytesOf(type); }

 private:
  std::string_view bytes_;
  std::size_t at_;
  bool big_endian_;
  std::string_view name_;
};

class PlyParser {
 public:
  PlyParser(std::string_view bytes, std::string_view name) : bytes_(bytes), name_(name) {}

  Mesh Parse() {
    ParseHeader();
    for (const Element& element : elements_) {
      if (element.name == "vertex")
        ReadVertices(element);
      else if (element.name == "face" || IsOfStrips(element))
        ReadFaces(element);
      else
        Skip(element);
    }
    // Whatever follows is ignored.
    faces_->AddTo(mesh_);
    return std::move(mesh_);
  }

 private:
  void ParseHeader() {
    Lines lines(bytes_);
    std::vector<std::string_view> words;
    if (lines.Next()) SplitWords(WithoutMark(lines.line()), words);
    if (words.size() != 1 || words[0] != "ply")
      Refuse(name_, lines.place(), "should start with a line `ply`");
    std::string_view format;
    for (;;) {
      if (!lines.Next()) Refuse(name_, lines.place(), "the header has no `end_header`");
      SplitWords(lines.line(), words);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() == 3) {
        format = words[1];
      } else if (words[0] == "element" && words.size() == 3) {
        const std::int64_t count = Integer(words[2], name_, lines.place());
        if (count < 0) Refuse(name_, lines.place(), fmt::format("{} elements", count));
        elements_.push_back({words[1], static_cast<std::uint64_t>(count), {}, lines.place()});
      } else if (words[0] == "property" && !elements_.empty() && words.size() == 3) {
        elements_.back().properties.push_back(
            {words[2], TypeOf(words[1], lines.place()), std::nullopt});
      } else if (words[0] == "property" && !elements_.empty() && words.size() == 5 &&
                 words[1] == "list") {
        const Type count = TypeOf(words[2], lines.place());
        if (IsFloat(count)) Refuse(name_, lines.place(), "a list's length must be a whole number");
        elements_.back().properties.push_back({words[4], TypeOf(words[3], lines.place()), count});
      } else {
        Refuse(name_, lines.place(), fmt::format("cannot read `{}`", lines.line()));
      }
    }
    if (format == "ascii")
      values_ =
          std::make_unique<TextValues>(bytes_.substr(lines.offset()), lines.place().number, name_);
    else if (format == "binary_little_endian" || format == "binary_big_endian")
      values_ = std::make_unique<BinaryValues>(bytes_, lines.offset(),
                                               format == "binary_big_endian", name_);
    else
      Refuse(name_, lines.place(),
             fmt::format("the format `{}` is not one of ascii, binary_little_endian and "
                         "binary_big_endian",
                         format));
    const bool is_text = format == "ascii";
    faces_.emplace(name_, is_text ? Place::Unit::kLine : Place::Unit::kByte, 0);
    for (const Element& element : elements_) {
      if (element.name == "vertex" && vertices_) Refuse(name_, element.place, "vertices twice");
      if (element.name == "vertex") vertices_ = element.count;
    }
    if (!vertices_) Refuse(name_, lines.place(), "the header has no `element vertex`");
  }

  Type TypeOf(std::string_view word, Place place) const {
    for (const TypeName& type : kTypes)
      if (type.name == word) return type.type;
    Refuse(name_, place, fmt::format("`{}` is not a type of a property", word));
  }

  /// Rejects a count that exceeds the rest of the file, before memory is allocated for it.
  void CheckCount(const Element& element) {
    std::uint64_t least = 0;
    for (const Property& property : element.properties)
      least += values_->LeastBytes(property.count.value_or(property.type));
    if (element.count > 0 && least == 0)
      Refuse(name_, element.place, fmt::format("`{}` has no properties", element.name));
    // The last value of a text needs no separator.
    if (element.count > 0 && element.count > (values_->BytesLeft() + 1) / least)
      Refuse(name_, element.place,
             fmt::format("declares {} of `{}`, which do not fit into the remaining {} bytes; the "
                         "file is truncated or damaged",
                         element.count, element.name, values_->BytesLeft()));
  }

  std::uint64_t ListLength(const Property& property) {
    const Place place = values_->place();
    const double length = values_->Next(*property.count);
    if (!(length >= 0) || length != std::floor(length) ||
        length >
            static_cast<double>((values_->BytesLeft() + 1) / values_->LeastBytes(property.type)))
      Refuse(name_, place,
             fmt::format("a list of {} values does not fit into the rest of the file", length));
    return static_cast<std::uint64_t>(length);
  }

  void SkipValue(const Property& property) {
    const std::uint64_t length = property.count ? ListLength(property) : 1;
    for (std::uint64_t i = 0; i < length; ++i) values_->Skip(property.type);
  }

  void Skip(const Element& element) {
    CheckCount(element);
    for (std::uint64_t i = 0; i < element.count; ++i)
      for (const Property& property : element.properties) SkipValue(property);
  }

  void ReadVertices(const Element& element) {
    CheckCount(element);
    std::vector<int> axis_of;  // by property; negative: not a coordinate
    std::array<int, 3> times{};
    for (const Property& property : element.properties) {
      const bool is_axis = !property.count && property.name.size() == 1 &&
                           property.name[0] >= 'x' && property.name[0] <= 'z';
      axis_of.push_back(is_axis ? property.name[0] - 'x' : -1);
      if (is_axis) ++times[static_cast<std::size_t>(axis_of.back())];
    }
    if (times != std::array{1, 1, 1})
      Refuse(name_, element.place, "a vertex needs each of the properties x, y and z once");
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Eigen::Vector3d vertex;
      const Place place = values_->place();
      for (std::size_t k = 0; k < axis_of.size(); ++k) {
        if (axis_of[k] < 0)
          SkipValue(element.properties[k]);
        else
          vertex[axis_of[k]] = values_->Next(element.properties[k].type);
      }
      AddVertex(vertex, mesh_, name_, place);
    }
  }

  void ReadFaces(const Element& element) {
    CheckCount(element);
    const Property* indices = nullptr;
    for (const Property& property : element.properties)
      if (property.count &&
          (property.name == "vertex_indices" || property.name == "vertex_index")) {
        if (indices != nullptr) Refuse(name_, element.place, "two lists of a face's vertices");
        indices = &property;
      }
    if (indices == nullptr && element.count > 0)
      Refuse(name_, element.place, "a face needs the property `list ... vertex_indices`");
    std::vector<std::uint32_t> corners;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) {
        if (&property != indices) {
          SkipValue(property);
          continue;
        }
        const Place place = values_->place();
        corners.clear();
        for (std::uint64_t left = ListLength(property); left > 0; --left) {
          const double corner = values_->Next(property.type);
          if (IsOfStrips(element) && corner == -1) {
            AddStrip(corners, place);
            corners.clear();
            continue;
          }
          if (!(corner >= 0 && corner < static_cast<double>(*vertices_)) ||
              corner != std::floor(corner))
            Refuse(name_, place,
                   fmt::format("a face has vertex {}, counted from 0, but there are {}", corner,
                               *vertices_));
          corners.push_back(static_cast<std::uint32_t>(corner));
        }
        if (IsOfStrips(element))
          AddStrip(corners, place);
        else
          faces_->Add(corners, place);
      }
    }
  }

  /// Each corner from the third on ends a triangle; every second one is turned round. A corner of
  /// -1 begins the next strip of a list.
  static bool IsOfStrips(const Element& element) {
    return element.name == "tristrips" || element.name == "tristrip";
  }

  void AddStrip(std::span<const std::uint32_t> corners, Place place) {
    for (std::size_t i = 2; i < corners.size(); ++i)
      faces_->Add(std::array{corners[i - (i % 2 == 0 ? 2 : 1)], corners[i - (i % 2 == 0 ? 1 : 2)],
                             corners[i]},
                  place);
  }

  std::string_view bytes_, name_;
  std::vector<Element> elements_;
  std::optional<std::uint64_t> vertices_;
  std::unique_ptr<Values> values_;
  Mesh mesh_;
  std::optional<PolygonList> faces_;
};

}  // namespace

Mesh ParsePly(std::string_view bytes, std::string_view name) {
  return PlyParser(bytes, name).Parse();
}

}  // namespace cdb::meshes
