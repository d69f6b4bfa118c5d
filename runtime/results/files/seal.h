// The seal of a file: a digest of all its bytes, appended after the last of them, where HDF5 and
// its readers do not look. It shows whether a file is byte for byte as it was written. Independent
// of HDF5.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace cdb::files {

struct Seal {
  std::array<char, 8> magic;
  std::uint64_t bytes;  ///< number of bytes before the seal
  std::uint64_t checksum;
};
static_assert(sizeof(Seal) == 24 && std::endian::native == std::endian::little);
inline constexpr std::array<char, 8> kSealMagic = {'c', 'd', 'b', ' ', 's', 'e', 'a', 'l'};

/// The checksum of bytes that are added in pieces. Any change of a single byte changes it. Not
/// protection against malice.
class ChecksumOf {
 public:
  /// `bytes`: the total of all pieces.
  explicit ChecksumOf(std::uint64_t bytes);
  /// The length of every piece except the last must be a multiple of 8.
  void Add(std::span<const std::byte> piece);
  std::uint64_t Finish() const { return hash_ ^ (hash_ >> 32); }

 private:
  std::uint64_t hash_;
};
/// The checksum of a single piece.
std::uint64_t Checksum(std::span<const std::byte> bytes);

enum class SealState {
  kNone,  ///< the end of the file is not a seal
  kGood,
  kBroken,  ///< the file has changed since it was sealed
};
/// Reads the file once, piece by piece. Throws StoreError if it cannot be read or is not a regular
/// file.
SealState CheckSeal(const std::filesystem::path& file);

/// True if the file ends with a seal; its contents are not checked.
bool IsSealed(const std::filesystem::path& file);

/// Reads `file`, which has no seal, and appends one. The caller syncs it to the disk. Throws
/// StoreError, which names `final_name`, after removing `file`.
void AppendSeal(const std::filesystem::path& file, const std::filesystem::path& final_name);

}  // namespace cdb::files
