// Reference runs: their shards, and their part of the merged file.
#include <gtest/gtest.h>

#include <cmath>

#include "runtime/store/shards/reference_shard.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"
#include "tests/runtime/store/store_fixture.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

class References : public testing::Test {
 protected:
  /// Samples in which every number is different.
  std::vector<double> SamplesOf(const plan::Run& run) const {
    std::vector<double> samples(measure::SampleShapeOf(run.scene)->Count());
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i] = static_cast<double>(i) + (run.scene.role == plan::Role::kPerturbed ? 0.5 : 0);
    return samples;
  }
  fs::path WriteOne(const plan::Run& run, store::Status status = store::Status::kDone) {
    store::RunResult result;
    result.status = status;
    result.message = status == store::Status::kDone ? "" : "it fell over";
    result.state_hash = run.id;
    shards::WriteReference(plan_.Sha256(), run, result, SamplesOf(run), TestProvenance(),
                           folder_.path());
    return folder_ / (run.id + ".h5");
  }
  void WriteRuns() {
    for (const plan::Run& run : plan_.runs)
      shards::WriteShard(plan_, run, FakeResult(run).result, TestProvenance(), folder_.path());
  }

  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {10, 20})}, 1,
                                    {.cycles = 6, .metrics = {"height", "position"}});
};

TEST_F(References, AreReadAsTheyWereWritten) {
  ASSERT_EQ(plan_.references.size(), 4u);
  const plan::Run& run = plan_.references[0];
  const fs::path path = WriteOne(run);
  EXPECT_EQ(FilesIn(folder_.path()), std::vector<std::string>{run.id + ".h5"});
  const shards::ReferenceShard shard = shards::ReadReference(plan_.Sha256(), run, path);
  EXPECT_EQ(shard.status, store::Status::kDone);
  EXPECT_EQ(shard.shape, (measure::SampleShape{4, 3}));
  EXPECT_EQ(shard.values, SamplesOf(run));
  const shards::ShardInfo info = shards::ReadShardInfo(path);
  EXPECT_EQ(info.run_id, run.id);
  EXPECT_EQ(info.plan_sha256, plan_.Sha256());
  EXPECT_EQ(info.outcome.status, store::Status::kDone);
  EXPECT_THROW(shards::ReadReference(plan_.Sha256(), plan_.references[1], path), files::StoreError);
  EXPECT_THROW(shards::ReadReference("another plan", run, path), files::StoreError);
}

TEST_F(References, ThatFailedHaveNoSamples) {
  const plan::Run& run = plan_.references[0];
  const shards::ReferenceShard shard =
      shards::ReadReference(plan_.Sha256(), run, WriteOne(run, store::Status::kTimedOut));
  EXPECT_EQ(shard.status, store::Status::kTimedOut);
  EXPECT_EQ(shard.message, "it fell over");
  EXPECT_TRUE(shard.values.empty());
}

TEST_F(References, StandInTheMergedFileBesideTheErrors) {
  WriteRuns();
  WriteOne(plan_.references[0]);
  WriteOne(plan_.references[1]);
  WriteOne(plan_.references[2], store::Status::kCrashed);  // the last one is missing
  shards::Merge(plan_, TestProvenance(), folder_.path(), folder_ / "out.h5");
  const store::ResultFile file(folder_ / "out.h5");
  for (std::size_t i = 0; i < 2; ++i) {
    const store::ResultFile::Cell cell{{i}, 0};
    const double n = static_cast<double>(i) * 10;
    EXPECT_EQ(file.ReadReal("accuracy/position", cell), n + 0.25);
    EXPECT_EQ(file.ReadReal("accuracy/height_w1_floor", cell), n + 0.125);
    EXPECT_TRUE(std::isnan(file.ReadReal("accuracy/horizon", cell)));
    EXPECT_TRUE(std::isnan(file.ReadReal("accuracy/timestep", cell)));
    EXPECT_EQ(file.ReadText("accuracy/truth", cell), plan_.runs[i].reference);
  }
  EXPECT_TRUE(file.Has("accuracy/reference/states"));
  EXPECT_FALSE(file.Has("accuracy/energy"));
}

TEST_F(References, AreNotThereWithoutErrors) {
  const plan::Plan plan = MakePlan({}, 1, {});
  shards::WriteShard(plan, plan.runs[0], FakeResult(plan.runs[0]).result, TestProvenance(),
                     folder_.path());
  shards::Merge(plan, TestProvenance(), folder_.path(), folder_ / "out.h5");
  const store::ResultFile file(folder_ / "out.h5");
  for (const char* name : {"accuracy", "accuracy/sample", "accuracy/reference"})
    EXPECT_FALSE(file.Has(name)) << name;
}

TEST_F(References, AreRefusedWhereTheyAreDamaged) {
  WriteRuns();
  const fs::path path = WriteOne(plan_.references[0]);
  const std::string bytes = ReadFile(path);
  for (std::size_t at = 0; at < bytes.size(); at += bytes.size() / 7) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    WriteFile(path, damaged);
    EXPECT_THROW(shards::ReadReference(plan_.Sha256(), plan_.references[0], path),
                 files::StoreError)
        << at;
    EXPECT_THROW(shards::Merge(plan_, {}, folder_.path(), folder_ / "out.h5"), files::StoreError)
        << at;
    EXPECT_FALSE(fs::exists(folder_ / "out.h5"));
  }
}

}  // namespace
}  // namespace cdb::tests
