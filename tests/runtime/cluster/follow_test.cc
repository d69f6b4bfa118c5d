#include "runtime/cluster/follow.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "runtime/store/shards/shards.h"
#include "tests/runtime/store/store_fixture.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

class ShardCounts : public testing::Test {
 protected:
  void Write(std::size_t i, store::Status status = store::Status::kDone) const {
    const plan::Run& run = plan_.runs[i];
    shards::WriteShard(plan_, run, FakeResult(run, status, 2).result, {}, folder_.path());
  }
  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {1, 2, 3, 4})}, 1, {});
};

TEST_F(ShardCounts, GrowWithTheFolderAndKnowWhatFailed) {
  cluster::ShardCount count(plan_, folder_.path());
  Write(0);
  count.Update();
  EXPECT_EQ(count.total(), 4u);
  EXPECT_EQ(count.ended(), 1u);
  Write(1);
  Write(2, store::Status::kFailed);
  count.Update();
  EXPECT_EQ(count.ended(), 3u);
  EXPECT_EQ(count.bad(), 1u);
}

TEST_F(ShardCounts, DoNotShrinkWhereShardsWereMerged) {
  cluster::ShardCount count(plan_, folder_.path());
  Write(0);
  count.Update();
  fs::remove(folder_ / (plan_.runs[0].id + ".h5"));
  count.Update();
  EXPECT_EQ(count.ended(), 1u);
}

TEST_F(ShardCounts, TakeNothingElseForAShard) {
  cluster::ShardCount count(plan_, folder_.path());
  for (const char* name : {"plan.yaml", "notes.h5", "0123456789abcdef.h5.vm.12.tmp"})
    WriteFile(folder_ / name, "");
  count.Update();
  EXPECT_EQ(count.ended(), 0u);
  // A file with its final name but without contents, as a network file system may show it.
  WriteFile(folder_ / (plan_.runs[0].id + ".h5"), "");
  count.Update();
  EXPECT_EQ(count.ended(), 0u);
  Write(0);
  count.Update();
  EXPECT_EQ(count.ended(), 1u);
}

}  // namespace
}  // namespace cdb::tests
