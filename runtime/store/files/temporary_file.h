// A file while it is written: under a temporary name beside its final one, and locked, so that
// others can tell it from what a killed process left behind.
#pragma once

#include <filesystem>
#include <string_view>

#include "compiler/plan/descriptor.h"

namespace cdb::files {

/// Made as `<final>.<host>.<number>.tmp`, beside the final file, so that the rename stays on one
/// file system. Its lock, not a process id, says that somebody writes it: containers may share
/// host name and ids. Not for several threads.
class TemporaryFile {
 public:
  /// A symbolic link at `final_name` is followed: the file that it points to is replaced. Throws
  /// StoreError where that is no regular file (a device, a pipe, a folder), or nothing can be made
  /// beside it.
  explicit TemporaryFile(const std::filesystem::path& final_name);
  /// Removes the file, unless it was published.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int fd() const { return fd_.get(); }

  /// fsyncs it, gives it its final name and fsyncs the folder. Throws StoreError.
  void Publish();

  /// Throws StoreError: the file, what could not be done, why (an errno) and the remedy.
  [[noreturn]] void Fail(std::string_view doing, int error) const;

 private:
  /// False where a file of that name is there, or was removed before it was locked.
  bool TryMake();

  std::filesystem::path named_;  ///< as the caller named the final file
  std::filesystem::path final_;  ///< without links
  std::filesystem::path path_;
  plan::Descriptor fd_;
};

/// Removes the temporaries of `final_name`, and those of other `.h5` files beside it, that killed
/// processes of this host left. What is locked stays, and so does everything on a file system
/// without locks.
void RemoveStaleTemporariesBeside(const std::filesystem::path& final_name);

/// Removes temporaries in `folder` that processes of this host left behind when they were killed.
/// Those that somebody still writes are locked and stay and so do those of
/// other hosts. Throws StoreError where there is no folder.
void RemoveStaleTemporaries(const std::filesystem::path& folder);

}  // namespace cdb::files
