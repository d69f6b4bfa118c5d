#include "runtime/store/hdf5/image_editor.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "runtime/store/hdf5/bytes.h"
#include "runtime/store/hdf5/checksums.h"
#include "runtime/store/hdf5/superblock.h"

namespace cdb::hdf5 {
namespace {

constexpr std::uint64_t kLeastHeap = 4096;

template <typename Number>
void Append(std::vector<std::byte>& bytes, Number number) {
  const auto raw = std::as_bytes(std::span(&number, 1));
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

}  // namespace

double AsStored(double value, Type type) {
  if (type == Type::kFloat64) return value;
  const bool is_byte = type == Type::kInt8;
  const double least =
      is_byte ? std::numeric_limits<std::int8_t>::min() : std::numeric_limits<std::int32_t>::min();
  const double most =
      is_byte ? std::numeric_limits<std::int8_t>::max() : std::numeric_limits<std::int32_t>::max();
  return std::isnan(value) ? 0 : std::trunc(std::clamp(value, least, most));
}

std::vector<std::byte> Filtered(std::span<const std::byte> values, std::size_t item_bytes) {
  constexpr int kLevel = 1;
  std::vector<std::byte> shuffled(values.size());
  const std::size_t items = values.size() / item_bytes;
  for (std::size_t byte = 0; byte < item_bytes; ++byte)
    for (std::size_t i = 0; i < items; ++i)
      shuffled[byte * items + i] = values[i * item_bytes + byte];
  uLongf size = compressBound(static_cast<uLong>(shuffled.size()));
  std::vector<std::byte> packed(size);
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(shuffled.data()),
                static_cast<uLong>(shuffled.size()), kLevel) != Z_OK)
    throw Error("cannot compress a chunk");
  packed.resize(size);
  Append(packed, Fletcher32(packed));
  return packed;
}

EditableImage::EditableImage(std::vector<std::byte> image) : bytes_(std::move(image)) {
  if (!HasSuperblock3(bytes_) || StatedBytes(bytes_) != bytes_.size())
    throw Error("a file with another head");
}

ObjectHeader EditableImage::HeaderOf(const Object& object) {
  const std::uint64_t address = object.Address();
  ObjectHeader header(bytes_, address);
  checked_.try_emplace(address, header.blocks());
  return header;
}

NumberPlace EditableImage::FindNumber(const Dataset& dataset) {
  const Extent values = HeaderOf(dataset).CompactValues();
  if (Product(dataset.shape()) != 1 || values.bytes != ItemBytes(dataset.type()))
    throw Error("an array of another size");
  return {values.begin, dataset.type()};
}

std::uint64_t EditableImage::FindTexts(const Dataset& dataset) {
  const Extent values = HeaderOf(dataset).CompactValues();
  if (dataset.type() != Type::kText || values.bytes != Product(dataset.shape()) * kTextBytes)
    throw Error("an array of another size");
  return values.begin;
}

std::uint64_t EditableImage::FindChunk(const Dataset& dataset) {
  return HeaderOf(dataset).SingleChunk();
}

Extent EditableImage::FindAttribute(const Object& object, std::string_view name) {
  return HeaderOf(object).Attribute(name);
}

template <typename Number>
void ImageEditor::Put(std::uint64_t at, Number number) {
  if (bytes_.size() < sizeof number || at > bytes_.size() - sizeof number)
    throw Error("a place outside of the file");
  std::memcpy(&bytes_[at], &number, sizeof number);
}

void ImageEditor::SetNumber(const NumberPlace& place, double value) {
  const double stored = AsStored(value, place.type);
  if (place.type == Type::kInt8) return Put(place.begin, static_cast<std::int8_t>(stored));
  if (place.type == Type::kInt32) return Put(place.begin, static_cast<std::int32_t>(stored));
  Put(place.begin, stored);
}

void ImageEditor::Align() { bytes_.resize(Aligned(bytes_.size())); }

ChunkPlace ImageEditor::SetChunk(std::uint64_t place, std::span<const std::byte> bytes) {
  const ChunkPlace chunk = {0, bytes_.size(), bytes.size()};
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  Put(place, chunk.bytes);
  Put(place + 8, chunk.filter_mask);
  Put(place + 12, chunk.begin);
  return chunk;
}

void ImageEditor::SetText(std::uint64_t place, const std::string& text) {
  // HDF5 ends a text at its first NUL; empty texts are not in a heap.
  std::string ended = text.c_str();
  if (!ended.empty()) texts_.push_back({place, std::move(ended)});
}

void ImageEditor::SetAttribute(const Extent& place, std::string_view text) {
  if (text.size() != place.bytes) throw Error("an attribute of another length");
  std::ranges::copy(std::as_bytes(std::span(text)),
                    bytes_.begin() + static_cast<std::ptrdiff_t>(place.begin));
}

// One collection with an object for each text.
void ImageEditor::AppendHeap() {
  if (texts_.empty()) return;
  Align();
  const std::uint64_t heap = bytes_.size();
  std::uint64_t used = kHeapHead;
  for (const HeapText& text : texts_) used += kHeapObjectHead + Aligned(text.text.size());
  const std::uint64_t bytes = std::max(kLeastHeap, used + kHeapObjectHead);
  for (const char c : kHeapSignature) bytes_.push_back(static_cast<std::byte>(c));
  Append(bytes_, bytes);
  std::uint16_t index = 0;
  const auto head = [this](std::uint16_t number, std::uint64_t size) {
    Append(bytes_, number);
    Append(bytes_, std::uint16_t{0});  // reference count
    Append(bytes_, std::uint32_t{0});
    Append(bytes_, size);
  };
  for (const HeapText& text : texts_) {
    head(++index, text.text.size());
    const auto raw = std::as_bytes(std::span(text.text));
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    Align();
    Put(text.place, static_cast<std::uint32_t>(text.text.size()));
    Put(text.place + 4, heap);
    Put(text.place + 12, std::uint32_t{index});
  }
  head(0, bytes - used);  // the remaining space
  bytes_.resize(heap + bytes);
}

std::vector<std::byte> ImageEditor::Finish() {
  AppendHeap();
  Align();
  for (const auto& [object, blocks] : image_.checked_)
    for (const Extent& block : blocks) {
      const std::uint64_t bytes = block.bytes - sizeof(std::uint32_t);
      Put(block.begin + bytes, Lookup3(std::span(bytes_).subspan(block.begin, bytes)));
    }
  CloseSuperblock(bytes_);
  return std::move(bytes_);
}

}  // namespace cdb::hdf5
