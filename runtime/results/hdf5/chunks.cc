#include "runtime/results/hdf5/chunks.h"

#include <algorithm>

namespace cdb::hdf5 {

void SplitEvenly(Shape& chunk, std::size_t i, std::size_t item_bytes) {
  std::uint64_t& n = chunk[i];
  const std::uint64_t others = Product(chunk) / n * item_bytes;
  const std::uint64_t most = std::max<std::uint64_t>(1, kLargestChunk / others);
  const std::uint64_t pieces = (n + most - 1) / most;
  n = (n + pieces - 1) / pieces;
}

}  // namespace cdb::hdf5
