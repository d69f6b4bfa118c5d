// A cache of expensive results, in files named after the hash of their inputs. Any number of
// processes may share a folder.
//
// Cached data determines results, so only the user may be able to write it: folder and entries must
// be owned by the user and writable by nobody else. An entry names its kind and its key, and ends
// with a digest of all its bytes.
//
// Errors: none; a damaged or foreign file counts as missing, and nothing is stored if the folder
// cannot be written or is not safe. Threads: any.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/plan/input_file.h"

namespace cdb::library {

/// `$CDB_CACHE`, else `$XDG_CACHE_HOME/cdb`, else `$HOME/.cache/cdb`; empty if none is set.
std::filesystem::path CacheFolder();

/// The reason why the folder is not used, and a remedy; empty if it is used, or does not exist yet.
std::string CacheFault(const std::filesystem::path& folder);

/// 64 hex digits, a hash of everything that a result depends on.
std::string CacheKeyOf(std::string_view bytes);

/// `kind` is the extension (`hulls`), `key` one of CacheKeyOf; an empty folder holds nothing.
std::optional<std::string> FindCached(const std::filesystem::path& folder, std::string_view kind,
                                      std::string_view key);
/// Creates the folder if it is missing. False, with nothing left behind, if that fails or `folder`
/// is empty.
bool StoreCached(const std::filesystem::path& folder, std::string_view kind, std::string_view key,
                 std::string_view contents);

/// Held by the process that makes an entry, so that others that need it wait and then find it.
/// Released at the end of the process in any case. Nothing is locked if the folder is empty or
/// cannot be written or its file system has no locks: each process then makes its own entry. Not
/// thread-safe.
class CacheLock {
 public:
  /// Returns when no other process holds it; calls `on_wait` once if it has to wait.
  CacheLock(const std::filesystem::path& folder, std::string_view kind, std::string_view key,
            const std::function<void()>& on_wait);
  ~CacheLock();
  CacheLock(const CacheLock&) = delete;
  CacheLock& operator=(const CacheLock&) = delete;

  bool IsHeld() const { return fd_.get() >= 0; }

 private:
  bool TryLock(const std::function<void()>& on_wait);

  std::filesystem::path file_;  ///< exists while it is held
  plan::Descriptor fd_;
};

}  // namespace cdb::library
