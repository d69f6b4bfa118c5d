// Shards whose values are written directly into their bytes equal those written by HDF5.
#include "runtime/store/shards/prepared_shard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "runtime/store/files/safe_file.h"
#include "runtime/store/hdf5/file.h"
#include "tests/runtime/store/store_fixture.h"

namespace cdb::tests {
namespace {

plan::Plan SmallGrid(const SceneSize& size = {
                         .cycles = 40, .record = {"timing", "counts", "stability", "poses"}}) {
  return MakePlan({NumberAxis("quantity", {10, 20}), NumberAxis("size", {0.5, 1.5}, "m"),
                   TextAxis("detector", {"simple", "dbvt"})},
                  3, size);
}

void FillTexts(std::size_t i, store::RunResult& result) {
  result.message = std::string(i * 37 % 500, 'm');
  result.models = i % 4 == 0 ? "hull 12\n" : "";
}

void ExpectSameArray(const hdf5::Dataset& a, const hdf5::Dataset& b) {
  EXPECT_EQ(a.Texts(), b.Texts());
  EXPECT_EQ(a.shape(), b.shape());
  if (a.type() == hdf5::Type::kText) {
    EXPECT_EQ(a.ReadText(), b.ReadText());
    return;
  }
  const std::vector<double> values = a.Read(), others = b.Read();
  ASSERT_EQ(values.size(), others.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_TRUE(values[i] == others[i] || (std::isnan(values[i]) && std::isnan(others[i]))) << i;
}

void ExpectSameFile(const hdf5::File& a, const hdf5::File& b, const store::Layout& layout) {
  auto head = a.Texts(), other = b.Texts();
  for (auto* texts : {&head, &other})
    for (const char* dated : {"date_created", "history"}) EXPECT_EQ(texts->erase(dated), 1u);
  EXPECT_EQ(head, other);
  EXPECT_EQ(a.OpenGroup("provenance").Texts(), b.OpenGroup("provenance").Texts());
  for (const store::Dimension& dimension : layout.dimensions) {
    SCOPED_TRACE(dimension.name);
    ExpectSameArray(a.OpenDataset(dimension.name), b.OpenDataset(dimension.name));
  }
  for (const store::Array& array : layout.arrays) {
    SCOPED_TRACE(array.name);
    ExpectSameArray(a.OpenDataset(array.name), b.OpenDataset(array.name));
  }
  ASSERT_EQ(a.Has("provenance/run_text"), b.Has("provenance/run_text"));
  if (a.Has("provenance/run_text"))
    ExpectSameArray(a.OpenDataset("provenance/run_text"), b.OpenDataset("provenance/run_text"));
}

/// The position of the first chunk: after everything else in a prepared shard.
std::uint64_t FirstChunk(std::span<const std::byte> shard) {
  return shards::FindIndex(shard).value().chunks.at(0).begin;
}

TEST(PreparedShard, HoldsWhatHdf5WouldWrite) {
  const plan::Plan plan = SmallGrid();
  const store::Provenance provenance = TestProvenance();
  const store::PlanFacts facts(plan);
  const TemporaryFolder quick, slow;
  const shards::ShardWriter writer(plan, provenance);
  std::size_t prepared = 0;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    const plan::Run& run = plan.runs[i];
    SCOPED_TRACE(run.id);
    FakeResult fake(run);
    FillTexts(i, fake.result);
    writer.Write(run, fake.result, quick.path());
    shards::WriteShard(plan, run, fake.result, provenance, slow.path());
    const auto bytes = files::ReadSealed(quick / (run.id + ".h5"));
    const auto others = files::ReadSealed(slow / (run.id + ".h5"));
    prepared += FirstChunk(bytes) != FirstChunk(others);
    ExpectSameFile(hdf5::File::OpenImage(bytes), hdf5::File::OpenImage(others),
                   store::MakeLayout(plan, facts, &run, 0));
  }
  // All but the first two with models and without.
  EXPECT_EQ(prepared, plan.runs.size() - 4);
  shards::Merge(plan, {}, quick.path(), quick / "out.h5");
  shards::Merge(plan, {}, slow.path(), slow / "out.h5");
  ExpectSameFile(hdf5::File::Open(quick / "out.h5"), hdf5::File::Open(slow / "out.h5"),
                 store::MakeLayout(plan, facts, nullptr, 0));
}

/// The shard that a writer makes of the same run the fifth time.
std::vector<std::byte> FifthShard(const plan::Plan& plan, const store::RunResult& result) {
  const TemporaryFolder folder;
  const store::Provenance provenance;
  const shards::ShardWriter writer(plan, provenance);
  const FakeResult whole(plan.runs[0]);
  for (int i = 0; i < 4; ++i) writer.Write(plan.runs[0], whole.result, folder.path());
  writer.Write(plan.runs[0], result, folder.path());
  return files::ReadSealed(folder / (plan.runs[0].id + ".h5"));
}

TEST(PreparedShard, HasNothingOfEarlierRuns) {
  const plan::Plan plan = SmallGrid();
  const std::string lost(200, 'x');
  FakeResult first(plan.runs[0]), crashed(plan.runs[0], store::Status::kCrashed, 3);
  first.result.message = lost;
  const TemporaryFolder folder;
  const store::Provenance provenance;
  const shards::ShardWriter writer(plan, provenance);
  for (int i = 0; i < 4; ++i) writer.Write(plan.runs[0], first.result, folder.path());
  first.result.message.clear();
  writer.Write(plan.runs[0], first.result, folder.path());
  const auto bytes = files::ReadSealed(folder / (plan.runs[0].id + ".h5"));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_EQ(text.find(lost), std::string_view::npos);
  // A run that ended early has fill values after its cycles.
  const auto early = FifthShard(plan, crashed.result);
  const hdf5::File file = hdf5::File::OpenImage(early);
  const std::vector<double> pairs = file.OpenDataset("pairs").Read();
  ASSERT_EQ(pairs.size(), 40u);
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_EQ(pairs[i] == -1, i >= 3) << i;
}

TEST(PreparedShard, IsMadeOnlyWhereEverySeriesIsOneChunk) {
  const auto is_made = [](const SceneSize& size) {
    const plan::Plan plan = SmallGrid(size);
    const store::Provenance provenance;
    const store::PlanFacts facts(plan);
    const shards::ShardTemplates templates(plan, facts, provenance);
    return shards::PreparedShard::Make(templates.Get(plan.runs[0], 0), plan, facts, plan.runs[0],
                                       "") != nullptr;
  };
  EXPECT_TRUE(is_made({.cycles = 10'000, .record = {"timing", "counts"}}));
  EXPECT_FALSE(is_made({.cycles = 100'000, .record = {"timing", "counts"}}));
  EXPECT_FALSE(is_made({.record = {"timing", "contacts"}}));
  EXPECT_FALSE(is_made({.metrics = {"position"}}));
}

TEST(PreparedShard, LeavesToHdf5WhatItCannotEdit) {
  const plan::Plan plan = SmallGrid();
  const store::Provenance provenance;
  const store::PlanFacts facts(plan);
  const shards::ShardTemplates templates(plan, facts, provenance);
  const FakeResult fake(plan.runs[0]);
  const auto damage = [&](const auto& change) {
    auto damaged = std::make_shared<shards::ShardTemplate>(*templates.Get(plan.runs[0], 0));
    change(damaged->image);
    shards::PreparedShards prepared(plan, facts);
    for (int i = 0; i < 5; ++i)
      EXPECT_EQ(prepared.Write(damaged, plan.runs[0], fake.result, "rep: 0\n"), std::nullopt) << i;
  };
  // HDF5 cannot open it.
  damage([](std::vector<std::byte>& image) { image.resize(image.size() / 2); });
  // HDF5 finds the file's header after a user block, the editor does not.
  damage([](std::vector<std::byte>& image) { image.insert(image.begin(), 512, std::byte{0}); });
}

}  // namespace
}  // namespace cdb::tests
