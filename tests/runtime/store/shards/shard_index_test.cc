// The index of a shard agrees with its HDF5 file.
#include "runtime/store/shards/shard_index.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "runtime/store/files/safe_file.h"
#include "runtime/store/hdf5/file.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"
#include "tests/runtime/store/store_fixture.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

plan::Plan IndexedGrid() {
  return MakePlan({NumberAxis("quantity", {10, 20, 30}), TextAxis("detector", {"simple", "dbvt"})},
                  2, {.cycles = 6, .metrics = {"position"}}, {{1, 1}});
}

/// Writes runs with every outcome, one of which is missing.
void WriteShards(const plan::Plan& plan, const fs::path& folder) {
  for (std::size_t i = 0; i + 1 < plan.runs.size(); ++i) {
    // The first of the crashed runs has no cycles, and no chunks.
    FakeResult fake(plan.runs[i], i % 3 == 1 ? store::Status::kCrashed : store::Status::kDone,
                    i % 3 == 1 ? (i - 1) % 6 : 6);
    fake.result.models = i == 2 ? "hull 12\n" : "";
    shards::WriteShard(plan, plan.runs[i], fake.result, TestProvenance(), folder);
  }
}

/// Makes the shard as a version without indexes would have written it.
void RemoveIndex(const fs::path& shard) {
  std::vector<std::byte> bytes = files::ReadSealed(shard);
  const auto index = shards::FindIndex(bytes);
  ASSERT_TRUE(index) << shard;
  bytes.resize(bytes.size() - shards::IndexBytes(*index).size());
  EXPECT_FALSE(shards::FindIndex(bytes));
  files::WriteSealed(bytes, shard);
}

void ExpectSameInfo(const shards::ShardInfo& a, const shards::ShardInfo& b) {
  EXPECT_EQ(a.run_id, b.run_id);
  EXPECT_EQ(a.plan_sha256, b.plan_sha256);
  EXPECT_EQ(a.outcome.status, b.outcome.status);
  EXPECT_EQ(a.outcome.verdict, b.outcome.verdict);
  EXPECT_EQ(a.omitted, b.omitted);
  EXPECT_EQ(a.decisions, b.decisions);
}

TEST(ShardIndex, SaysTheSameAsTheHdf5File) {
  const plan::Plan plan = IndexedGrid();
  const TemporaryFolder folder;
  WriteShards(plan, folder.path());
  for (const std::string& name : FilesIn(folder.path())) {
    const shards::ShardInfo by_index = shards::ReadShardInfo(folder / name);
    RemoveIndex(folder / name);
    ExpectSameInfo(by_index, shards::ReadShardInfo(folder / name));
  }
}

TEST(ShardIndex, AMergeByIndexesIsAMergeOfHdf5Files) {
  const plan::Plan plan = IndexedGrid();
  const TemporaryFolder with, without;
  WriteShards(plan, with.path());
  for (const std::string& name : FilesIn(with.path())) {
    fs::copy_file(with / name, without / name);
    RemoveIndex(without / name);
  }
  shards::Merge(plan, {}, with.path(), with / "out.h5");
  shards::Merge(plan, {}, without.path(), without / "out.h5");
  const hdf5::File a = hdf5::File::Open(with / "out.h5"), b = hdf5::File::Open(without / "out.h5");
  EXPECT_EQ(a.OpenGroup("provenance").Texts(), b.OpenGroup("provenance").Texts());
  EXPECT_TRUE(a.Has("provenance/models")) << "differs between runs";
  const store::PlanFacts facts(plan);
  const store::Layout layout = store::MakeLayout(plan, facts, nullptr, 0);
  std::size_t series = 0;
  for (const store::Array& array : layout.arrays) {
    SCOPED_TRACE(array.name);
    const hdf5::Dataset x = a.OpenDataset(array.name), y = b.OpenDataset(array.name);
    series += array.series != nullptr;
    if (x.type() == hdf5::Type::kText) {
      EXPECT_EQ(x.ReadText(), y.ReadText());
      continue;
    }
    const std::vector<double> values = x.Read(), others = y.Read();
    ASSERT_EQ(values.size(), others.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_TRUE(values[i] == others[i] || (values[i] != values[i] && others[i] != others[i]));
  }
  EXPECT_GT(series, 5u);
}

TEST(ShardIndex, AMergeOfHdf5FilesPassesOverChunksThatAreNotThere) {
  const plan::Plan plan =
      MakePlan({}, 1, {.cycles = 300'000, .objects = 0, .record = {"timing", "counts"}});
  const plan::Run& run = plan.runs[0];
  for (const std::uint64_t n_cycles : {0, 7, 200'000}) {
    const TemporaryFolder folder;
    shards::WriteShard(plan, run, FakeResult(run, store::Status::kTimedOut, n_cycles).result, {},
                       folder.path());
    RemoveIndex(folder / (run.id + ".h5"));
    shards::Merge(plan, {}, folder.path(), folder / "out.h5");
    const store::ResultFile file(folder / "out.h5");
    const std::vector<double> steps = file.ReadDuration(measure::Phase::kStep, {{}, 0});
    ASSERT_EQ(steps.size(), n_cycles);
    EXPECT_EQ(file.ReadSeries("pairs", {{}, 0}).size(), n_cycles);
  }
}

TEST(ShardIndex, OfAnotherLayoutIsPassedOver) {
  const plan::Plan plan = IndexedGrid();
  const TemporaryFolder folder;
  const plan::Run& run = plan.runs[0];
  shards::WriteShard(plan, run, FakeResult(run).result, TestProvenance(), folder.path());
  const fs::path shard = folder / (run.id + ".h5");
  std::vector<std::byte> bytes = files::ReadSealed(shard);
  shards::ShardIndex index = *shards::FindIndex(bytes);
  bytes.resize(bytes.size() - shards::IndexBytes(index).size());
  // A version with other arrays would have a different number there.
  ++index.layout;
  for (double& number : index.numbers) number = 77;
  const std::vector<std::byte> other = shards::IndexBytes(index);
  bytes.insert(bytes.end(), other.begin(), other.end());
  files::WriteSealed(bytes, shard);
  shards::Merge(plan, {}, folder.path(), folder / "out.h5");
  const store::ResultFile file(folder / "out.h5");
  EXPECT_EQ(file.ReadCycleCount({run.at, 0}), 6u);
  EXPECT_EQ(file.ReadReal("started", {run.at, 0}), FakeResult(run).result.started_s);
}

TEST(ShardIndex, WhatIsNoIndexIsNone) {
  const plan::Plan plan = IndexedGrid();
  const TemporaryFolder folder;
  shards::WriteShard(plan, plan.runs[0], FakeResult(plan.runs[0]).result, TestProvenance(),
                     folder.path());
  const std::vector<std::byte> bytes = files::ReadSealed(folder / (plan.runs[0].id + ".h5"));
  const auto index = shards::FindIndex(bytes);
  ASSERT_TRUE(index);
  const std::size_t size = shards::IndexBytes(*index).size();
  EXPECT_FALSE(shards::FindIndex({}));
  // Every length that the index could state is rejected, except the right one.
  for (std::uint64_t claimed = 0; claimed < size + 100; ++claimed) {
    if (claimed == size - 16) continue;
    std::vector<std::byte> wrong = bytes;
    std::memcpy(&wrong[wrong.size() - 16], &claimed, sizeof(claimed));
    EXPECT_FALSE(shards::FindIndex(wrong)) << claimed;
  }
  // With any byte changed, the ranges returned are within the shard, or there are none.
  for (std::size_t i = bytes.size() - size; i < bytes.size(); ++i) {
    std::vector<std::byte> wrong = bytes;
    wrong[i] ^= std::byte{0x81};
    const auto read = shards::FindIndex(wrong);
    if (!read) continue;
    for (const shards::IndexedChunk& chunk : read->chunks)
      EXPECT_LE(chunk.begin + chunk.bytes, bytes.size());
  }
}

}  // namespace
}  // namespace cdb::tests
