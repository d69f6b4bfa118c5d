// A small layer over HDF5's C API: identifiers that close themselves, errors that are thrown, and
// the conventions of results files (creation order, text types, dimension scales). Beside hdf5_sink
// the only files that know HDF5. Threads: any, for different files (Debian's HDF5 takes a global
// lock).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::hdf5 {

class Sink;

/// What HDF5 or the system below it said.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How values stand in the file. Text is UTF-8 of variable length.
enum class Type { kInt8, kInt32, kFloat32, kFloat64, kText };
std::size_t ItemBytes(Type type);

using Shape = std::vector<std::uint64_t>;
std::uint64_t Product(const Shape& shape);

/// An identifier of HDF5, closed at the end.
class Id {
 public:
  using Close = int (*)(std::int64_t);
  Id() = default;
  /// Throws Error where `id` is negative.
  Id(std::int64_t id, Close close, std::string_view doing);
  Id(Id&& other) noexcept;
  Id& operator=(Id&& other) noexcept;
  ~Id() { Reset(); }
  std::int64_t get() const { return id_; }
  /// False where closing failed.
  bool Reset();

 private:
  std::int64_t id_ = -1;
  Close close_ = nullptr;
};

/// Whatever can have attributes.
class Object {
 public:
  /// Scalar, fixed length, null-padded, UTF-8. Empty text makes no attribute; text past 32 kB is
  /// cut at a character (HDF5 has room for 64 kB in all).
  void SetText(const char* name, std::string_view text);
  void SetNumber(const char* name, Type type, double value);
  void SetNumbers(const char* name, Type type, std::span<const double> values);
  /// Empty where there is none of that name, or none that is text.
  std::string Text(const char* name) const;
  /// NaN where there is none of that name.
  double Number(const char* name) const;
  /// Every text attribute.
  std::map<std::string, std::string> Texts() const;

 protected:
  explicit Object(Id id) : id_(std::move(id)) {}
  Id id_;
};

/// A chunk as it stands in the file, filtered.
struct RawChunk {
  std::uint32_t filter_mask = 0;
  std::vector<std::byte> bytes;
};

class Dataset : public Object {
 public:
  explicit Dataset(Id id);
  const Shape& shape() const { return shape_; }
  Type type() const { return type_; }
  /// Empty where it is not chunked.
  Shape ChunkShape() const;

  /// All of it; numbers are converted, and must be as many as it holds.
  void Write(std::span<const double> values);
  void WriteText(std::span<const std::string> values);
  std::vector<double> Read() const;
  std::vector<std::string> ReadText() const;

  /// The block of `count` from `start`, numbers as doubles.
  std::vector<double> Read(const Shape& start, const Shape& count) const;
  void Write(const Shape& start, const Shape& count, std::span<const double> values);
  /// Writes the first `count` of each dimension of `data`, an array of shape `data_shape` and of
  /// this dataset's type, to `start`.
  void Write(const Shape& start, const Shape& count, const std::byte* data,
             const Shape& data_shape);

  /// `start` is the chunk's first element. False where the file holds no such chunk.
  bool ReadChunk(const Shape& start, RawChunk& chunk) const;
  void WriteChunk(const Shape& start, const RawChunk& chunk);

  /// Makes it a dimension scale of that name.
  void MakeScale(const std::string& name);

 private:
  Type type_;
  Shape shape_;
};

struct DatasetSpec {
  std::string name;
  Type type = Type::kFloat64;
  Shape shape;      ///< empty: a scalar
  Shape chunk;      ///< empty: contiguous; else shuffled and compressed
  double fill = 0;  ///< numbers only
};

class Group : public Object {
 public:
  explicit Group(Id id) : Object(std::move(id)) {}
  bool Has(const std::string& name) const;
  /// Refuses (Error) a type that results files do not have.
  Dataset OpenDataset(const std::string& name) const;
  Dataset CreateDataset(const DatasetSpec& spec);
  Group OpenGroup(const std::string& name) const;
  Group CreateGroup(const std::string& name);

  /// Attaches scales to datasets of this group: `scales` names one for each dimension. All at once:
  /// one by one HDF5 takes longer over it than over everything else in a shard.
  struct Attachment {
    std::string dataset;
    std::vector<std::string> scales;
  };
  void AttachScales(const std::vector<Attachment>& attachments);
  /// One more array after that, of a group in this one: `group/name`.
  void AttachScalesLate(const Attachment& attachment);
};

/// An open file; also its root group.
class File : public Group {
 public:
  /// In memory only; see Image.
  static File CreateInMemory();
  /// Throws Error, as all of these; an existing file is overwritten.
  ///
  /// HDF5 cannot close a file that it cannot write, and then crashes when the process ends. So a
  /// write that fails is taken note of, HDF5 is told that all is well, and CheckWritten throws.
  static File Create(const std::filesystem::path& path);
  static File Open(const std::filesystem::path& path);
  /// Reads from a copy of `image`.
  static File OpenImage(std::span<const std::byte> image);

  File(File&&) noexcept = default;
  ~File();

  /// The bytes of a file in memory.
  std::vector<std::byte> Image();
  /// Throws Error where something could not be written so far.
  void CheckWritten() const;
  /// The same when all is written and the file closed.
  void Close();

 private:
  explicit File(Id file, std::shared_ptr<Sink> sink = nullptr);
  std::shared_ptr<Sink> sink_;
  Id file_;
};

}  // namespace cdb::hdf5
