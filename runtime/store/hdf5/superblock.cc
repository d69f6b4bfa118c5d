#include "runtime/store/hdf5/superblock.h"

#include <cstring>

#include "runtime/store/hdf5/bytes.h"
#include "runtime/store/hdf5/checksums.h"

namespace cdb::hdf5 {
namespace {

constexpr std::size_t kVersionAt = 8, kSizesAt = 9, kFlagsAt = 11, kBaseAt = 12, kEndAt = 28,
                      kChecksumAt = 44, kSuperblock = 48;

}  // namespace

bool HasSuperblock3(std::span<const std::byte> file) {
  return file.size() >= kSuperblock && file[kVersionAt] == std::byte{3} &&
         file[kSizesAt] == std::byte{8} && file[kSizesAt + 1] == std::byte{8} &&
         Get<std::uint64_t>(file, kBaseAt) == 0;
}

std::uint64_t StatedBytes(std::span<const std::byte> file) {
  return Get<std::uint64_t>(file, kEndAt);
}

void CloseSuperblock(std::span<std::byte> file) {
  file[kFlagsAt] = std::byte{0};
  const std::uint64_t bytes = file.size();
  std::memcpy(&file[kEndAt], &bytes, sizeof bytes);
  const std::uint32_t checksum = Lookup3(file.first(kChecksumAt));
  std::memcpy(&file[kChecksumAt], &checksum, sizeof checksum);
}

}  // namespace cdb::hdf5
