#include "runtime/results/files/seal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "compiler/plan/input_file.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/results/files/errors.h"

namespace cdb::files {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSealedPiece = 1 << 20;
constexpr std::uint64_t kSealPrime = 0x9e3779b97f4a7c15;

/// A regular file, closed on destruction.
class SealedFile {
 public:
  /// Does not wait for the other end of a pipe.
  SealedFile(const fs::path& path, int flags)
      : fd_(open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK)) {
    struct stat status = {};
    if (get() < 0 || fstat(get(), &status) != 0) Fail(path, errno);
    if (!S_ISREG(status.st_mode))
      throw StoreError(
          fmt::format("{}: {}; name the .h5 file", path.string(), plan::WhyNotReadable(path)));
    bytes_ = static_cast<std::uint64_t>(status.st_size);
  }
  int get() const { return fd_.get(); }
  std::uint64_t bytes() const { return bytes_; }

  /// The checksum of the first `bytes`.
  std::uint64_t ChecksumUpTo(std::uint64_t bytes, const fs::path& path) const {
    ChecksumOf checksum(bytes);
    std::vector<std::byte> piece(std::min<std::uint64_t>(bytes, kSealedPiece));
    for (std::uint64_t at = 0; at < bytes; at += piece.size()) {
      piece.resize(std::min<std::uint64_t>(bytes - at, kSealedPiece));
      ReadAt(at, piece, path);
      checksum.Add(piece);
    }
    return checksum.Finish();
  }

  void ReadAt(std::uint64_t at, std::span<std::byte> out, const fs::path& path) const {
    while (!out.empty()) {
      const ssize_t n = pread(get(), out.data(), out.size(), static_cast<off_t>(at));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0)
        throw std::runtime_error(fmt::format("{}: cannot be read: {}; nothing was changed",
                                             path.string(),
                                             std::generic_category().message(errno)));
      if (n == 0)
        throw StoreError(path.string() + ": became shorter while it was read; read again");
      out = out.subspan(static_cast<std::size_t>(n));
      at += static_cast<std::uint64_t>(n);
    }
  }

 private:
  [[noreturn]] static void Fail(const fs::path& path, int error) {
    throw StoreError(fmt::format("{}: cannot be read: {}; nothing was changed", path.string(),
                                 std::generic_category().message(error)));
  }

  plan::Descriptor fd_;
  std::uint64_t bytes_ = 0;
};

/// All zeros if the file is shorter than a seal.
Seal ReadSeal(const SealedFile& file, const fs::path& path) {
  Seal seal = {};
  if (file.bytes() >= sizeof(seal))
    file.ReadAt(file.bytes() - sizeof(seal), std::as_writable_bytes(std::span(&seal, 1)), path);
  return seal;
}

}  // namespace

ChecksumOf::ChecksumOf(std::uint64_t bytes) : hash_(bytes * kSealPrime) {}

void ChecksumOf::Add(std::span<const std::byte> piece) {
  // Each step is a bijection of the state for a given word and of the word for a given state, so a
  // change within one word never cancels out.
  std::uint64_t hash = hash_;
  while (!piece.empty()) {
    std::uint64_t word = 0;
    const std::size_t n = std::min(piece.size(), sizeof(word));
    std::memcpy(&word, piece.data(), n);
    hash = std::rotl((hash ^ word) * kSealPrime, 29);
    piece = piece.subspan(n);
  }
  hash_ = hash;
}

std::uint64_t Checksum(std::span<const std::byte> bytes) {
  ChecksumOf checksum(bytes.size());
  checksum.Add(bytes);
  return checksum.Finish();
}

SealState CheckSeal(const fs::path& path) {
  const SealedFile file(path, O_RDONLY);
  const Seal seal = ReadSeal(file, path);
  if (seal.magic != kSealMagic) return SealState::kNone;
  const std::uint64_t bytes = file.bytes() - sizeof(seal);
  return seal.bytes == bytes && seal.checksum == file.ChecksumUpTo(bytes, path)
             ? SealState::kGood
             : SealState::kBroken;
}

bool IsSealed(const fs::path& path) {
  try {
    const SealedFile file(path, O_RDONLY);
    return ReadSeal(file, path).magic == kSealMagic;
  } catch (const StoreError&) {
    return false;
  }
}

void AppendSeal(const fs::path& path, const fs::path& final_name) {
  try {
    const SealedFile file(path, O_RDWR | O_APPEND);
    const Seal seal = {kSealMagic, file.bytes(), file.ChecksumUpTo(file.bytes(), path)};
    if (protocol::TryWriteAll(file.get(), std::as_bytes(std::span(&seal, 1)))) return;
  } catch (const StoreError& error) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw;
  }
  const int error = errno;
  std::error_code ignored;
  fs::remove(path, ignored);
  throw StoreError(fmt::format(
      "{}: cannot be written: {}; nothing that was finished is lost: make room on the disk and "
      "run again; it resumes where it stopped",
      final_name.string(), std::generic_category().message(error)));
}

}  // namespace cdb::files
