// A small layer over HDF5's C API, with the conventions of results files: creation order, text
// types, dimension scales. Only the files of this folder use HDF5. Threads: any, for different
// files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "runtime/results/hdf5/dataset.h"
#include "runtime/results/hdf5/object.h"

namespace cdb::hdf5 {

class Sink;

/// The numbers of an array, row by row.
struct Numbers {
  Shape shape;
  std::vector<double> values;
  bool is_from_matlab = false;  ///< which stores arrays transposed
};

class Group : public Object {
 public:
  /// `foreign_bytes`: as in Dataset.
  explicit Group(Id id, std::uint64_t foreign_bytes = 0)
      : Object(std::move(id)), foreign_bytes_(foreign_bytes) {}
  bool Has(const std::string& name) const;
  /// The names of its datasets and groups, sorted.
  std::vector<std::string> MemberNames() const;
  /// Throws Error for a type that results files do not have.
  Dataset OpenDataset(const std::string& name) const;
  /// An array that another program wrote, of integers or floats of any size and byte order; `path`
  /// such as `/robot/position`, or `/log/x` for a member of the rows of `/log`. Follows no links.
  Numbers ReadNumbers(const std::string& path) const;
  /// The text attribute of a member; empty if there is none.
  std::string TextOfMember(const std::string& member, const char* attribute) const;
  /// The first `most` arrays in it and in its groups, with their shapes.
  std::vector<std::string> ListArrays(std::size_t most) const;
  Dataset CreateDataset(const DatasetSpec& spec);
  Group OpenGroup(const std::string& name) const;
  Group CreateGroup(const std::string& name);

  /// Attaches scales to datasets of this group: `scales` names one for each dimension. All at once,
  /// because attaching them one by one takes HDF5 longer than everything else in a small file.
  struct Attachment {
    std::string dataset;
    std::vector<std::string> scales;
  };
  void AttachScales(const std::vector<Attachment>& attachments);

  /// The names of all members. Throws Error if one leads out of the group.
  struct Names {
    std::vector<std::string> datasets, groups;
  };
  Names List() const;

 protected:
  std::uint64_t foreign_bytes_;
};

/// True if the file begins with the HDF5 signature.
bool IsHdf5(const std::filesystem::path& path);

/// An open file; also its root group.
class File : public Group {
 public:
  /// Throws Error, as all of these do; an existing file is overwritten.
  ///
  /// HDF5 cannot close a file that it cannot write, and then crashes when the process ends. A
  /// failed write is therefore recorded and reported to HDF5 as successful, and CheckWritten
  /// throws.
  static File Create(const std::filesystem::path& path);
  /// Treats the file as foreign: it may come from anywhere.
  static File Open(const std::filesystem::path& path);

  File(File&&) noexcept = default;
  ~File();

  /// Throws Error if a write has failed so far.
  void CheckWritten() const;
  /// The same after everything is written and the file is closed.
  void Close();

 private:
  explicit File(Id file, std::shared_ptr<Sink> sink = nullptr, std::uint64_t foreign_bytes = 0);
  std::shared_ptr<Sink> sink_;
  Id file_;
};

// The size of a data set's chunks.

/// One chunk fits HDF5's chunk cache of 1 MiB.
inline constexpr std::uint64_t kLargestChunk = (1 << 20) - 1;

/// Splits dimension `i` of a chunk evenly into the fewest pieces of at most `kLargestChunk` bytes;
/// into single items if even those are too large.
void SplitEvenly(Shape& chunk, std::size_t i, std::size_t item_bytes);

// The destination of a file that HDF5 writes: a driver whose writes never fail, and which keeps the
// first error. See File::Create.

/// A file that is written from scratch. Not thread-safe.
class Sink {
 public:
  explicit Sink(const std::filesystem::path& path);
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  ~Sink() { Close(); }

  /// Throws Error for the first failure.
  void Check() const;
  void Close();

  // For the driver. Addresses are bytes from the beginning of the file.

  /// Bytes that were never written read as zeros, as in any file. False if the system fails.
  bool Read(std::uint64_t address, std::size_t bytes, char* out) const;
  void Write(std::uint64_t address, std::size_t bytes, const char* data);
  void Truncate(std::uint64_t size);
  std::uint64_t end() const { return end_; }

 private:
  int fd_;
  int error_ = 0;
  std::uint64_t end_ = 0;
};

/// Directs a file that is created with the file access properties `access` to `sink`, whose address
/// must not change before that. Negative if HDF5 fails.
int SetSink(std::int64_t access, const std::shared_ptr<Sink>& sink);

}  // namespace cdb::hdf5
