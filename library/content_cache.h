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

#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

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

/// Appends the values passed to it, for an entry that is the same on every machine.
class ByteWriter {
 public:
  void Word(std::uint64_t word) {
    for (int i = 0; i < 8; ++i) bytes_ += static_cast<char>(word >> 8 * i & 0xff);
  }
  void Real(double real) { Word(std::bit_cast<std::uint64_t>(real)); }
  void Size(const auto& items) { Word(items.size()); }
  void Index(std::uint32_t index) { Word(index); }
  void Character(char c) { bytes_ += c; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Restores the values that ByteWriter stored.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  void Real(double& real) { real = std::bit_cast<double>(Next()); }
  void Size(auto& items) {
    // The data are those written; the limit guards against our own errors.
    const std::uint64_t size = Next();
    is_good_ = is_good_ && size <= bytes_.size();
    items.resize(is_good_ ? size : 0);
  }
  void Index(std::uint32_t& index) { index = static_cast<std::uint32_t>(Next()); }
  void Character(char& c) {
    is_good_ = is_good_ && !bytes_.empty();
    if (!is_good_) return;
    c = bytes_[0];
    bytes_.remove_prefix(1);
  }
  bool IsDone() const { return is_good_ && bytes_.empty(); }

 private:
  std::uint64_t Next() {
    is_good_ = is_good_ && bytes_.size() >= 8;
    if (!is_good_) return 0;
    std::uint64_t word = 0;
    for (std::size_t i = 8; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes_[i]);
    bytes_.remove_prefix(8);
    return word;
  }

  std::string_view bytes_;
  bool is_good_ = true;
};

}  // namespace cdb::library
