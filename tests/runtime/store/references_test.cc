// Reference runs: their shards, and what the merged file has of them and of errors.
#include <gtest/gtest.h>

#include <cmath>

#include "runtime/store/reference_shard.h"
#include "runtime/store/store.h"
#include "tests/runtime/store/store_fixture.h"

namespace cdb::runtime {
namespace {

namespace fs = std::filesystem;

class References : public testing::Test {
 protected:
  /// Every number another one.
  std::vector<double> SamplesOf(const compiler::Run& run) const {
    std::vector<double> samples(SampleShapeOf(run.scene)->Count());
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i] = static_cast<double>(i) + (run.scene.role == compiler::Role::kTwin ? 0.5 : 0);
    return samples;
  }
  fs::path WriteOne(const compiler::Run& run, Status status = Status::kDone) {
    RunResult result;
    result.status = status;
    result.message = status == Status::kDone ? "" : "it fell over";
    result.state_hash = run.id;
    WriteReference(plan_.Sha256(), run, result, SamplesOf(run), TestProvenance(), folder_.path());
    return folder_ / (run.id + ".h5");
  }
  void WriteRuns() {
    for (const compiler::Run& run : plan_.runs)
      WriteShard(plan_, run, FakeResult(run).result, TestProvenance(), folder_.path());
  }

  const TemporaryFolder folder_;
  const compiler::Plan plan_ = MakePlan({NumberAxis("quantity", {10, 20})}, 1,
                                        {.cycles = 6, .metrics = {"height", "position"}});
};

TEST_F(References, AreReadAsTheyWereWritten) {
  ASSERT_EQ(plan_.references.size(), 4u);
  const compiler::Run& run = plan_.references[0];
  const fs::path path = WriteOne(run);
  EXPECT_EQ(FilesIn(folder_.path()), std::vector<std::string>{run.id + ".h5"});
  const ReferenceShard shard = ReadReference(plan_.Sha256(), run, path);
  EXPECT_EQ(shard.status, Status::kDone);
  EXPECT_EQ(shard.shape, (SampleShape{4, 3}));
  EXPECT_EQ(shard.values, SamplesOf(run));
  const ShardInfo info = ReadShardInfo(path);
  EXPECT_EQ(info.run_id, run.id);
  EXPECT_EQ(info.plan_sha256, plan_.Sha256());
  EXPECT_EQ(info.outcome.status, Status::kDone);
  EXPECT_THROW(ReadReference(plan_.Sha256(), plan_.references[1], path), StoreError);
  EXPECT_THROW(ReadReference("another plan", run, path), StoreError);
}

TEST_F(References, ThatFailedHaveNoSamples) {
  const compiler::Run& run = plan_.references[0];
  const ReferenceShard shard = ReadReference(plan_.Sha256(), run, WriteOne(run, Status::kTimedOut));
  EXPECT_EQ(shard.status, Status::kTimedOut);
  EXPECT_EQ(shard.message, "it fell over");
  EXPECT_TRUE(shard.values.empty());
}

TEST_F(References, StandInTheMergedFileBesideTheErrors) {
  WriteRuns();
  WriteOne(plan_.references[0]);
  WriteOne(plan_.references[1]);
  WriteOne(plan_.references[2], Status::kCrashed);  // and the last is missing
  Merge(plan_, TestProvenance(), folder_.path(), folder_ / "out.h5");
  const ResultFile file(folder_ / "out.h5");
  for (std::size_t i = 0; i < 2; ++i) {
    const ResultFile::Cell cell{{i}, 0};
    const double n = static_cast<double>(i) * 10;
    EXPECT_EQ(file.ReadReal("accuracy/position", cell), n + 0.25);
    EXPECT_EQ(file.ReadReal("accuracy/height_w1_floor", cell), n + 0.125);
    EXPECT_TRUE(std::isnan(file.ReadReal("accuracy/horizon", cell)));
    EXPECT_EQ(file.ReadText("accuracy/truth", cell), plan_.runs[i].reference);
  }
  EXPECT_TRUE(file.Has("accuracy/reference/states"));
  EXPECT_FALSE(file.Has("accuracy/energy"));
}

TEST_F(References, AreNotThereWithoutErrors) {
  const compiler::Plan plan = MakePlan({}, 1, {});
  WriteShard(plan, plan.runs[0], FakeResult(plan.runs[0]).result, TestProvenance(), folder_.path());
  Merge(plan, TestProvenance(), folder_.path(), folder_ / "out.h5");
  const ResultFile file(folder_ / "out.h5");
  for (const char* name : {"accuracy", "sample", "reference", "state"})
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
    EXPECT_THROW(ReadReference(plan_.Sha256(), plan_.references[0], path), StoreError) << at;
    EXPECT_THROW(Merge(plan_, {}, folder_.path(), folder_ / "out.h5"), StoreError) << at;
    EXPECT_FALSE(fs::exists(folder_ / "out.h5"));
  }
}

}  // namespace
}  // namespace cdb::runtime
