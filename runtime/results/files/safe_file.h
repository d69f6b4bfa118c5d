// Atomic files: written under a temporary name, synced and renamed, so that they exist completely
// or not at all. Independent of HDF5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/input_file.h"

namespace cdb::files {

/// Throws StoreError if `folder` is not a folder. `use`: its expected contents, for the message.
void RequireFolder(const std::filesystem::path& folder, std::string_view use);

/// Writes `text` to `final_name` atomically; a symbolic link there is followed.
/// Throws StoreError, with nothing changed.
void WriteWhole(std::string_view text, const std::filesystem::path& final_name);

/// Renames `file` to the first free name of `stem.1.ext`, `stem.2.ext` …, and returns it. Never
/// replaces a file. Throws StoreError, with nothing changed.
std::filesystem::path SetAside(const std::filesystem::path& file);
/// The name that SetAside would choose now.
std::filesystem::path NameAside(const std::filesystem::path& file);

/// The same as WriteWhole in pieces: `fill` is called once with a function that appends.
void WritePieces(const std::function<void(const std::function<void(std::string_view)>&)>& fill,
                 const std::filesystem::path& final_name);

// A file during writing: under a temporary name beside its final one, and locked, so that others
// can tell it from a file left by a killed process.

/// What a user can do after a write has failed with `error`, an errno.
std::string WriteRemedy(int error);

/// Created as `<final>.<host>.<number>.tmp`, beside the final file, so that the rename stays within
/// one file system. Its lock, not a process id, shows that it is being written: containers may
/// share host name and ids. Not thread-safe.
class TemporaryFile {
 public:
  /// A symbolic link at `final_name` is followed: the file that it points to is replaced. Throws
  /// StoreError if that is not a regular file (a device, a pipe, a folder), or no file can be
  /// created beside it.
  explicit TemporaryFile(const std::filesystem::path& final_name);
  /// Removes the file, unless it was published.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int fd() const { return fd_.get(); }

  /// Syncs the file, renames it to its final name and syncs the folder. Throws StoreError.
  void Publish();

  /// Throws StoreError with the file, the failed operation, the reason (an errno) and the remedy.
  [[noreturn]] void Fail(std::string_view doing, int error) const;

 private:
  /// False if a file of that name exists, or was removed before it was locked.
  bool TryMake();

  std::filesystem::path named_;  ///< as the caller named the final file
  std::filesystem::path final_;  ///< without links
  std::filesystem::path path_;
  plan::Descriptor fd_;
};

/// Removes temporaries of `final_name`, and of other `.h5` files beside it, that were left by
/// killed processes of this host. Locked files stay, and so do all files on a file system without
/// locks.
void RemoveStaleTemporariesBeside(const std::filesystem::path& final_name);

/// Removes temporaries in `folder` that were left by killed processes of this host. Those that are
/// still being written are locked and stay, and so do those of other hosts. Throws StoreError if
/// there is no folder.
void RemoveStaleTemporaries(const std::filesystem::path& folder);

}  // namespace cdb::files
