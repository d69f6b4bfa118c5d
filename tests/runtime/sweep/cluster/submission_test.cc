#include "runtime/sweep/cluster/submission.h"

#include <gtest/gtest.h>

#include "runtime/results/journal/journals.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

TEST(Submission, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  EXPECT_FALSE(cluster::ReadSubmission(folder.path()).has_value());
  cluster::WriteSubmission({"abc", 64, "12", "13"}, folder.path());
  const auto read = cluster::ReadSubmission(folder.path());
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->plan_sha256, "abc");
  EXPECT_EQ(read->tasks, 64u);
  EXPECT_EQ(read->array, "12");
  EXPECT_EQ(read->merge, "13");
}

TEST(Submission, ADamagedOneIsNone) {
  const TemporaryFolder folder;
  for (const char* text : {"", "abc", "abc 0 12 13", "abc many 12 13", "abc 3 12"}) {
    journal::Ask(folder.path(), "abc", journal::kSubmission, text);
    EXPECT_FALSE(cluster::ReadSubmission(folder.path()).has_value()) << text;
  }
}

TEST(Submission, GoesWithItsLogsAndNothingElse) {
  const TemporaryFolder folder;
  cluster::WriteSubmission({"abc", 64, "12", "13"}, folder.path());
  for (const char* name : {"slurm-12_1.log", "slurm-13.log", "mine.log"})
    WriteFile(folder / name, "");
  cluster::RemoveSubmission(folder.path());
  EXPECT_EQ(FilesIn(folder.path()), (std::vector<std::string>{"mine.log", "runs.journal"}));
  journal::RemoveJournals(folder.path());
  EXPECT_FALSE(cluster::ReadSubmission(folder.path()));
}

TEST(SubmissionLock, IsHeldByOneAtATime) {
  const TemporaryFolder folder;
  {
    const cluster::SubmissionLock first(folder.path());
    EXPECT_TRUE(first.is_held());
    EXPECT_FALSE(cluster::SubmissionLock(folder.path()).is_held());
  }
  EXPECT_TRUE(cluster::SubmissionLock(folder.path()).is_held());
}

}  // namespace
}  // namespace cdb::tests
