#include "library/content_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

#include "compiler/plan/input_file.h"

namespace cdb::library {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigest = 64;  // hex digits

fs::path FileOf(const fs::path& folder, std::string_view kind, std::string_view key) {
  return folder / fmt::format("{}.{}", key, kind);
}

/// The beginning of a file; to be incremented with every change of its layout.
std::string HeadOf(std::string_view kind, std::string_view key) {
  return fmt::format("cdb {} 4\n{}", kind, key);
}

bool IsOfUserAlone(const struct stat& status) {
  return status.st_uid == geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

bool IsSafeFolder(const fs::path& folder) {
  struct stat status = {};
  return !folder.empty() && stat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         IsOfUserAlone(status);
}

/// Creates the folder if it is missing, accessible only to the user. False if it is not safe.
bool MakeFolder(const fs::path& folder) {
  std::error_code error;
  if (folder.empty()) return false;
  if (folder.has_parent_path()) fs::create_directories(folder.parent_path(), error);
  mkdir(folder.c_str(), S_IRWXU);
  return IsSafeFolder(folder);
}

/// The bytes of a file owned by the user; nullopt for any other.
std::optional<std::string> ReadOwn(const fs::path& path) {
  const plan::Descriptor file(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status = {};
  if (file.get() < 0 || fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode) ||
      !IsOfUserAlone(status))
    return std::nullopt;
  std::string why;
  return plan::ReadInput(file.get(), why);
}

bool WriteAllTo(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

/// Writes a file under a temporary name and renames it. A leftover from a killed process under that
/// name is overwritten; if another process is writing it, nothing is done.
bool WriteOwn(const fs::path& path, std::string_view bytes) {
  const fs::path temporary = path.string() + ".tmp";
  const plan::Descriptor file(
      open(temporary.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (file.get() < 0) return false;
  // Without locks in the file system, a mixture of two writes fails the check of its digest.
  if (flock(file.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
  if (!plan::IsAt(file.get(), temporary)) return false;
  const bool is_written = ftruncate(file.get(), 0) == 0 && WriteAllTo(file.get(), bytes);
  if (is_written && rename(temporary.c_str(), path.c_str()) == 0) return true;
  unlink(temporary.c_str());
  return false;
}

}  // namespace

fs::path CacheFolder() {
  const auto set = [](const char* name) -> std::string_view {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  if (const auto folder = set("CDB_CACHE"); !folder.empty()) return folder;
  // The XDG base directory specification says that a relative path must be ignored.
  if (const auto folder = set("XDG_CACHE_HOME"); folder.starts_with('/'))
    return fs::path(folder) / "cdb";
  if (const auto home = set("HOME"); !home.empty()) return fs::path(home) / ".cache" / "cdb";
  return {};
}

std::string CacheKeyOf(std::string_view bytes) { return plan::Sha256Hex(bytes); }

std::string CacheFault(const fs::path& folder) {
  struct stat status = {};
  if (folder.empty() || stat(folder.c_str(), &status) != 0 || IsSafeFolder(folder)) return {};
  if (!S_ISDIR(status.st_mode))
    return fmt::format("the cache '{}' is not a folder and is not used; set CDB_CACHE to another",
                       folder.string());
  if (status.st_uid != geteuid())
    return fmt::format(
        "the cache '{}' belongs to another user and is not used; set CDB_CACHE to your own",
        folder.string());
  return fmt::format(
      "the cache '{0}' is not used, as others may write to it; empty it, and `chmod 700 {0}`",
      folder.string());
}

std::optional<std::string> FindCached(const fs::path& folder, std::string_view kind,
                                      std::string_view key) {
  if (!IsSafeFolder(folder)) return std::nullopt;
  const auto bytes = ReadOwn(FileOf(folder, kind, key));
  const std::string head = HeadOf(kind, key);
  if (!bytes || bytes->size() < head.size() + kDigest || !bytes->starts_with(head))
    return std::nullopt;
  const std::string_view body = std::string_view(*bytes).substr(0, bytes->size() - kDigest);
  if (plan::Sha256Hex(body) != std::string_view(*bytes).substr(body.size())) return std::nullopt;
  return std::string(body.substr(head.size()));
}

bool StoreCached(const fs::path& folder, std::string_view kind, std::string_view key,
                 std::string_view contents) {
  if (!MakeFolder(folder)) return false;
  std::string bytes = HeadOf(kind, key);
  bytes += contents;
  bytes += plan::Sha256Hex(bytes);
  return WriteOwn(FileOf(folder, kind, key), bytes);
}

CacheLock::CacheLock(const fs::path& folder, std::string_view kind, std::string_view key,
                     const std::function<void()>& on_wait) {
  if (!MakeFolder(folder)) return;
  file_ = FileOf(folder, kind, key).concat(".lock");
  for (;;) {
    fd_ = plan::Descriptor(
        open(file_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
    if (!IsHeld() || TryLock(on_wait)) return;
  }
}

/// False if the file is no longer the one that others lock: its last owner has removed it.
bool CacheLock::TryLock(const std::function<void()>& on_wait) {
  bool is_locked = flock(fd_.get(), LOCK_EX | LOCK_NB) == 0;
  if (!is_locked && errno == EWOULDBLOCK) {
    on_wait();
    while (!(is_locked = flock(fd_.get(), LOCK_EX) == 0) && errno == EINTR) {
    }
  }
  if (is_locked && plan::IsAt(fd_.get(), file_)) return true;
  fd_.Close();
  return !is_locked;  // the file system has no locks
}

CacheLock::~CacheLock() {
  // Removed while locked, so that a process that waits for this file does not continue with it.
  if (IsHeld()) unlink(file_.c_str());
}

}  // namespace cdb::library
