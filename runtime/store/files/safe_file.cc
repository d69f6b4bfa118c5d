#include "runtime/store/files/safe_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "compiler/plan/descriptor.h"
#include "runtime/measure/file_descriptor_io.h"
#include "runtime/store/files/errors.h"
#include "runtime/store/files/seal.h"
#include "runtime/store/files/temporary_file.h"

namespace cdb::files {
namespace {

namespace fs = std::filesystem;

std::string ErrorText(int error) { return std::generic_category().message(error); }

/// Returns the number of bytes read; fewer than requested at the end of the file or after an error
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

[[noreturn]] void FailRead(const fs::path& file, std::string_view why) {
  throw StoreError(fmt::format("{}: {}; it was left as it is: remove it and its run is done again",
                               file.string(), why));
}

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
    if (!measure::TryWriteAll(file.fd(), std::as_bytes(std::span(piece))))
      file.Fail("write it", errno);
  });
  file.Publish();
}

void WriteSealed(std::span<const std::byte> bytes, const fs::path& final_name) {
  const Seal seal = {kSealMagic, bytes.size(), Checksum(bytes)};
  TemporaryFile file(final_name);
  for (const auto part : {bytes, std::as_bytes(std::span(&seal, 1))})
    if (!measure::TryWriteAll(file.fd(), part)) file.Fail("write it", errno);
  file.Publish();
}

std::vector<std::byte> ReadSealed(const fs::path& path) {
  const plan::Descriptor file(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat status = {};
  if (file.get() < 0 || fstat(file.get(), &status) != 0)
    throw StoreError(fmt::format("{}: cannot be read: {}; nothing was changed", path.string(),
                                 ErrorText(errno)));
  if (S_ISDIR(status.st_mode)) FailRead(path, "is a folder, not the result of a run");
  if (!S_ISREG(status.st_mode)) FailRead(path, "is a pipe or a device, not the result of a run");
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size));
  const std::size_t got = ReadAll(file.get(), bytes);
  if (got != bytes.size() && errno != 0)
    throw CannotRead(fmt::format("{}: cannot be read: {}; nothing was changed", path.string(),
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

}  // namespace cdb::files
