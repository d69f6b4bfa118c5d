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

namespace cdb::hdf5 {
namespace {

/// Offsets in a superblock of version 1, with addresses and lengths of eight bytes.
constexpr std::size_t kVersionAt = 8, kSizesAt = 13, kBaseAt = 28, kEndAt = 44, kSuperblock = 60;
/// Offset in an entry of the index of chunks: size, mask, a start for each dimension and one for
/// the bytes of an element, then the address.
std::size_t AddressOfEntry(std::size_t rank) { return 8 + 8 * (rank + 1); }

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

std::optional<NumberPlace> FindNumber(const Dataset& dataset) {
  const auto begin = dataset.FindValues();
  const bool is_known = dataset.type() == Type::kInt8 || dataset.type() == Type::kInt32 ||
                        dataset.type() == Type::kFloat64;
  if (!begin || !is_known || Product(dataset.shape()) != 1) return std::nullopt;
  return NumberPlace{*begin, dataset.type()};
}

std::optional<std::uint64_t> FindChunkEntry(std::span<const std::byte> image,
                                            const ChunkPlace& chunk, std::size_t rank) {
  std::vector<std::byte> entry;
  Append(entry, static_cast<std::uint32_t>(chunk.bytes));
  Append(entry, std::uint32_t{0});
  entry.resize(AddressOfEntry(rank));
  Append(entry, chunk.begin);
  const std::string_view text = AsText(image), wanted = AsText(entry);
  const std::size_t found = text.find(wanted);
  if (found == text.npos || text.find(wanted, found + wanted.size()) != text.npos)
    return std::nullopt;
  return found;
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

ImageEditor::ImageEditor(std::vector<std::byte> image) : image_(std::move(image)) {
  if (image_.size() < kSuperblock || image_[kVersionAt] != std::byte{1} ||
      image_[kSizesAt] != std::byte{8} || image_[kSizesAt + 1] != std::byte{8} ||
      Get<std::uint64_t>(image_, kBaseAt) != 0 ||
      Get<std::uint64_t>(image_, kEndAt) != image_.size())
    throw Error("a file with another head");
}

template <typename Number>
void ImageEditor::Put(std::uint64_t at, Number number) {
  if (image_.size() < sizeof number || at > image_.size() - sizeof number)
    throw Error("a place outside of the file");
  std::memcpy(&image_[at], &number, sizeof number);
}

void ImageEditor::SetNumber(const NumberPlace& place, double value) {
  const double stored = AsStored(value, place.type);
  if (place.type == Type::kInt8) return Put(place.begin, static_cast<std::int8_t>(stored));
  if (place.type == Type::kInt32) return Put(place.begin, static_cast<std::int32_t>(stored));
  Put(place.begin, stored);
}

void ImageEditor::Align() { image_.resize(Aligned(image_.size())); }

ChunkPlace ImageEditor::SetChunk(std::uint64_t entry, std::size_t rank,
                                 std::span<const std::byte> bytes) {
  Align();
  const ChunkPlace place = {0, image_.size(), bytes.size()};
  image_.insert(image_.end(), bytes.begin(), bytes.end());
  Put(entry, static_cast<std::uint32_t>(bytes.size()));
  Put(entry + AddressOfEntry(rank), place.begin);
  return place;
}

void ImageEditor::SetText(std::uint64_t place, const std::string& text) {
  // HDF5 ends a text at its first NUL; empty texts are not in a heap.
  std::string ended = text.c_str();
  if (!ended.empty()) texts_.push_back({place, std::move(ended)});
}

// One collection with an object for each text.
void ImageEditor::AppendHeap() {
  if (texts_.empty()) return;
  Align();
  const std::uint64_t heap = image_.size();
  std::uint64_t used = kHeapHead;
  for (const HeapText& text : texts_) used += kHeapObjectHead + Aligned(text.text.size());
  const std::uint64_t bytes = std::max(kLeastHeap, used + kHeapObjectHead);
  for (const char c : kHeapSignature) image_.push_back(static_cast<std::byte>(c));
  Append(image_, bytes);
  std::uint16_t index = 0;
  const auto head = [this](std::uint16_t number, std::uint64_t size) {
    Append(image_, number);
    Append(image_, std::uint16_t{0});  // reference count
    Append(image_, std::uint32_t{0});
    Append(image_, size);
  };
  for (const HeapText& text : texts_) {
    head(++index, text.text.size());
    const auto raw = std::as_bytes(std::span(text.text));
    image_.insert(image_.end(), raw.begin(), raw.end());
    Align();
    Put(text.place, static_cast<std::uint32_t>(text.text.size()));
    Put(text.place + 4, heap);
    Put(text.place + 12, std::uint32_t{index});
  }
  head(0, bytes - used);  // the remaining space
  image_.resize(heap + bytes);
}

std::vector<std::byte> ImageEditor::Finish() {
  AppendHeap();
  Align();
  Put(kEndAt, std::uint64_t{image_.size()});
  return std::move(image_);
}

}  // namespace cdb::hdf5
