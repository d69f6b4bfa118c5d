// `cdb run --retry`, and `--only` into an existing file: some runs are repeated, the others stay
// unchanged.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using results::ResultFile;
using results::Status;

/// The second of the three runs always fails.
const char kFails[] =
    "benchmark s { cycles 4; world.side 500; acceleration (0, sweep(0, -1e39, -1) as g, 0) }";

class Retry : public testing::Test {
 protected:
  void SetUp() override {
    program_.Write("s.cdb", kFails);
    ASSERT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 3);
    ASSERT_EQ(StatusOf(1), Status::kFailed);
  }
  ResultFile Open() const { return ResultFile(program_.folder() / "s.h5"); }
  Status StatusOf(std::size_t i) const { return Open().ReadStatus({{i}, 0}); }
  double StartOf(std::size_t i) const { return Open().ReadReal("started", {{i}, 0}); }
  /// Values that a second run would not reproduce.
  std::vector<double> TimesOf(std::size_t i) const {
    std::vector<double> times = Open().ReadDuration(protocol::Phase::kStep, {{i}, 0});
    times.push_back(StartOf(i));
    times.push_back(Open().ReadReal("build_time", {{i}, 0}));
    return times;
  }

  const Program program_;
  const fs::path folder_ = program_.folder() / "s.runs";
};

TEST_F(Retry, RunsJustTheCellsThatEndedSoAgain) {
  const auto first = TimesOf(0), last = TimesOf(2);
  const double failed = StartOf(1);
  const Finished again = program_.Run({"run", "s.cdb", "--retry", "crashed,failed"});
  EXPECT_EQ(again.status, 3) << again.err;
  EXPECT_EQ(TimesOf(0), first);
  EXPECT_EQ(TimesOf(2), last);
  EXPECT_EQ(StatusOf(1), Status::kFailed);
  EXPECT_GT(StartOf(1), failed);
  EXPECT_FALSE(program_.Exists("s.runs"));
  const Finished none = program_.Run({"run", "s.cdb", "--retry", "crashed,timed_out"});
  EXPECT_NE(none.err.find("no run of 's.h5' is crashed or timed_out"), std::string::npos)
      << none.err;
}

TEST_F(Retry, OnlyRunsOneRunAgainInItsFile) {
  const auto first = TimesOf(0);
  const double started = StartOf(2);
  const std::string id = Open().ReadText("run_id", {{2}, 0});
  EXPECT_EQ(program_.Run({"run", "s.cdb", "--only", id, "-q", "-o", "s.h5"}).status, 3);
  EXPECT_EQ(TimesOf(0), first);
  EXPECT_GT(StartOf(2), started);
  EXPECT_EQ(StatusOf(1), Status::kFailed);
  // Without that file, as usual: only this run.
  EXPECT_EQ(program_.Run({"run", "s.cdb", "--only", id, "-q"}).status, 0);
  EXPECT_TRUE(program_.Exists(id + ".h5"));
}

TEST_F(Retry, GoesOnAfterAKill) {
  const auto first = TimesOf(0);
  const double failed = StartOf(1);
  // The state after a kill right at the beginning: a record of the request, and no run.
  fs::create_directory(folder_);
  journal::Ask(folder_, Open().plan_sha256(), journal::kRetry, "failed");
  EXPECT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 3);
  EXPECT_EQ(TimesOf(0), first);
  EXPECT_GT(StartOf(1), failed);
  EXPECT_FALSE(program_.Exists("s.runs"));
}

TEST_F(Retry, BeforeTheMergeRunsRunsAgain) {
  fs::remove(program_.folder() / "s.h5");
  for (const char* part : {"1/3", "2/3", "3/3"})
    program_.Run({"run", "s.cdb", "-q", "--shard", part});
  ASSERT_EQ(RunsIn(folder_).size(), 3u);
  const Finished again = program_.Run({"run", "s.cdb", "--retry", "failed"});
  EXPECT_EQ(again.status, 3);
  EXPECT_NE(again.err.find("2"), std::string::npos) << again.err;
  EXPECT_EQ(StatusOf(1), Status::kFailed);
  EXPECT_EQ(StatusOf(2), Status::kDone);
}

TEST_F(Retry, LeavesFinishedRunsThatTheResultsLack) {
  fs::remove(program_.folder() / "s.h5");
  const auto run_part = [&](const char* part) {
    program_.Run({"run", "s.cdb", "-q", "--shard", part});
  };
  run_part("1/3");
  ASSERT_EQ(program_.Run({"merge", "-o", "s.h5", "s.runs"}).status, 0);
  run_part("3/3");
  const auto runs = RunsIn(folder_);
  const Finished retry = program_.Run({"run", "s.cdb", "--retry", "failed"});
  EXPECT_EQ(retry.status, 2);
  EXPECT_NE(retry.err.find("has finished runs that are not merged yet"), std::string::npos)
      << retry.err;
  EXPECT_EQ(RunsIn(folder_), runs);
}

/// Runs that --fresh has finished when it is stopped are newer than the existing results.
TEST_F(Retry, AnInterruptedFreshGoesOn) {
  const double before = StartOf(0);
  program_.Run({"run", "s.cdb", "-q", "--fresh", "--shard", "1/3"});
  journal::Ask(folder_, Open().plan_sha256(), journal::kFresh, Open().plan_sha256());
  journal::Journals journals({folder_});
  double begun = 0;
  for (const auto& [id, written] : RunsIn(folder_))
    begun = journals.Find(id)->Number("run/started").value();
  ASSERT_GT(begun, before);
  EXPECT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 3);
  EXPECT_EQ(StartOf(0), begun);
  EXPECT_GT(StartOf(2), begun);
  EXPECT_FALSE(program_.Exists("s.runs"));
}

TEST_F(Retry, SaysThatAChangedTimeoutMakesAnotherPlan) {
  program_.Write("s.cdb", std::string(kFails).insert(14, "timeout 60; "));
  const Finished finished = program_.Run({"run", "s.cdb", "--retry", "failed"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_NE(finished.err.find("such as `timeout`"), std::string::npos) << finished.err;
  EXPECT_EQ(StatusOf(1), Status::kFailed);
}

TEST_F(Retry, RefusesWhatDoesNotGoTogether) {
  const auto refused = [&](std::vector<std::string> arguments, const std::string& part) {
    arguments.insert(arguments.begin(), {"run", "s.cdb"});
    const Finished finished = program_.Run(arguments);
    EXPECT_EQ(finished.status, 2) << finished.err;
    EXPECT_NE(finished.err.find(part), std::string::npos) << finished.err;
  };
  refused({"--retry", "fialed"}, "did you mean 'failed'?");
  refused({"--retry", "failed", "--fresh"}, "--fresh discards all");
  refused({"--retry", "failed", "--shard", "1/2"}, "cannot be combined with --shard");
}

}  // namespace
}  // namespace cdb::tests
