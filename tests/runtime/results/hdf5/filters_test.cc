// Chunks that are made without HDF5 are those that HDF5 makes.
#include "runtime/results/hdf5/filters.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "runtime/results/hdf5/file.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

/// The stored bytes of an array with one chunk.
std::vector<std::byte> StoredByHdf5(const std::vector<double>& values, hdf5::Type type) {
  const TemporaryFolder folder;
  {
    hdf5::File file = hdf5::File::Create(folder / "a.h5");
    const hdf5::Shape shape = {values.size()};
    file.CreateDataset({.name = "a", .type = type, .shape = shape, .chunk = shape}).Write(values);
    file.Close();
  }
  hdf5::RawChunk chunk;
  EXPECT_TRUE(hdf5::File::Open(folder / "a.h5").OpenDataset("a").ReadChunk({0}, chunk));
  EXPECT_EQ(chunk.filter_mask, 0u);
  return chunk.bytes;
}

template <typename Value>
void ExpectSame(const std::vector<double>& values, hdf5::Type type) {
  std::vector<Value> stored;
  for (const double value : values)
    stored.push_back(static_cast<Value>(hdf5::AsStored(value, type)));
  const auto bytes = std::as_bytes(std::span(stored));
  const std::vector<std::byte> filtered = hdf5::Filtered(bytes, sizeof(Value));
  EXPECT_EQ(filtered, StoredByHdf5(values, type));
  const std::vector<std::byte> back = hdf5::Unfiltered(filtered, sizeof(Value), bytes.size());
  EXPECT_TRUE(std::ranges::equal(back, bytes));
}

TEST(Filters, StoreAChunkAsHdf5Does) {
  std::mt19937_64 random(3);
  for (const std::size_t n : {1, 2, 7, 100, 3001, 40'000}) {
    std::vector<double> regular(n), noise(n);
    for (std::size_t i = 0; i < n; ++i) {
      regular[i] = static_cast<double>(i * i % 1000);
      noise[i] = static_cast<double>(random()) * 1e-3;
    }
    for (const auto& values : {regular, noise}) {
      ExpectSame<double>(values, hdf5::Type::kFloat64);
      ExpectSame<std::int32_t>(values, hdf5::Type::kInt32);
      ExpectSame<std::int8_t>(values, hdf5::Type::kInt8);
    }
  }
}

TEST(Filters, ConvertNumbersAsHdf5Does) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(hdf5::AsStored(1.9, hdf5::Type::kInt32), 1);
  EXPECT_EQ(hdf5::AsStored(-1.9, hdf5::Type::kInt32), -1);
  EXPECT_EQ(hdf5::AsStored(1e20, hdf5::Type::kInt32), 2147483647);
  EXPECT_EQ(hdf5::AsStored(kNaN, hdf5::Type::kInt32), 0);
  EXPECT_EQ(hdf5::AsStored(300, hdf5::Type::kInt8), 127);
  EXPECT_EQ(hdf5::AsStored(1e300, hdf5::Type::kFloat64), 1e300);
}

TEST(Filters, RefuseWhatTheyDidNotMake) {
  const std::vector<double> values = {1, 2, 3};
  const std::vector<std::byte> filtered = hdf5::Filtered(std::as_bytes(std::span(values)), 8);
  for (std::size_t i = 0; i < filtered.size(); ++i) {
    std::vector<std::byte> changed = filtered;
    changed[i] ^= std::byte{1};
    EXPECT_THROW(hdf5::Unfiltered(changed, 8, 24), hdf5::Error) << i;
  }
  EXPECT_THROW(hdf5::Unfiltered(filtered, 8, 16), hdf5::Error);
  EXPECT_THROW(hdf5::Unfiltered(std::span(filtered).first(3), 8, 24), hdf5::Error);
}

}  // namespace
}  // namespace cdb::tests
