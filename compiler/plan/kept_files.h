// What a file contained, kept in memory by programs that compile a text again and again while it is
// typed.
//
// A file counts as unchanged if its device, inode, size and times are. Nothing is kept until
// KeepFiles is called. Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace cdb::plan {

/// The most bytes of files whose results are kept, for each kind of result.
void KeepFiles(std::uint64_t bytes);
std::uint64_t KeptBytes();

/// Identifies a version of a file.
struct FileStamp {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;
  bool operator==(const FileStamp&) const = default;
  /// Nullopt if there is no such file, or what it contains is in several files.
  static std::optional<FileStamp> Of(const std::string& path);
};

template <typename Result>
class FileMemo {
 public:
  /// The result of `make`, which reads the file at `path`, or of an earlier call with this `key` if
  /// the file is unchanged since. Throws what `make` throws, and keeps nothing then.
  template <typename Make>
  Result Of(const std::string& path, const std::string& key, Make make) {
    const std::optional<FileStamp> stamp = KeptBytes() > 0 ? FileStamp::Of(path) : std::nullopt;
    if (stamp)
      if (std::optional<Result> found = Find(path, key, *stamp)) return *std::move(found);
    Result result = make();
    const std::lock_guard lock(mutex_);
    ++readings_;
    if (stamp) Store({path, key, *stamp, result});
    return result;
  }
  /// The number of calls of a `make` that returned.
  std::size_t readings() const {
    const std::lock_guard lock(mutex_);
    return readings_;
  }

 private:
  struct Entry {
    std::string path, key;
    FileStamp stamp;
    Result result;
  };

  std::optional<Result> Find(const std::string& path, const std::string& key,
                             const FileStamp& stamp) {
    const std::lock_guard lock(mutex_);
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry)
      if (entry->path == path && entry->key == key && entry->stamp == stamp) {
        entries_.splice(entries_.begin(), entries_, entry);
        return entry->result;
      }
    return std::nullopt;
  }
  void Store(Entry stored) {
    // Other versions of the file do not come back.
    entries_.remove_if([&](const Entry& entry) {
      return entry.path == stored.path && (entry.key == stored.key || entry.stamp != stored.stamp);
    });
    entries_.push_front(std::move(stored));
    std::uint64_t bytes = 0;
    auto entry = entries_.begin();
    while (entry != entries_.end() && (bytes += entry->stamp.size) <= KeptBytes()) ++entry;
    entries_.erase(entry, entries_.end());
  }

  mutable std::mutex mutex_;
  std::list<Entry> entries_;  ///< the last used one first
  std::size_t readings_ = 0;
};

}  // namespace cdb::plan
