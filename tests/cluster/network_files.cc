// Preloaded into cdb: makes the folders of runs behave as on a network file system. There are no
// locks, and a journal that another process has written becomes visible only CDB_TEST_DELAY_MS
// after that.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <linux/magic.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

namespace {

template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

std::mutex g_mutex;
/// Names that this process has created or seen. If another process replaces such a file, the new
/// one may become visible late, but the old one stays visible until then.
std::set<std::string>& KnownNames() {
  static std::set<std::string> names;
  return names;
}

std::string NameOf(const char* path) {
  const std::string text(path);
  return text.substr(text.rfind('/') + 1);
}

bool IsJournalName(const char* path) { return std::string_view(path).ends_with(".journal"); }

/// True if another process created the file a moment ago.
bool IsHidden(int folder, const char* path) {
  if (path == nullptr || !IsJournalName(path)) return false;
  const std::lock_guard lock(g_mutex);
  if (KnownNames().contains(NameOf(path))) return false;
  static const auto next = Next<int(int, const char*, struct stat*, int)>("fstatat");
  struct stat status = {};
  const int before = errno;
  const bool is_there = next(folder, path, &status, AT_SYMLINK_NOFOLLOW) == 0;
  errno = before;
  if (!is_there) return false;
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  const char* delay = std::getenv("CDB_TEST_DELAY_MS");
  const double age_ms = 1e3 * static_cast<double>(now.tv_sec - status.st_ctim.tv_sec) +
                        1e-6 * static_cast<double>(now.tv_nsec - status.st_ctim.tv_nsec);
  if (age_ms < (delay != nullptr ? std::atof(delay) : 0)) return true;
  KnownNames().insert(NameOf(path));
  return false;
}

bool Refuse(int folder, const char* path) {
  if (!IsHidden(folder, path)) return false;
  errno = ENOENT;
  return true;
}

/// Notes a file that this process creates.
bool IsNew(const char* path, int flags) {
  if ((flags & O_CREAT) == 0 || access(path, F_OK) == 0) return false;
  const std::lock_guard lock(g_mutex);
  KnownNames().insert(NameOf(path));
  return true;
}

}  // namespace

// These replace the functions of the C library.
extern "C" {

int flock(int, int) {
  errno = ENOLCK;
  return -1;
}

int statfs(const char* path, struct statfs* status) {
  static const auto next = Next<int(const char*, struct statfs*)>("statfs");
  const int result = next(path, status);
  if (result == 0) status->f_type = NFS_SUPER_MAGIC;
  return result;
}

int rename(const char* from, const char* to) {
  static const auto next = Next<int(const char*, const char*)>("rename");
  const int result = next(from, to);
  if (result == 0) {
    const std::lock_guard lock(g_mutex);
    KnownNames().insert(NameOf(to));
  }
  return result;
}

// Programs that are compiled for large files use the second name of each.
#define CDB_OPEN(name)                                                \
  int name(const char* path, int flags, ...) {                        \
    static const auto next = Next<int(const char*, int, ...)>(#name); \
    va_list more;                                                     \
    va_start(more, flags);                                            \
    const mode_t mode = va_arg(more, mode_t);                         \
    va_end(more);                                                     \
    if (IsNew(path, flags)) return next(path, flags, mode);           \
    return Refuse(AT_FDCWD, path) ? -1 : next(path, flags, mode);     \
  }
CDB_OPEN(open)
CDB_OPEN(open64)

#define CDB_STAT(name, type)                                              \
  int name(const char* path, struct type* status) {                       \
    static const auto next = Next<int(const char*, struct type*)>(#name); \
    return Refuse(AT_FDCWD, path) ? -1 : next(path, status);              \
  }
CDB_STAT(stat, stat)
CDB_STAT(lstat, stat)
CDB_STAT(stat64, stat64)
CDB_STAT(lstat64, stat64)

struct dirent* readdir(DIR* folder) {
  static const auto next = Next<struct dirent*(DIR*)>("readdir");
  struct dirent* entry = next(folder);
  while (entry != nullptr && IsHidden(dirfd(folder), entry->d_name)) entry = next(folder);
  return entry;
}

}  // extern "C"
