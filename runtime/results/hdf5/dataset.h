// Arrays in an HDF5 file. Throws Error. Threads: any, for different files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/results/hdf5/object.h"

namespace cdb::hdf5 {

/// The bytes of a chunk as stored in the file, filtered.
struct RawChunk {
  std::uint32_t filter_mask = 0;
  std::vector<std::byte> bytes;
};

class Dataset : public Object {
 public:
  /// `foreign_bytes`: length of the file that holds it if the file may come from anywhere; 0 if
  /// this process wrote it. Throws Error for properties that cdb never writes.
  explicit Dataset(Id id, std::uint64_t foreign_bytes = 0);
  const Shape& shape() const { return shape_; }
  Type type() const { return type_; }
  /// Empty if it is not chunked.
  Shape ChunkShape() const;

  /// Writes the whole array. Numbers are converted; their count must match.
  void Write(std::span<const double> values);
  void WriteText(std::span<const std::string> values);
  std::vector<double> Read() const;
  std::vector<std::string> ReadText() const;

  /// Throws Error if a foreign file is too short for this number of `values`.
  void CheckCount(std::uint64_t values) const;

  /// The block of `count` from `start`, with numbers as doubles.
  std::vector<double> Read(const Shape& start, const Shape& count) const;
  void Write(const Shape& start, const Shape& count, std::span<const double> values);
  /// Writes the first `count` of each dimension of `data`, an array of shape `data_shape` and of
  /// this dataset's type, to `start`.
  void Write(const Shape& start, const Shape& count, const std::byte* data,
             const Shape& data_shape);

  using VisitPart = std::function<void(const Shape& start, const Shape& count)>;
  /// Calls `visit` for every chunk that the file holds; the dataset must be chunked. Chunks that
  /// were never written are left out: they hold fill values, and a small file can claim any number
  /// of them.
  void ForEachStoredChunk(const VisitPart& visit) const;
  /// `start` is the chunk's first element. False if the file holds no such chunk.
  bool ReadChunk(const Shape& start, RawChunk& chunk) const;
  void WriteChunk(const Shape& start, std::uint32_t filter_mask, std::span<const std::byte> bytes);

  /// Makes it a dimension scale with that name.
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

// Rejects features that files written by cdb never have, before HDF5 acts on them: values outside
// of the file, filters of third-party libraries, types that need a conversion, and arrays that are
// larger than their file can hold. Included only by the sources of this folder.

/// Disables external links and the loading of filters in HDF5, for the whole process.
void CloseBackdoors();

/// Throws Error if a link in the group `id` leads out of it, or is of a kind that files of cdb do
/// not have.
void CheckLinks(const Id& group);

/// The types of value that an array may have: those of cdb, or also other numbers and compounds.
enum class Accept { kOurs, kNumbers };
/// `file_bytes`: length of the file that holds `dataset`. Throws Error.
void CheckStorage(const Id& dataset, std::uint64_t file_bytes, Accept accept = Accept::kOurs);

/// The same check before `values` of `item_bytes` each are read at once.
void CheckReadable(const Id& dataset, std::uint64_t values, std::uint64_t item_bytes,
                   std::uint64_t file_bytes);

}  // namespace cdb::hdf5
