#include "runtime/results/hdf5/dataset.h"

#include <gtest/gtest.h>

#include <vector>

#include "runtime/results/hdf5/file.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using hdf5::Shape;

/// First elements of the stored chunks of an array of 7 by 5, in chunks of 2 by 3, if those at
/// `places` were written.
std::vector<Shape> StoredChunks(const std::vector<Shape>& places) {
  const TemporaryFolder folder;
  hdf5::File file = hdf5::File::Create(folder / "a.h5");
  hdf5::Dataset dataset = file.CreateDataset(
      {.name = "a", .type = hdf5::Type::kFloat64, .shape = {7, 5}, .chunk = {2, 3}});
  for (const Shape& place : places) dataset.Write(place, {1, 1}, std::vector<double>{1});
  std::vector<Shape> starts;
  dataset.ForEachStoredChunk([&](const Shape& start, const Shape& count) {
    starts.push_back(start);
    EXPECT_EQ(count, Shape({start[0] == 6 ? 1u : 2u, start[1] == 3 ? 2u : 3u}));
  });
  return starts;
}

TEST(StoredChunks, AreFoundWhetherTheyAreFewOrMany) {
  EXPECT_EQ(StoredChunks({}), std::vector<Shape>{});
  EXPECT_EQ(StoredChunks({{5, 2}}), (std::vector<Shape>{{4, 0}}));
  EXPECT_EQ(StoredChunks({{6, 4}, {0, 0}}), (std::vector<Shape>{{0, 0}, {6, 3}}));
  EXPECT_EQ(StoredChunks({{6, 4}, {2, 3}, {4, 1}, {0, 0}}),
            (std::vector<Shape>{{0, 0}, {2, 3}, {4, 0}, {6, 3}}));
}

}  // namespace
}  // namespace cdb::tests
