// Writes values into the bytes of an HDF5 file in memory, at places that HDF5 has reserved. For a
// file of sixty small arrays, opening them one by one takes HDF5 the longest.
//
// Source: HDF5 File Format Specification 3.0: superblock version 1 (II.A), version 1 B-tree of
// chunks (III.A.1), global heap (III.E). None of these has a checksum; structures with one are left
// to HDF5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/store/hdf5/dataset.h"
#include "runtime/store/hdf5/file.h"

namespace cdb::hdf5 {

/// The position of the number of an array with one element.
struct NumberPlace {
  std::uint64_t begin = 0;
  Type type = Type::kFloat64;
};

/// A number after conversion to `type`.
double AsStored(double value, Type type);

/// `dataset` has one element, which has been written. Nullopt if it has no address.
std::optional<NumberPlace> FindNumber(const Dataset& dataset);

/// The position in `image`, the bytes of the file, of the index entry for the chunk that begins at
/// 0 in all `rank` dimensions and is stored at `chunk` with all filters applied; nullopt if it is
/// ambiguous.
std::optional<std::uint64_t> FindChunkEntry(std::span<const std::byte> image,
                                            const ChunkPlace& chunk, std::size_t rank);

/// The stored form of `values`, of `item_bytes` each, in a dataset with filters: shuffled and
/// compressed, followed by a checksum (III.A.2 and the filter pipeline message, IV.A.2.l).
std::vector<std::byte> Filtered(std::span<const std::byte> values, std::size_t item_bytes);

/// Not thread-safe.
class ImageEditor {
 public:
  /// The bytes of a complete file. Throws Error if its superblock has another version.
  explicit ImageEditor(std::vector<std::byte> image);

  void SetNumber(const NumberPlace& place, double value);
  /// Replaces the chunk of the entry by `bytes`, which are appended. Returns their position.
  ChunkPlace SetChunk(std::uint64_t entry, std::size_t rank, std::span<const std::byte> bytes);
  /// Sets the text of the array with one element at `place`. Call once for each place.
  void SetText(std::uint64_t place, const std::string& text);
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
  std::vector<std::byte> image_;
  std::vector<HeapText> texts_;
};

}  // namespace cdb::hdf5
