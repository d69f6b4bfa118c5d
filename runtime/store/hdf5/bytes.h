// The bytes of an HDF5 file according to its format specification, for code that reads or writes
// them without HDF5. Included only by the sources of this folder.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace cdb::hdf5 {

static_assert(std::endian::native == std::endian::little,
              "HDF5 files are little-endian, and their numbers are copied as they stand");

/// Objects begin at multiples of this.
inline constexpr std::size_t kAlignment = 8;

/// A global heap (III.E of the specification): a head with signature and size, and objects, each
/// with a head.
inline constexpr std::string_view kHeapSignature("GCOL\1\0\0\0", 8);
inline constexpr std::uint64_t kHeapHead = 16, kHeapObjectHead = 16;

inline std::uint64_t Aligned(std::uint64_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// The same bytes as text, whose find is faster than a search for bytes.
inline std::string_view AsText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <typename Number>
Number Get(std::span<const std::byte> bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, &bytes[at], sizeof number);
  return number;
}

}  // namespace cdb::hdf5
