// `cdb merge`: which runs it takes, and what it refuses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/runtime/cli/small_sweep.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

TEST(Merge, RefusesShardsOfEarlierVersions) {
  const Program program;
  program.Write("small.cdb", kSmall);
  ASSERT_EQ(program.Run({"run", "small.cdb", "-q", "--shard", "1/2"}).status, 0);
  program.Write("small.runs/0123456789abcdef.h5", "a shard");
  for (const char* command : {"$CDB merge -o small.h5 small.runs", "$CDB run small.cdb"}) {
    const Finished refused = program.Shell(command);
    EXPECT_EQ(refused.status, 2) << command;
    EXPECT_NE(refused.err.find("0123456789abcdef.h5 was written by an earlier version"),
              std::string::npos)
        << refused.err;
  }
  EXPECT_EQ(program.Run({"run", "small.cdb", "-q", "--fresh"}).status, 0);
  EXPECT_FALSE(program.Exists("small.runs"));
}

/// As a `merge --remove` leaves it that is killed while it removes the folder.
TEST(Merge, RemovesWhatAKilledMergeHasLeft) {
  const Program program;
  program.Write("small.cdb", kSmall);
  ASSERT_EQ(program.Run({"run", "small.cdb", "-q"}).status, 0);
  for (const bool has_plan : {true, false}) {
    ASSERT_EQ(program.Shell("mkdir small.runs; touch small.runs/runs.journal-wal").status, 0);
    if (has_plan) {
      ASSERT_EQ(program.Run({"plan", "small.cdb", "-o", "small.runs/plan.yaml"}).status, 0);
    }
    const Finished merged = program.Run({"merge", "--remove", "-o", "small.h5", "small.runs"});
    EXPECT_EQ(merged.status, 0) << merged.err;
    EXPECT_FALSE(program.Exists("small.runs"));
  }
}

TEST(Merge, RefusesRunsOfTwoPlans) {
  const Program program;
  for (const char* name : {"a", "b"}) {
    program.Write(fmt::format("{}.cdb", name),
                  fmt::format("benchmark s {{ seed sweep(1, 2); cycles {}; world.side 20\n"
                              "objects {{ size 1; quantity 2 }} }}",
                              name[0] == 'a' ? 3 : 4));
    const Finished run = program.Run({"run", fmt::format("{}.cdb", name), "-q", "--shard", "1/2",
                                      "-o", fmt::format("{}.h5", name)});
    EXPECT_EQ(run.status, 0) << run.err;
  }
  const Finished merged = program.Run({"merge", "-o", "x.h5", "a.runs", "b.runs"});
  EXPECT_EQ(merged.status, 2);
  EXPECT_NE(merged.err.find("'a.runs/plan.short.yaml' and 'b.runs/plan.short.yaml' are two plans"),
            std::string::npos)
      << merged.err;
  EXPECT_FALSE(program.Exists("x.h5"));
  EXPECT_EQ(program.Run({"merge", "-o", "x.h5", "a.runs", "a.runs"}).status, 0);
}

TEST(Merge, KeepsTheRunsThatAResultHasAlready) {
  const Program program;
  program.Write("s.cdb",
                "benchmark s { seed sweep(1, 2); cycles 3; world.side 20\n"
                "objects { size 1; quantity 2 } }");
  for (const char* shard : {"1/2", "2/2"}) {
    const Finished run = program.Run({"run", "s.cdb", "-q", "--shard", shard});
    ASSERT_EQ(run.status, 0) << run.err;
    const Finished merged = program.Run({"merge", "-o", "s.h5", "s.runs"});
    EXPECT_NE(merged.err.find(shard[0] == '1' ? "1 of 2 runs" : "2 of 2 runs"), std::string::npos)
        << merged.err;
    std::filesystem::remove_all(program.folder() / "s.runs");
  }
}

}  // namespace
}  // namespace cdb::tests
