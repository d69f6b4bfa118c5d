// A small layer over HDF5's C API, with the conventions of results files: creation order, text
// types, dimension scales. The files of this folder are the only ones that know HDF5. Threads: any,
// for different files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "runtime/store/hdf5/dataset.h"
#include "runtime/store/hdf5/object.h"

namespace cdb::hdf5 {

class Sink;

class Group : public Object {
 public:
  /// `foreign_bytes`: as of Dataset.
  explicit Group(Id id, std::uint64_t foreign_bytes = 0)
      : Object(std::move(id)), foreign_bytes_(foreign_bytes) {}
  bool Has(const std::string& name) const;
  /// Of the datasets and groups in it, sorted.
  std::vector<std::string> MemberNames() const;
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

  /// The names of everything in it. Throws Error where one leads out of the group.
  struct Names {
    std::vector<std::string> datasets, groups;
  };
  Names List() const;

 protected:
  std::uint64_t foreign_bytes_;
};

/// The file begins as HDF5 does.
bool IsHdf5(const std::filesystem::path& path);

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
  /// This and OpenImage take a file for foreign: anybody may have written it.
  static File Open(const std::filesystem::path& path);
  /// Reads from a copy of `image`.
  static File OpenImage(std::span<const std::byte> image);
  /// In memory only, as CreateInMemory; begins as a copy of `image`.
  static File CopyImage(std::span<const std::byte> image);

  File(File&&) noexcept = default;
  ~File();

  /// Everything written so far, where Dataset::FindChunk and Image find it.
  void Flush();
  /// The bytes of a file in memory.
  std::vector<std::byte> Image();
  /// Throws Error where something could not be written so far.
  void CheckWritten() const;
  /// The same when all is written and the file closed.
  void Close();

 private:
  explicit File(Id file, std::shared_ptr<Sink> sink = nullptr, std::uint64_t foreign_bytes = 0);
  static File OpenCopy(std::span<const std::byte> image, unsigned mode);
  std::shared_ptr<Sink> sink_;
  Id file_;
};

}  // namespace cdb::hdf5
