#include "runtime/results/files/safe_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "compiler/plan/input_file.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/protocol/machine/machine.h"
#include "runtime/results/files/errors.h"
#include "runtime/results/files/seal.h"

namespace cdb::files {
namespace {

namespace fs = std::filesystem;

std::string ErrorText(int error) { return std::generic_category().message(error); }

}  // namespace

void RequireFolder(const fs::path& folder, std::string_view use) {
  struct stat status = {};
  const int error = stat(folder.c_str(), &status) != 0 ? errno
                    : S_ISDIR(status.st_mode)          ? 0
                                                       : ENOTDIR;
  if (error == 0) return;
  throw StoreError(
      fmt::format("{}: the folder of {} cannot be used: {}; nothing was written: {}",
                  folder.string(), use, ErrorText(error),
                  error == ENOENT ? "make it, or choose another (-o)" : "choose another (-o)"));
}

void WriteWhole(std::string_view text, const fs::path& final_name) {
  WritePieces([text](const auto& write) { write(text); }, final_name);
}

void WritePieces(const std::function<void(const std::function<void(std::string_view)>&)>& fill,
                 const fs::path& final_name) {
  RemoveStaleTemporariesBeside(final_name);
  TemporaryFile file(final_name);
  fill([&](std::string_view piece) {
    if (!protocol::TryWriteAll(file.fd(), std::as_bytes(std::span(piece))))
      file.Fail("write it", errno);
  });
  file.Publish();
}

namespace {

constexpr std::string_view kTemporaryEnd = ".tmp";

std::string SystemText(int error) { return std::generic_category().message(error); }

/// The target of `path`, also if a link's target does not exist yet. Throws StoreError for a loop.
fs::path FollowLinks(const fs::path& path) {
  constexpr int kMostLinks = 40;  // limit of the kernel
  fs::path at = path;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(at, error)); ++links) {
    if (links == kMostLinks)
      throw StoreError(fmt::format("{}: {}; nothing was written: name a file (-o)", path.string(),
                                   SystemText(ELOOP)));
    const fs::path target = fs::read_symlink(at, error);
    at = target.is_absolute() ? target : at.parent_path() / target;
  }
  return at;
}

fs::path FolderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// The final name of a temporary of `host`; empty for other names.
std::string_view FinalNameOf(std::string_view name, std::string_view host) {
  if (!name.ends_with(kTemporaryEnd)) return {};
  name.remove_suffix(kTemporaryEnd.size());
  const std::size_t digits = name.find_last_not_of("0123456789");
  if (digits == std::string_view::npos || digits + 1 == name.size() || name[digits] != '.')
    return {};
  name = name.substr(0, digits);
  if (!name.ends_with(host)) return {};
  name.remove_suffix(host.size());
  return name.ends_with('.') ? name.substr(0, name.size() - 1) : std::string_view();
}

/// Removes a temporary that no process has locked.
void RemoveIfUnlocked(const fs::path& path) {
  // Opened for writing, which an exclusive lock on a network file system requires.
  const plan::Descriptor file(open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status = {};
  if (file.get() >= 0 && fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode) &&
      flock(file.get(), LOCK_EX | LOCK_NB) == 0 && plan::IsAt(file.get(), path))
    unlink(path.c_str());
}

void RemoveStale(const fs::path& folder, const std::function<bool(std::string_view)>& is_ours) {
  const std::string host = machine::HostName();
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const std::string_view final_name = FinalNameOf(name, host);
    if (!final_name.empty() && is_ours(final_name)) RemoveIfUnlocked(entry->path());
  }
}

}  // namespace

std::string WriteRemedy(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return "make room on the disk and run again; it resumes where it stopped";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder that can be written to (-o)";
    case EISDIR:
      return "choose another name (-o)";
    default:
      return "mend that and run again; it resumes where it stopped";
  }
}

fs::path NameAside(const fs::path& file) {
  for (int number = 1;; ++number) {
    fs::path name = file;
    name.replace_filename(
        fmt::format("{}.{}{}", file.stem().string(), number, file.extension().string()));
    std::error_code error;
    if (fs::symlink_status(name, error).type() == fs::file_type::not_found) return name;
  }
}

fs::path SetAside(const fs::path& file) {
  for (;;) {
    const fs::path name = NameAside(file);
    if (renameat2(AT_FDCWD, file.c_str(), AT_FDCWD, name.c_str(), RENAME_NOREPLACE) == 0)
      return name;
    if (errno == EEXIST) continue;  // another process took the name
    // Network file systems cannot rename without replacing; the name was free just now.
    if ((errno == EINVAL || errno == ENOSYS) && rename(file.c_str(), name.c_str()) == 0)
      return name;
    throw StoreError(fmt::format("{}: cannot be renamed to '{}': {}; nothing was changed",
                                 file.string(), name.string(), SystemText(errno)));
  }
}

TemporaryFile::TemporaryFile(const fs::path& final_name)
    : named_(final_name), final_(FollowLinks(final_name)) {
  struct stat status = {};
  // Uses the name as given: the target of a link in /proc has no name.
  if (stat(named_.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) Fail("write it", EISDIR);
    if (!S_ISREG(status.st_mode))
      throw StoreError(fmt::format(
          "{}: it is a {}, not a file; nothing was written: name a file (-o)", named_.string(),
          S_ISFIFO(status.st_mode)   ? "pipe"
          : S_ISSOCK(status.st_mode) ? "socket"
                                     : "device"));
  }
  std::random_device random;
  constexpr int kMostTries = 1000;
  long number = getpid();
  for (int tries = 0; tries < kMostTries; ++tries) {
    path_ = final_.string() + fmt::format(".{}.{}{}", machine::HostName(), number, kTemporaryEnd);
    if (TryMake()) return;
    number = static_cast<long>(random());
  }
  Fail("find a temporary name for it", EEXIST);
}

bool TemporaryFile::TryMake() {
  fd_ = plan::Descriptor(open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (fd() < 0 && errno == EEXIST) return false;
  if (fd() < 0) Fail("write it", errno);
  // A shared lock, so that HDF5, which locks the files that it reads, can read it back. If the file
  // system does not support locks, other processes cannot tell, and do not remove it.
  while (flock(fd(), LOCK_SH) != 0 && errno == EINTR) {
  }
  if (plan::IsAt(fd(), path_)) return true;
  fd_.Close();  // another process removed it before it was locked
  return false;
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (fd() >= 0 && plan::IsAt(fd(), path_)) fs::remove(path_, ignored);
}

void TemporaryFile::Fail(std::string_view doing, int error) const {
  if (error == ENOENT)
    throw StoreError(
        fmt::format("{}: cannot {}: its folder is not there (any more); make it, or "
                    "name another (-o)",
                    named_.string(), doing));
  throw StoreError(fmt::format("{}: cannot {}: {}; nothing that was finished is lost: {}",
                               named_.string(), doing, SystemText(error), WriteRemedy(error)));
}

void TemporaryFile::Publish() {
  if (fsync(fd()) != 0) Fail("bring it to the disk", errno);
  if (rename(path_.c_str(), final_.c_str()) != 0) Fail("give it its name", errno);
  const int closed = fd_.Close();
  const plan::Descriptor folder(open(FolderOf(final_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some network file systems do not support fsync for folders, and return EINVAL.
  int error = folder.get() < 0 || (fsync(folder.get()) != 0 && errno != EINVAL) ? errno : 0;
  if (closed != 0) error = closed;
  if (error == 0) return;
  throw StoreError(fmt::format(
      "{}: was written, but could not be brought to the disk: {}; check the disk before "
      "you rely on it",
      named_.string(), SystemText(error)));
}

void RemoveStaleTemporariesBeside(const fs::path& final_name) {
  const fs::path file = FollowLinks(final_name);
  const std::string name = file.filename().string();
  RemoveStale(FolderOf(file),
              [&](std::string_view other) { return other == name || other.ends_with(".h5"); });
}

void RemoveStaleTemporaries(const fs::path& folder) {
  RequireFolder(folder, "results");
  RemoveStale(folder, [](std::string_view) { return true; });
}

}  // namespace cdb::files
