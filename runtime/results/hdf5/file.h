// A small layer over HDF5's C API, with the conventions of results files: creation order, text
// types, dimension scales. Only the files of this folder use HDF5. Threads: any, for different
// files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "runtime/results/hdf5/dataset.h"
#include "runtime/results/hdf5/object.h"

namespace cdb::hdf5 {

class Sink;

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

}  // namespace cdb::hdf5
