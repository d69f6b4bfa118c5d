// The alignment of arrays in shared memory.
#pragma once

#include <cstddef>

namespace cdb::protocol {

/// `bytes`, rounded up to whole cache lines.
constexpr std::size_t WholeCacheLines(std::size_t bytes) {
  constexpr std::size_t kCacheLine = 64;
  return (bytes + kCacheLine - 1) / kCacheLine * kCacheLine;
}

}  // namespace cdb::protocol
