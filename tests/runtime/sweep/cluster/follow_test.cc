#include "runtime/sweep/cluster/follow.h"

#include <gtest/gtest.h>

#include "runtime/results/journal/journals.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

class RunCounts : public testing::Test {
 protected:
  void Write(std::size_t i, results::Status status = results::Status::kDone) const {
    const plan::Run& run = plan_.runs[i];
    WriteRun(plan_, run, FakeResult(run, status, 2).result, {}, folder_.path());
  }
  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {1, 2, 3, 4})}, 1, {});
};

TEST_F(RunCounts, GrowWithTheFolderAndKnowWhatFailed) {
  cluster::RunCount count(plan_, folder_.path());
  Write(0);
  count.Update();
  EXPECT_EQ(count.total(), 4u);
  EXPECT_EQ(count.ended(), 1u);
  Write(1);
  Write(2, results::Status::kFailed);
  count.Update();
  EXPECT_EQ(count.ended(), 3u);
  EXPECT_EQ(count.bad(), 1u);
}

TEST_F(RunCounts, DoNotShrinkWhereRunsWereMerged) {
  cluster::RunCount count(plan_, folder_.path());
  Write(0);
  count.Update();
  journal::RemoveJournals(folder_.path());
  count.Update();
  EXPECT_EQ(count.ended(), 1u);
}

TEST_F(RunCounts, TakeNothingElseForARun) {
  cluster::RunCount count(plan_, folder_.path());
  for (const char* name : {"plan.yaml", "notes.h5", "runs.journal-shm", "text.journal"})
    WriteFile(folder_ / name, "");
  count.Update();
  EXPECT_EQ(count.ended(), 0u);
  // A file without contents, as a network file system may show it.
  WriteFile(folder_ / "node.journal", "");
  count.Update();
  EXPECT_EQ(count.ended(), 0u);
  Write(0);
  count.Update();
  EXPECT_EQ(count.ended(), 1u);
}

}  // namespace
}  // namespace cdb::tests
