#include "runtime/store/safe_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "runtime/measure/file_descriptor_io.h"
#include "runtime/measure/host.h"
#include "runtime/store/seal.h"
#include "runtime/store/store.h"

namespace cdb::store {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporaryEnd = ".tmp";

std::string ErrorText(int error) { return std::generic_category().message(error); }

std::string Remedy(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return "make room on the disk and run again; it goes on where it stopped";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder that can be written to (-o)";
    case EISDIR:
      return "choose another name (-o)";
    default:
      return "mend that and run again; it goes on where it stopped";
  }
}

/// A file descriptor, closed at the end.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : fd_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }
  /// Closing may be the first that hears of a failed write (NFS, quotas).
  bool Close() { return close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

/// Returns how many bytes were read; fewer than asked for at the end of the file or after an error
/// (errno, else 0).
std::size_t ReadAll(int fd, std::span<std::byte> bytes) {
  std::size_t done = 0;
  errno = 0;
  while (done < bytes.size()) {
    const ssize_t n = read(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

[[noreturn]] void FailWrite(const fs::path& temporary, const fs::path& final_name,
                            std::string_view doing, int error) {
  std::error_code ignored;
  fs::remove(temporary, ignored);
  throw StoreError(fmt::format("{}: cannot {}: {}; nothing that was finished is lost: {}",
                               final_name.string(), doing, ErrorText(error), Remedy(error)));
}

[[noreturn]] void FailRead(const fs::path& file, std::string_view why) {
  throw StoreError(fmt::format("{}: {}; it was left as it is: remove it and its run is done again",
                               file.string(), why));
}

/// Whether `name` is a temporary of this host that nobody is writing any more.
bool IsStale(std::string_view name, std::string_view host) {
  if (!name.ends_with(kTemporaryEnd)) return false;
  name.remove_suffix(kTemporaryEnd.size());
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return false;
  const std::string_view digits = name.substr(dot + 1);
  name = name.substr(0, dot);
  if (!name.ends_with(host)) return false;
  name.remove_suffix(host.size());
  if (!name.ends_with('.')) return false;
  pid_t pid = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), pid);
  if (error != std::errc{} || end != digits.data() + digits.size() || pid <= 0) return false;
  return kill(pid, 0) != 0 && errno == ESRCH;
}

}  // namespace

fs::path TemporaryName(const fs::path& final_name) {
  return final_name.string() +
         fmt::format(".{}.{}{}", measure::HostName(), getpid(), kTemporaryEnd);
}

void RequireFolder(const fs::path& folder, std::string_view use) {
  struct stat status = {};
  const int error = stat(folder.c_str(), &status) != 0 ? errno
                    : S_ISDIR(status.st_mode)          ? 0
                                                       : ENOTDIR;
  if (error == 0) return;
  throw StoreError(fmt::format(
      "{}: the folder of {} cannot be used: {}; nothing was written: {}", folder.string(), use,
      ErrorText(error), error == ENOENT ? "make it, or choose another (-o)" : Remedy(error)));
}

void Publish(const fs::path& temporary, const fs::path& final_name) {
  {
    Descriptor file(temporary, O_RDONLY);
    if (file.get() < 0 || fsync(file.get()) != 0)
      FailWrite(temporary, final_name, "bring it to the disk", errno);
  }
  if (rename(temporary.c_str(), final_name.c_str()) != 0)
    FailWrite(temporary, final_name, "give it its name", errno);
  const fs::path parent = final_name.has_parent_path() ? final_name.parent_path() : ".";
  Descriptor folder(parent, O_RDONLY | O_DIRECTORY);
  // Some network file systems have no fsync for folders, and say EINVAL.
  if (folder.get() < 0 || (fsync(folder.get()) != 0 && errno != EINVAL))
    throw StoreError(
        fmt::format("{}: was written, but its folder could not be brought to the "
                    "disk: {}; check the disk before you rely on it",
                    final_name.string(), ErrorText(errno)));
}

namespace {

void WriteParts(std::initializer_list<std::span<const std::byte>> parts,
                const fs::path& final_name) {
  const fs::path temporary = TemporaryName(final_name);
  {
    Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    bool good = file.get() >= 0;
    for (const auto& part : parts) good = good && measure::TryWriteAll(file.get(), part);
    if (!good || !file.Close()) FailWrite(temporary, final_name, "write it", errno);
  }
  Publish(temporary, final_name);
}

}  // namespace

void WriteWhole(std::string_view text, const fs::path& final_name) {
  WriteParts({std::as_bytes(std::span(text))}, final_name);
}

void WritePieces(const std::function<void(const std::function<void(std::string_view)>&)>& fill,
                 const fs::path& final_name) {
  const fs::path temporary = TemporaryName(final_name);
  {
    Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    const auto fail = [&] { FailWrite(temporary, final_name, "write it", errno); };
    if (file.get() < 0) fail();
    fill([&](std::string_view piece) {
      if (!measure::TryWriteAll(file.get(), std::as_bytes(std::span(piece)))) fail();
    });
    if (!file.Close()) fail();
  }
  Publish(temporary, final_name);
}

void WriteSealed(std::span<const std::byte> bytes, const fs::path& final_name) {
  const Seal seal = {kSealMagic, bytes.size(), Checksum(bytes)};
  WriteParts({bytes, std::as_bytes(std::span(&seal, 1))}, final_name);
}

std::vector<std::byte> ReadSealed(const fs::path& path) {
  Descriptor file(path, O_RDONLY);
  struct stat status = {};
  if (file.get() < 0 || fstat(file.get(), &status) != 0)
    throw StoreError(fmt::format("{}: cannot be read: {}; nothing was changed", path.string(),
                                 ErrorText(errno)));
  if (S_ISDIR(status.st_mode)) FailRead(path, "is a folder, not the result of a run");
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size));
  const std::size_t got = ReadAll(file.get(), bytes);
  if (got != bytes.size() && errno != 0)
    throw StoreError(fmt::format("{}: cannot be read: {}; nothing was changed", path.string(),
                                 ErrorText(errno)));
  bytes.resize(got);

  constexpr std::string_view kHdf5Begin = "\x89HDF\r\n\x1a\n";
  if (bytes.empty()) FailRead(path, "is empty");
  if (std::memcmp(bytes.data(), kHdf5Begin.data(), std::min(got, kHdf5Begin.size())) != 0)
    FailRead(path, "is not the result of a run (not HDF5, or damaged)");
  Seal seal = {};
  if (got >= sizeof(seal)) std::memcpy(&seal, &bytes[got - sizeof(seal)], sizeof(seal));
  if (got < sizeof(seal) || seal.magic != kSealMagic || seal.bytes != got - sizeof(seal))
    FailRead(path, "is cut short, damaged, or not the result of a run (it has no seal)");
  bytes.resize(got - sizeof(seal));
  if (seal.checksum != Checksum(bytes)) FailRead(path, "is damaged (its checksum differs)");
  return bytes;
}

void RemoveStaleTemporaries(const fs::path& folder) {
  RequireFolder(folder, "results");
  const std::string host = measure::HostName();
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code gone;  // another driver may remove it as well
    if (IsStale(entry->path().filename().native(), host)) fs::remove(entry->path(), gone);
  }
}

}  // namespace cdb::store
