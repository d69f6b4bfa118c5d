#include "library/content_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "compiler/plan/sha256.h"

namespace cdb::library {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigest = 64;

fs::path FileOf(const fs::path& folder, std::string_view kind, std::string_view key) {
  return folder / fmt::format("{}.{}", key, kind);
}

/// What a file begins with; to be raised with its layout.
std::string HeadOf(std::string_view kind, std::string_view key) {
  return fmt::format("cdb {} 2\n{}", kind, key);
}

}  // namespace

fs::path CacheFolder() {
  const auto set = [](const char* name) -> std::string_view {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  if (const auto folder = set("CDB_CACHE"); !folder.empty()) return folder;
  // A relative one is to be ignored, says the XDG base directory specification.
  if (const auto folder = set("XDG_CACHE_HOME"); folder.starts_with('/'))
    return fs::path(folder) / "cdb";
  if (const auto home = set("HOME"); !home.empty()) return fs::path(home) / ".cache" / "cdb";
  return {};
}

std::string CacheKeyOf(std::string_view bytes) { return plan::Sha256Hex(bytes); }

std::optional<std::string> FindCached(const fs::path& folder, std::string_view kind,
                                      std::string_view key) {
  if (folder.empty()) return std::nullopt;
  std::ifstream stream(FileOf(folder, kind, key), std::ios::binary);
  std::ostringstream all;
  // Unlike its iterators, this does not throw where reading fails.
  if (!stream || !(all << stream.rdbuf())) return std::nullopt;
  const std::string_view bytes = all.view();
  const std::string head = HeadOf(kind, key);
  if (bytes.size() < head.size() + kDigest || !bytes.starts_with(head)) return std::nullopt;
  const std::string_view body = bytes.substr(0, bytes.size() - kDigest);
  if (plan::Sha256Hex(body) != bytes.substr(body.size())) return std::nullopt;
  return std::string(body.substr(head.size()));
}

bool StoreCached(const fs::path& folder, std::string_view kind, std::string_view key,
                 std::string_view contents) {
  if (folder.empty()) return false;
  std::string bytes = HeadOf(kind, key);
  bytes += contents;
  bytes += plan::Sha256Hex(bytes);
  const fs::path file = FileOf(folder, kind, key);
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) return false;
  // A home may be shared by machines, and a process may have several threads here.
  static std::atomic<unsigned> count = 0;
  char host[256] = "";
  if (gethostname(host, sizeof host - 1) != 0) return false;
  const fs::path temporary = fmt::format("{}.{}.{}.{}.tmp", file.string(), host, getpid(), count++);
  {
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) error = std::make_error_code(std::errc::io_error);
  }
  if (!error) fs::rename(temporary, file, error);
  if (!error) return true;
  std::error_code ignored;  // it may not be there
  fs::remove(temporary, ignored);
  return false;
}

CacheLock::CacheLock(const fs::path& folder, std::string_view kind, std::string_view key,
                     const std::function<void()>& on_wait) {
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  file_ = FileOf(folder, kind, key).concat(".lock");
  while (!error) {
    fd_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd_ < 0 || TakeOrForget(on_wait)) return;
  }
}

/// False where the file is no longer the one that others lock: whoever held it has removed it.
bool CacheLock::TakeOrForget(const std::function<void()>& on_wait) {
  bool is_locked = flock(fd_, LOCK_EX | LOCK_NB) == 0;
  if (!is_locked && errno == EWOULDBLOCK) {
    on_wait();
    while (!(is_locked = flock(fd_, LOCK_EX) == 0) && errno == EINTR) {
    }
  }
  struct stat ours = {}, there = {};
  const bool is_there = is_locked && fstat(fd_, &ours) == 0 && stat(file_.c_str(), &there) == 0 &&
                        ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
  if (is_there) return true;
  close(fd_);
  fd_ = -1;
  return !is_locked;  // no locks here
}

CacheLock::~CacheLock() {
  if (fd_ < 0) return;
  // While it is locked, so that nobody who waits for this file goes on with it.
  unlink(file_.c_str());
  close(fd_);
}

}  // namespace cdb::library
