// Arrays in an HDF5 file. Throws Error. Threads: any, for different files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/store/hdf5/object.h"

namespace cdb::hdf5 {

/// The bit of a filter mask that says that a chunk has no checksum: of chunks of shards that were
/// written before there were any.
inline constexpr std::uint32_t kNoChecksum = 1u << 2;

/// A chunk as it stands in the file, filtered.
struct RawChunk {
  std::uint32_t filter_mask = 0;
  std::vector<std::byte> bytes;
};

/// Where a chunk stands in its file.
struct ChunkPlace {
  std::uint32_t filter_mask = 0;
  std::uint64_t begin = 0, bytes = 0;
};

class Dataset : public Object {
 public:
  /// `foreign_bytes`: length of the file that holds it, where anybody may have written it; 0 where
  /// this process did. Throws Error for what cdb never writes.
  explicit Dataset(Id id, std::uint64_t foreign_bytes = 0);
  const Shape& shape() const { return shape_; }
  Type type() const { return type_; }
  /// Empty where it is not chunked.
  Shape ChunkShape() const;
  /// Its chunks have Fletcher-32 checksums.
  bool HasChecksums() const;

  /// All of it; numbers are converted, and must be as many as it holds.
  void Write(std::span<const double> values);
  void WriteText(std::span<const std::string> values);
  std::vector<double> Read() const;
  std::vector<std::string> ReadText() const;

  /// Throws Error where a file of somebody else cannot hold so many `values` of it.
  void CheckCount(std::uint64_t values) const;

  /// The block of `count` from `start`, numbers as doubles.
  std::vector<double> Read(const Shape& start, const Shape& count) const;
  void Write(const Shape& start, const Shape& count, std::span<const double> values);
  /// Writes the first `count` of each dimension of `data`, an array of shape `data_shape` and of
  /// this dataset's type, to `start`.
  void Write(const Shape& start, const Shape& count, const std::byte* data,
             const Shape& data_shape);

  /// The file holds the chunk whose first element is `start`.
  bool HasChunk(const Shape& start) const;
  /// `start` is the chunk's first element. False where the file holds no such chunk.
  bool ReadChunk(const Shape& start, RawChunk& chunk) const;
  void WriteChunk(const Shape& start, std::uint32_t filter_mask, std::span<const std::byte> bytes);
  /// Nullopt where the file holds no such chunk. The file must have been flushed. HDF5 looks
  /// through all chunks of the dataset: for datasets of few.
  std::optional<ChunkPlace> FindChunk(const Shape& start) const;

  /// Where its values stand in the file; nullopt where they are chunked or have no place yet.
  std::optional<std::uint64_t> FindValues() const;

  /// Makes it a dimension scale of that name.
  void MakeScale(const std::string& name);

 private:
  std::uint64_t foreign_bytes_;
  Type type_;
  Shape shape_;
};

struct DatasetSpec {
  std::string name;
  Type type = Type::kFloat64;
  Shape shape;      ///< empty: a scalar
  Shape chunk;      ///< empty: contiguous; else shuffled, compressed, with checksums
  double fill = 0;  ///< numbers only
};

}  // namespace cdb::hdf5
