#include "runtime/results/hdf5/object.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>

#include "compiler/plan/input_file.h"
#include "runtime/results/hdf5/calls.h"

namespace cdb::hdf5 {
namespace {

constexpr std::size_t kLongestText = 32 << 10;
/// HDF5's own limit of an attribute in an object's header.
constexpr std::size_t kLongestStored = 64 << 10;

/// Empty if it is not text of fixed length.
std::string ReadTextAttribute(const Id& attribute) {
  const Id type(H5Aget_type(attribute.get()), H5Tclose, "read an attribute");
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0) return {};
  const Id space(H5Aget_space(attribute.get()), H5Sclose, "read an attribute");
  if (H5Sget_simple_extent_npoints(space.get()) != 1) return {};
  const std::size_t bytes = H5Tget_size(type.get());
  if (bytes > kLongestStored) throw Error("an attribute is longer than attributes can be");
  std::string text(bytes, '\0');
  Check(H5Aread(attribute.get(), type.get(), text.data()), "read an attribute");
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

}  // namespace

std::string_view AttributeText(std::string_view text) {
  if (text.size() <= kLongestText) return text;
  std::size_t end = kLongestText;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end);
}

std::size_t ItemBytes(Type type) {
  switch (type) {
    case Type::kInt8:
      return 1;
    case Type::kInt32:
    case Type::kFloat32:
      return 4;
    case Type::kFloat64:
      return 8;
    case Type::kText:
      break;
  }
  return sizeof(hvl_t);
}

std::uint64_t Product(const Shape& shape) {
  std::uint64_t product = 1;
  for (const std::uint64_t n : shape) product *= n;
  return product;
}

Id::Id(std::int64_t id, Close close, std::string_view doing) : id_(id), close_(close) {
  if (id < 0) Fail(doing);
}

Id::Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}

Id& Id::operator=(Id&& other) noexcept {
  if (this != &other) {
    Reset();
    id_ = std::exchange(other.id_, -1);
    close_ = other.close_;
  }
  return *this;
}

bool Id::Reset() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }

void Object::SetText(const char* name, std::string_view text) {
  text = AttributeText(text);
  if (text.empty()) return;
  const Id type = NewText(text.size());
  WriteAttribute(id_, name, type, type.get(), NewSpace({}), text.data());
}

void Object::SetNumber(const char* name, Type type, double value) {
  WriteAttribute(id_, name, FileType(type), H5T_NATIVE_DOUBLE, NewSpace({}), &value);
}

void Object::SetNumbers(const char* name, Type type, std::span<const double> values) {
  WriteAttribute(id_, name, FileType(type), H5T_NATIVE_DOUBLE, NewSpace({values.size()}),
                 values.data());
}

std::string Object::Text(const char* name) const {
  if (H5Aexists(id_.get(), name) <= 0) return {};
  return ReadTextAttribute({H5Aopen(id_.get(), name, H5P_DEFAULT), H5Aclose,
                            fmt::format("read the attribute {}", name)});
}

double Object::Number(const char* name) const {
  double value = std::numeric_limits<double>::quiet_NaN();
  if (H5Aexists(id_.get(), name) <= 0) return value;
  const std::string doing = fmt::format("read the attribute {}", name);
  const Id attribute(H5Aopen(id_.get(), name, H5P_DEFAULT), H5Aclose, doing);
  const Id space(H5Aget_space(attribute.get()), H5Sclose, doing);
  const Id type(H5Aget_type(attribute.get()), H5Tclose, doing);
  const H5T_class_t kind = H5Tget_class(type.get());
  if (H5Sget_simple_extent_npoints(space.get()) != 1 || (kind != H5T_INTEGER && kind != H5T_FLOAT))
    return value;
  Check(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value), doing);
  return value;
}

std::map<std::string, std::string> Object::Texts() const {
  std::map<std::string, std::string> texts;
  const auto visit = [](hid_t object, const char* name, const H5A_info_t*, void* out) -> herr_t {
    try {
      const Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose, "read an attribute");
      std::string text = ReadTextAttribute(attribute);
      if (!text.empty()) static_cast<decltype(texts)*>(out)->emplace(name, std::move(text));
      return 0;
    } catch (const std::exception&) {
      return -1;  // exceptions must not pass through HDF5
    }
  };
  Check(H5Aiterate2(id_.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, visit, &texts),
        "read the attributes");
  return texts;
}

namespace {

/// A global heap (III.E of the specification): a head with signature and size, and objects, each
/// with a head. Objects begin at multiples of kAlignment.
constexpr std::string_view kHeapSignature("GCOL\1\0\0\0", 8);
constexpr std::uint64_t kHeapHead = 16, kHeapObjectHead = 16, kAlignment = 8;

std::uint64_t Aligned(std::uint64_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

template <typename Number>
Number Get(std::span<const std::byte> bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, &bytes[at], sizeof number);
  return number;
}

/// `heap`: from its signature to the end of the file.
void CheckHeap(std::span<const std::byte> heap) {
  const auto bytes = Get<std::uint64_t>(heap, kHeapSignature.size());
  if (bytes > heap.size()) return;
  std::uint64_t at = kHeapHead;
  while (at + kHeapObjectHead <= bytes) {
    const bool is_free = Get<std::uint16_t>(heap, at) == 0;  // its size includes the head
    const auto size = Get<std::uint64_t>(heap, at + 8);
    const std::uint64_t step = is_free ? size : kHeapObjectHead + Aligned(size);
    if (step == 0) throw Error("a text in it has no size, and HDF5 would read it for ever");
    if (step > bytes - at) return;
    at += step;
  }
}

/// The same bytes as text, whose find is faster than a search for bytes.
std::string_view AsText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void CheckHeapsIn(std::span<const std::byte> file) {
  const std::string_view bytes = AsText(file);
  for (std::size_t at = 0; (at = bytes.find(kHeapSignature, at)) != bytes.npos; ++at)
    if (at + kHeapHead <= bytes.size()) CheckHeap(file.subspan(at));
}

}  // namespace

void CheckGlobalHeaps(const std::filesystem::path& path) {
  const plan::Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts = {};
  if (file.get() < 0 || fstat(file.get(), &facts) != 0 || facts.st_size <= 0) return;
  const auto bytes = static_cast<std::size_t>(facts.st_size);
  void* const begin = mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (begin == MAP_FAILED) return;
  struct Mapping {
    void* begin;
    std::size_t bytes;
    ~Mapping() { munmap(begin, bytes); }
  } const mapping{begin, bytes};
  CheckHeapsIn({static_cast<const std::byte*>(begin), bytes});
}

}  // namespace cdb::hdf5
