// A cache of expensive results, in files named after the hash of their inputs. Any number of
// processes may share a folder.
//
// What is found decides results, so only the user can have put it there: folder and entries are
// his own, nobody else may write to them, and an entry is bound to its kind, its key and a secret
// of the folder, so that none that was made elsewhere is taken.
//
// Errors: none; a damaged or foreign file counts as not there, and where the folder cannot be
// written or is not safe nothing is kept. Threads: any.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/plan/descriptor.h"

namespace cdb::library {

/// `$CDB_CACHE`, else `$XDG_CACHE_HOME/cdb`, else `$HOME/.cache/cdb`; empty where none is set.
std::filesystem::path CacheFolder();

/// Why the folder is not used, and what to do; empty where it is, or is not there yet.
std::string CacheFault(const std::filesystem::path& folder);

/// 64 hex digits of a hash of all that something depends on.
std::string CacheKeyOf(std::string_view bytes);

/// `kind` is the extension (`hulls`), `key` one of CacheKeyOf; an empty folder holds nothing.
std::optional<std::string> FindCached(const std::filesystem::path& folder, std::string_view kind,
                                      std::string_view key);
/// The folder is made where it is missing. False, with nothing left behind, where that cannot be
/// done or the folder is empty.
bool StoreCached(const std::filesystem::path& folder, std::string_view kind, std::string_view key,
                 std::string_view contents);

/// Held by the one process that makes an entry, so that others which need it wait and then find it.
/// Let go of when the process ends, however it ends. Nothing is locked where the folder is empty,
/// cannot be written or its file system has no locks: then each makes its own. Not for several
/// threads.
class CacheLock {
 public:
  /// Returns when no other process holds it; calls `on_wait` once, if it has to wait.
  CacheLock(const std::filesystem::path& folder, std::string_view kind, std::string_view key,
            const std::function<void()>& on_wait);
  ~CacheLock();
  CacheLock(const CacheLock&) = delete;
  CacheLock& operator=(const CacheLock&) = delete;

  bool IsHeld() const { return fd_.get() >= 0; }

 private:
  bool TakeOrForget(const std::function<void()>& on_wait);

  std::filesystem::path file_;  ///< there while somebody holds it
  plan::Descriptor fd_;
};

}  // namespace cdb::library
