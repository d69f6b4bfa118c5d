// Writes values into the bytes of an HDF5 file in memory, where HDF5 made room for them: what a
// file of sixty small arrays takes HDF5 longest is to open them one by one.
//
// Source: HDF5 File Format Specification 3.0: superblock version 1 (II.A), version 1 B-tree of
// chunks (III.A.1), global heap (III.E). None of these has a checksum; what has one is left to
// HDF5.
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

/// Where the number of an array with one element stands.
struct NumberPlace {
  std::uint64_t begin = 0;
  Type type = Type::kFloat64;
};

/// A number as an array of `type` holds it.
double AsStored(double value, Type type);

/// `dataset` has one element, which has been written. Nullopt if it has no place of its own.
std::optional<NumberPlace> FindNumber(const Dataset& dataset);

/// Where `image`, the bytes of the file, says where the chunk is that begins at 0 in all `rank`
/// dimensions and stands at `chunk` without any filter left out; nullopt if that is not certain.
std::optional<std::uint64_t> FindChunkEntry(std::span<const std::byte> image,
                                            const ChunkPlace& chunk, std::size_t rank);

/// What a dataset with filters stores of `values`, of `item_bytes` each: shuffled and compressed,
/// with a checksum behind it (III.A.2 and the filter pipeline message, IV.A.2.l).
std::vector<std::byte> Filtered(std::span<const std::byte> values, std::size_t item_bytes);

/// Not for several threads.
class ImageEditor {
 public:
  /// The bytes of a whole file. Throws Error if its superblock is of another version.
  explicit ImageEditor(std::vector<std::byte> image);

  void SetNumber(const NumberPlace& place, double value);
  /// The chunk that the entry names is `bytes` from now on, which are appended. Returns where.
  ChunkPlace SetChunk(std::uint64_t entry, std::size_t rank, std::span<const std::byte> bytes);
  /// The text at `place`, of an array with one element, is `text`. To be called once for each.
  void SetText(std::uint64_t place, const std::string& text);
  /// The bytes of the file with all of it.
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
