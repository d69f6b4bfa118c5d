// Writes values into the bytes of an HDF5 file in memory, at places that HDF5 has reserved. For a
// file of sixty small arrays, opening them one by one takes HDF5 the longest.
//
// Source: HDF5 File Format Specification 3.0: superblock version 3 (II.A), global heap (III.E); for
// object headers, see object_header.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/store/hdf5/dataset.h"
#include "runtime/store/hdf5/object.h"
#include "runtime/store/hdf5/object_header.h"

namespace cdb::hdf5 {

/// The position of the number of an array with one element.
struct NumberPlace {
  std::uint64_t begin = 0;
  Type type = Type::kFloat64;
};

/// A number after conversion to `type`.
double AsStored(double value, Type type);

/// The stored form of `values`, of `item_bytes` each, in a dataset with filters: shuffled and
/// compressed, followed by a checksum (III.A.2 and the filter pipeline message, IV.A.2.l).
std::vector<std::byte> Filtered(std::span<const std::byte> values, std::size_t item_bytes);

/// The bytes of a complete file, and the places in them that can be changed. Threads: any, once all
/// places are found.
class EditableImage {
 public:
  /// Throws Error if the superblock has another version.
  explicit EditableImage(std::vector<std::byte> image);

  // Each throws Error for an object that is not stored as described.

  /// Of a dataset with one number in its header.
  NumberPlace FindNumber(const Dataset& dataset);
  /// Of a dataset with texts in its header: of the first one. The others follow, kTextBytes each.
  std::uint64_t FindTexts(const Dataset& dataset);
  /// Of a dataset with filters and one chunk.
  std::uint64_t FindChunk(const Dataset& dataset);
  Extent FindAttribute(const Object& object, std::string_view name);

  static constexpr std::uint64_t kTextBytes = 16;

 private:
  friend class ImageEditor;
  ObjectHeader HeaderOf(const Object& object);

  std::vector<std::byte> bytes_;
  std::map<std::uint64_t, std::vector<Extent>> checked_;  ///< blocks with checksums, by object
};

/// A copy of an image with other values. Not thread-safe.
class ImageEditor {
 public:
  /// `image` must outlive it.
  explicit ImageEditor(const EditableImage& image) : image_(image), bytes_(image.bytes_) {}

  void SetNumber(const NumberPlace& place, double value);
  /// Stores the chunk at `place`. Returns its position.
  ChunkPlace SetChunk(std::uint64_t place, std::span<const std::byte> bytes);
  /// Call once for each place.
  void SetText(std::uint64_t place, const std::string& text);
  /// Throws Error if the attribute has another length.
  void SetAttribute(const Extent& place, std::string_view text);
  /// The bytes of the file with all changes.
  std::vector<std::byte> Finish();

 private:
  template <typename Number>
  void Put(std::uint64_t at, Number number);
  void Align();
  void AppendHeap();

  struct HeapText {
    std::uint64_t place;
    std::string text;
  };
  const EditableImage& image_;
  std::vector<std::byte> bytes_;
  std::vector<HeapText> texts_;
};

}  // namespace cdb::hdf5
