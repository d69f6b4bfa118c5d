// The seal of a file: a digest over all its bytes, behind the last of them, where HDF5 and its
// readers do not look. It distinguishes a file that is byte for byte as it was written. Knows
// nothing of HDF5.
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
  std::uint64_t bytes;  ///< before the seal
  std::uint64_t checksum;
};
static_assert(sizeof(Seal) == 24 && std::endian::native == std::endian::little);
inline constexpr std::array<char, 8> kSealMagic = {'c', 'd', 'b', ' ', 's', 'e', 'a', 'l'};

/// The checksum of bytes that come in pieces. Any change of a single byte changes it. Not against
/// malice.
class ChecksumOf {
 public:
  /// `bytes`: of all pieces together.
  explicit ChecksumOf(std::uint64_t bytes);
  /// The length of every piece but the last is a multiple of 8.
  void Add(std::span<const std::byte> piece);
  std::uint64_t Finish() const { return hash_ ^ (hash_ >> 32); }

 private:
  std::uint64_t hash_;
};
/// Of one piece.
std::uint64_t Checksum(std::span<const std::byte> bytes);

enum class SealState {
  kNone,  ///< the end of the file is no seal
  kGood,
  kBroken,  ///< the file is not as it was sealed
};
/// Reads the file once, piece by piece. Throws StoreError for what cannot be read or is no regular
/// file.
SealState CheckSeal(const std::filesystem::path& file);

/// The file ends with a seal; says nothing about what stands before it.
bool IsSealed(const std::filesystem::path& file);

/// Reads `file`, which has no seal, and appends one. The caller brings it to the disk. Throws
/// StoreError, which names `final_name`, with `file` removed.
void AppendSeal(const std::filesystem::path& file, const std::filesystem::path& final_name);

}  // namespace cdb::files
