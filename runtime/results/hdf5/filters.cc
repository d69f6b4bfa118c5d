#include "runtime/results/hdf5/filters.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace cdb::hdf5 {
namespace {

/// Computed as in HDF5: over big-endian words of 16 bits, with an odd last byte as the high one;
/// sums are reduced every 360 words, before they overflow.
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

/// Kept, as its 256 KiB take longer to allocate and to clear than a small chunk to compress.
class Deflater {
 public:
  Deflater() {
    constexpr int kLevel = 1;
    if (deflateInit(&stream_, kLevel) != Z_OK) throw Error("cannot compress a chunk");
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  std::vector<std::byte> Deflate(std::span<const std::byte> bytes) {
    if (deflateReset(&stream_) != Z_OK) throw Error("cannot compress a chunk");
    std::vector<std::byte> packed(compressBound(static_cast<uLong>(bytes.size())));
    std::size_t read = 0, written = 0;
    for (int code = Z_OK; code != Z_STREAM_END;) {
      // zlib does not write to what it reads.
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data() + read));
      stream_.avail_in = AtMost(bytes.size() - read);
      stream_.next_out = reinterpret_cast<Bytef*>(packed.data() + written);
      stream_.avail_out = AtMost(packed.size() - written);
      const uInt in = stream_.avail_in, out = stream_.avail_out;
      code = deflate(&stream_, read + in == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
      if (code != Z_OK && code != Z_STREAM_END) throw Error("cannot compress a chunk");
      read += in - stream_.avail_in;
      written += out - stream_.avail_out;
    }
    packed.resize(written);
    return packed;
  }

 private:
  static uInt AtMost(std::size_t left) {
    return static_cast<uInt>(std::min<std::size_t>(left, std::numeric_limits<uInt>::max()));
  }

  z_stream stream_ = {};
};

}  // namespace

double AsStored(double value, Type type) {
  if (type == Type::kFloat64) return value;
  const bool is_byte = type == Type::kInt8;
  const double least =
      is_byte ? std::numeric_limits<std::int8_t>::min() : std::numeric_limits<std::int32_t>::min();
  const double most =
      is_byte ? std::numeric_limits<std::int8_t>::max() : std::numeric_limits<std::int32_t>::max();
  return std::isnan(value) ? 0 : std::trunc(std::clamp(value, least, most));
}

std::vector<std::byte> Deflated(std::span<const std::byte> bytes) {
  static Deflater deflater;
  return deflater.Deflate(bytes);
}

std::vector<std::byte> Inflated(std::span<const std::byte> deflated, std::size_t bytes) {
  std::vector<std::byte> values(bytes);
  auto size = static_cast<uLongf>(bytes);
  if (uncompress(reinterpret_cast<Bytef*>(values.data()), &size,
                 reinterpret_cast<const Bytef*>(deflated.data()),
                 static_cast<uLong>(deflated.size())) != Z_OK ||
      size != bytes)
    throw Error("a chunk is not compressed as it should be");
  return values;
}

std::vector<std::byte> Filtered(std::span<const std::byte> values, std::size_t item_bytes) {
  std::vector<std::byte> shuffled(values.size());
  const std::size_t items = values.size() / item_bytes;
  for (std::size_t byte = 0; byte < item_bytes; ++byte)
    for (std::size_t i = 0; i < items; ++i)
      shuffled[byte * items + i] = values[i * item_bytes + byte];
  std::vector<std::byte> packed = Deflated(shuffled);
  const std::uint32_t checksum = Fletcher32(packed);
  const auto end = std::as_bytes(std::span(&checksum, 1));
  packed.insert(packed.end(), end.begin(), end.end());
  return packed;
}

std::vector<std::byte> Unfiltered(std::span<const std::byte> stored, std::size_t item_bytes,
                                  std::size_t values_bytes) {
  std::uint32_t checksum = 0;
  if (stored.size() < sizeof checksum) throw Error("a chunk is cut short");
  const auto packed = stored.first(stored.size() - sizeof checksum);
  std::memcpy(&checksum, stored.data() + packed.size(), sizeof checksum);
  if (checksum != Fletcher32(packed)) throw Error("the checksum of a chunk differs");
  const std::vector<std::byte> shuffled = Inflated(packed, values_bytes);
  std::vector<std::byte> values(values_bytes);
  const std::size_t items = values_bytes / item_bytes;
  for (std::size_t byte = 0; byte < item_bytes; ++byte)
    for (std::size_t i = 0; i < items; ++i)
      values[i * item_bytes + byte] = shuffled[byte * items + i];
  return values;
}

}  // namespace cdb::hdf5
