#include "runtime/store/hdf5/checksums.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "runtime/store/hdf5/bytes.h"

namespace cdb::hdf5 {

// Computed as in HDF5: over big-endian words of 16 bits, with an odd last byte as the high one;
// sums are reduced every 360 words, before they overflow.
std::uint32_t Fletcher32(std::span<const std::byte> bytes) {
  constexpr std::size_t kWords = 360;
  std::uint32_t sum = 0, sum_of_sums = 0;
  const auto reduce = [](std::uint32_t value) { return (value & 0xffff) + (value >> 16); };
  while (!bytes.empty()) {
    const std::size_t now = std::min(bytes.size(), 2 * kWords);
    for (std::size_t i = 0; i < now; i += 2) {
      sum += std::to_integer<std::uint32_t>(bytes[i]) << 8;
      if (i + 1 < now) sum += std::to_integer<std::uint32_t>(bytes[i + 1]);
      sum_of_sums += sum;
    }
    sum = reduce(sum);
    sum_of_sums = reduce(sum_of_sums);
    bytes = bytes.subspan(now);
  }
  return reduce(sum_of_sums) << 16 | reduce(sum);
}

// Source: Bob Jenkins, lookup3.c (public domain), hashlittle. A piece has three words; the last one
// is filled with zeros.
std::uint32_t Lookup3(std::span<const std::byte> bytes) {
  constexpr std::size_t kPiece = 12;
  std::uint32_t a = 0xdeadbeef + static_cast<std::uint32_t>(bytes.size()), b = a, c = a;
  const auto add = [&](const std::byte* piece) {
    std::uint32_t words[3];
    std::memcpy(words, piece, kPiece);
    a += words[0];
    b += words[1];
    c += words[2];
  };
  const auto mix = [](std::uint32_t& x, std::uint32_t y, std::uint32_t& z, int bits) {
    x = (x - z) ^ std::rotl(z, bits);
    z += y;
  };
  const auto finish = [](std::uint32_t& x, std::uint32_t y, int bits) {
    x = (x ^ y) - std::rotl(y, bits);
  };
  if (bytes.empty()) return c;
  for (; bytes.size() > kPiece; bytes = bytes.subspan(kPiece)) {
    add(bytes.data());
    mix(a, b, c, 4);
    mix(b, c, a, 6);
    mix(c, a, b, 8);
    mix(a, b, c, 16);
    mix(b, c, a, 19);
    mix(c, a, b, 4);
  }
  std::byte last[kPiece] = {};
  std::ranges::copy(bytes, last);
  add(last);
  finish(c, b, 14);
  finish(a, c, 11);
  finish(b, a, 25);
  finish(c, b, 16);
  finish(a, c, 4);
  finish(b, a, 14);
  finish(c, b, 24);
  return c;
}

}  // namespace cdb::hdf5
