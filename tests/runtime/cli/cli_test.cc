// The command line as users see it: output, files and exit status.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "compiler/analysis/pruning.h"
#include "compiler/schema/schema.h"
#include "runtime/cli/options/provenance.h"
#include "runtime/results/store.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

const char kSmall[] =
    "benchmark small {\n  cycles 20\n  world.side 400\n  detector sweep(sap, dbvt)\n"
    "  objects { quantity sweep(5, 20); type any(sphere, cuboid, cylinder, cone)\n"
    "    linear_velocity uniform(-200, 200) }\n}\n";

/// The state hash of every run, by its id; fails if a run is missing or did not succeed.
std::map<std::string, std::string> Hashes(const std::filesystem::path& file) {
  const results::ResultFile result(file);
  std::map<std::string, std::string> hashes;
  results::ResultFile::Cell cell;
  cell.at.assign(result.axes().size(), 0);
  for (;;) {
    for (cell.rep = 0; cell.rep < result.repeats(); ++cell.rep) {
      const results::Status status = result.ReadStatus(cell);
      if (status == results::Status::kSkipped) continue;
      EXPECT_EQ(status, results::Status::kDone);
      const std::string hash = result.ReadText("state_hash", cell);
      EXPECT_EQ(hash.size(), 16u);
      hashes[result.ReadText("run_id", cell)] = hash;
    }
    std::size_t i = cell.at.size();
    while (i > 0 && ++cell.at[i - 1] == result.axes()[i - 1].values.size()) cell.at[--i] = 0;
    if (i == 0) return hashes;
  }
}

TEST(Run, GivesATableAFileAndNothingElse) {
  const Program program;
  program.Write("small.cdb", kSmall);
  const Finished run = program.Run({"run", "small.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("Mean of a cycle"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("small.h5"), std::string::npos);
  EXPECT_NE(run.err.find("4/4"), std::string::npos) << run.err;
  EXPECT_TRUE(program.Exists("small.h5"));
  EXPECT_FALSE(program.Exists("small.runs"));
  EXPECT_EQ(Hashes(program.folder() / "small.h5").size(), 4u);
}

TEST(Run, IsRepeatableToTheBit) {
  const Program program;
  program.Write("small.cdb", kSmall);
  EXPECT_EQ(program.Run({"plan", "small.cdb", "-o", "plan.yaml"}).status, 0);
  EXPECT_EQ(program.Run({"run", "small.cdb", "-q", "-o", "one.h5"}).status, 0);
  EXPECT_EQ(program.Run({"run", "small.cdb", "-q", "-o", "two.h5"}).status, 0);
  EXPECT_EQ(program.Run({"run", "plan.yaml", "-q", "-o", "yaml.h5"}).status, 0);
  EXPECT_EQ(program.Run({"run", "small.cdb", "-q", "-j", "2", "--shared-timings", "-o", "jobs.h5"})
                .status,
            0);
  const auto one = Hashes(program.folder() / "one.h5");
  EXPECT_EQ(one.size(), 4u);
  for (const char* other : {"two.h5", "yaml.h5", "jobs.h5"})
    EXPECT_EQ(one, Hashes(program.folder() / other)) << other;
}

TEST(Run, LeavesOutTheSamePartsForEverySeed) {
  const Program program;
  const auto lone = [](const char* omit) {
    return fmt::format(
        "benchmark lone {{\n  cycles 60\n  seed sweep(1..6)\n  world.side 300\n  record energy\n"
        "  acceleration (0, 0, 0)\n  omit {}\n"
        "  objects {{ quantity 2; size 20; linear_velocity uniform(-60, 60) }}\n}}\n",
        omit);
  };
  program.Write("lone.cdb", lone("auto"));
  const Finished run = program.Run({"run", "lone.cdb", "-o", "auto.h5"});
  EXPECT_EQ(run.status, 0);
  // Separately, two of the seeds would omit walls and solver, and three the walls.
  EXPECT_NE(run.err.find("again, now with walls, detection, solver, sleeping"), std::string::npos)
      << run.err;
  const results::ResultFile file(program.folder() / "auto.h5");
  for (std::size_t seed = 0; seed < 6; ++seed)
    for (const schema::ComponentInfo& info : schema::Components())
      if (info.IsVisible()) {
        EXPECT_FALSE(schema::ListsWord(file.ReadText("omitted", {{seed}, 0}), info.name));
      }
  program.Write("lone.cdb", lone("none"));
  EXPECT_EQ(program.Run({"run", "lone.cdb", "-q", "-o", "none.h5"}).status, 0);
  const results::ResultFile whole(program.folder() / "none.h5");
  for (std::size_t seed = 0; seed < 6; ++seed)
    EXPECT_EQ(file.ReadText("state_hash", {{seed}, 0}), whole.ReadText("state_hash", {{seed}, 0}));
}

TEST(Run, MarksTimingsThatAreNotToBeQuoted) {
  const Program program;
  program.Write("small.cdb", kSmall);
  const auto has = [](const Finished& finished, const char* part) {
    return finished.out.find(part) != std::string::npos;
  };
  const Finished one = program.Run({"run", "small.cdb", "-o", "one.h5"});
  EXPECT_EQ(has(one, "do not quote these timings"), options::BuildType() != "Release") << one.out;
  EXPECT_FALSE(has(one, "with parallel runs")) << one.out;
  const Finished two =
      program.Run({"run", "small.cdb", "-j", "2", "--shared-timings", "-o", "two.h5"});
  EXPECT_TRUE(has(two, "parallel runs (jobs 2)")) << two.out;
  EXPECT_EQ(results::ResultFile(program.folder() / "two.h5").ReadProvenance("build_type"),
            options::BuildType());
}

TEST(Run, RefusesJobsThatDisturbTimes) {
  const Program program;
  program.Write("small.cdb", kSmall);
  const Finished refused = program.Run({"run", "small.cdb", "-j", "2"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("--shared-timings"), std::string::npos) << refused.err;
  EXPECT_FALSE(program.Exists("small.h5"));
  EXPECT_FALSE(program.Exists("small.runs"));
  program.Write("counts.cdb", "benchmark counts { cycles 3; record counts }\n");
  EXPECT_EQ(program.Run({"run", "counts.cdb", "-q", "-j", "2"}).status, 0);
}

TEST(Run, KeepsTheRunsOfTwoOutputsApart) {
  const Program program;
  program.Write("small.cdb", kSmall);
  for (const char* out : {"r.v1", "r.v2", "r.h5"})
    EXPECT_EQ(program.Run({"run", "small.cdb", "-q", "--shard", "1/2", "-o", out}).status, 0);
  for (const char* folder : {"r.v1.runs", "r.v2.runs", "r.runs"})
    EXPECT_TRUE(program.Exists(folder)) << folder;
}

/// Plans of format 5 listed every parameter, and their runs had other ids.
TEST(EarlierPlans, AreRead) {
  const Program program;
  const std::filesystem::path golden = SourceFolder() / "tests/golden/compiler";
  program.Write("plan.yaml", ReadFile(golden / "plans_of_format_5" / "default.b.yaml"));
  program.Write("default.cdb", ReadFile(golden / "plans" / "default.cdb"));
  // A plan, under the ids of today.
  EXPECT_EQ(program.Run({"plan", "plan.yaml"}).out, program.Run({"plan", "default.cdb"}).out);
  // Complete results.
  std::filesystem::copy_file(SourceFolder() / "library/scenarios/paper/results/paper_claims1.h5",
                             program.folder() / "old.h5");
  EXPECT_EQ(program.Run({"check", "old.h5"}).status, 0);
  EXPECT_NE(program.Run({"show", "old.h5"}).out.find("1000 cycles"), std::string::npos);
  const Finished done = program.Run({"run", "paper/claims", "-b", "paper_claims1", "-o", "old.h5"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.err.find("complete"), std::string::npos) << done.err;
  const Finished retried = program.Run(
      {"run", "paper/claims", "-b", "paper_claims1", "-o", "old.h5", "--retry", "noisy"});
  EXPECT_EQ(retried.status, 2);
  EXPECT_NE(retried.err.find("results of an earlier cdb"), std::string::npos) << retried.err;
}

TEST(EarlierPlans, AStartedSweepIsRefusedAndKept) {
  const Program program;
  const std::filesystem::path golden = SourceFolder() / "tests/golden/compiler";
  program.Write("default.cdb", ReadFile(golden / "plans" / "default.cdb"));
  std::filesystem::create_directory(program.folder() / "default.runs");
  const std::string plan = ReadFile(golden / "plans_of_format_5" / "default.b.yaml");
  program.Write("default.runs/plan.yaml", plan);
  program.Write("default.runs/1fb6691c8206a52a.h5", "finished by the earlier cdb");
  const Finished run = program.Run({"run", "default.cdb", "-o", "default.h5"});
  EXPECT_EQ(run.status, 2);
  for (const char* part : {"1fb6691c8206a52a.h5 was written by an earlier version of cdb",
                           "end the sweep with that version", "--fresh"})
    EXPECT_NE(run.err.find(part), std::string::npos) << part << "\n" << run.err;
  const Finished merged = program.Run({"merge", "-o", "default.h5", "default.runs"});
  EXPECT_EQ(merged.status, 2);
  EXPECT_NE(merged.err.find("merge the runs beside it with that cdb"), std::string::npos)
      << merged.err;
  EXPECT_EQ(program.Read("default.runs/plan.yaml"), plan);
  EXPECT_TRUE(program.Exists("default.runs/1fb6691c8206a52a.h5"));
}

TEST(Run, KnowsWhatIsDone) {
  const Program program;
  program.Write("small.cdb", kSmall);
  ASSERT_EQ(program.Run({"run", "small.cdb"}).status, 0);
  const std::string before = program.Read("small.h5");
  const Finished again = program.Run({"run", "small.cdb"});
  EXPECT_EQ(again.status, 0);
  EXPECT_NE(again.err.find("complete"), std::string::npos) << again.err;
  EXPECT_EQ(program.Read("small.h5"), before);

  program.Write("small.cdb", std::string(kSmall) + "# another comment\n");
  EXPECT_EQ(program.Run({"run", "small.cdb"}).status, 0) << "a comment does not make another plan";

  std::string other = kSmall;
  other.replace(other.find("cycles 20"), 9, "cycles 21");
  program.Write("small.cdb", other);
  const Finished refused = program.Run({"run", "small.cdb"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("another plan"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--fresh"), std::string::npos);
  EXPECT_EQ(program.Read("small.h5"), before);
  EXPECT_EQ(program.Run({"run", "small.cdb", "--fresh"}).status, 0);
  EXPECT_NE(program.Read("small.h5"), before);
}

TEST(Run, InShardsIsTheSameAsWhole) {
  const Program program;
  program.Write("small.cdb", kSmall);
  ASSERT_EQ(program.Run({"run", "small.cdb", "-q", "-o", "whole.h5"}).status, 0);
  for (const char* shard : {"1/2", "2/2"})
    EXPECT_EQ(program.Run({"run", "small.cdb", "--shard", shard}).status, 0);
  EXPECT_FALSE(program.Exists("small.h5"));
  EXPECT_EQ(program.Run({"merge", "-o", "small.h5", "small.runs"}).status, 0);
  EXPECT_TRUE(program.Exists("small.runs")) << "merge leaves the journals";
  EXPECT_EQ(Hashes(program.folder() / "whole.h5"), Hashes(program.folder() / "small.h5"));

  // Parts of two machines: a folder, and a journal by name.
  ASSERT_EQ(program.Shell("rm -r small.h5 small.runs; mkdir b").status, 0);
  ASSERT_EQ(program.Run({"run", "small.cdb", "--shard", "1/2"}).status, 0);
  ASSERT_EQ(program.Shell("mv small.runs a").status, 0);
  ASSERT_EQ(program.Run({"run", "small.cdb", "--shard", "2/2"}).status, 0);
  ASSERT_EQ(
      program.Shell("mv small.runs/*.journal b/node.journal; mv small.runs/plan.yaml b").status, 0);
  EXPECT_EQ(program.Shell("$CDB merge -o small.h5 a b/node.journal").status, 0)
      << program.Read("stderr.txt");
  EXPECT_EQ(Hashes(program.folder() / "whole.h5"), Hashes(program.folder() / "small.h5"));
}

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

TEST(Run, AllBenchmarksOfAFileIntoAFolder) {
  const Program program;
  program.Write("two.cdb", "benchmark a { cycles 2 }\nbenchmark b { cycles 3 }\n");
  EXPECT_EQ(program.Run({"run", "two.cdb", "-q"}).status, 0);
  EXPECT_TRUE(program.Exists("a.h5") && program.Exists("b.h5"));
  std::filesystem::create_directory(program.folder() / "out");
  EXPECT_EQ(program.Run({"run", "two.cdb", "-q", "-o", "out", "-b", "b"}).status, 0);
  EXPECT_TRUE(program.Exists("out/b.h5") && !program.Exists("out/a.h5"));
  const Finished one = program.Run({"run", "two.cdb", "-o", "x.h5"});
  EXPECT_EQ(one.status, 2);
  EXPECT_NE(one.err.find("-b"), std::string::npos) << one.err;
  const Finished unknown = program.Run({"run", "two.cdb", "-b", "aa"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find("did you mean"), std::string::npos) << unknown.err;
}

TEST(Run, AFailedRunIsDataAndExitStatus3) {
  const Program program;
  program.Write(
      "full.cdb",
      "benchmark full { cycles 5; world.side 100; objects { size 60; quantity sweep(1, 40) } }");
  const Finished run = program.Run({"run", "full.cdb"});
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_NE(run.out.find("did not end well"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("quantity 40"), std::string::npos) << run.out;
  const results::ResultFile file(program.folder() / "full.h5");
  EXPECT_EQ(file.ReadStatus({{0}, 0}), results::Status::kDone);
  EXPECT_EQ(file.ReadStatus({{1}, 0}), results::Status::kFailed);
  EXPECT_FALSE(file.ReadText("message", {{1}, 0}).empty());
  EXPECT_EQ(program.Run({"show", "full.h5"}).status, 3);

  // The command that `show` prints repeats exactly that run.
  const std::size_t command = run.out.find("cdb run full.cdb -b full --only ");
  ASSERT_NE(command, std::string::npos) << run.out;
  const std::string line = run.out.substr(command + 4, run.out.find('\n', command) - command - 4);
  EXPECT_EQ(program.Shell("$CDB " + line).status, 3);
  const std::string id = line.substr(line.size() - 16);
  const results::ResultFile again(program.folder() / (id + ".h5"));
  EXPECT_EQ(again.ReadStatus({{0}, 0}), results::Status::kFailed);
  EXPECT_EQ(again.axes()[0].values, (std::vector<plan::Coordinate>{40.0}));
  EXPECT_EQ(program.Run({"run", "full.cdb", "--only", "nothing"}).status, 2);
}

TEST(Check, SaysOnceWhatCannotBePlacedBeforeAnythingRuns) {
  const Program program;
  program.Write("out.cdb",
                "benchmark out { cycles 5; world.side 10; detector sweep(simple, sap, dbvt)\n"
                "  objects { quantity 1; size 1; location at(sweep(40, 50, 60), 0, 0) } }");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"check", "out.cdb"}, {"run", "out.cdb", "-q"}}) {
    const Finished refused = program.Run(command);
    EXPECT_EQ(refused.status, 1);
    EXPECT_EQ(refused.err,
              "out.cdb:2:42: error: object 1 of 1 (group `objects`) lies 34.5 m beyond the cube's "
              "wall +x; in 9 of 9 runs [E0223 cannot-place]\n"
              "  2 |   objects { quantity 1; size 1; location at(sweep(40, 50, 60), 0, 0) } }\n"
              "    |                                          ^^^^^^^^^^^^^^^^^^^^^^^^^^^ move it "
              "inwards or make world.side larger\n");
  }
  // If other runs can be executed, it is a warning, and failures are reported with -q as well.
  program.Write(
      "some.cdb",
      "benchmark some { cycles 5; world.side 100; objects { size 60; quantity sweep(1, 40) } }");
  const Finished checked = program.Run({"check", "some.cdb"});
  EXPECT_EQ(checked.status, 0);
  EXPECT_NE(checked.err.find(
                "warning: runs will fail: all objects together would fill 452.4 % of the cube"),
            std::string::npos)
      << checked.err;
  const Finished run = program.Run({"run", "some.cdb", "-q"});
  EXPECT_EQ(run.status, 3);
  EXPECT_NE(run.err.find("runs will fail"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("`cdb show some.h5` names them"), std::string::npos) << run.err;
}

TEST(Check, LetsObjectsTouchTheFloor) {
  const Program program;
  program.Write(
      "touch.cdb",
      "benchmark touch { cycles 30; world.side 3; omit sweep(auto, none)\n"
      "  objects { quantity 1; type cuboid; size 0.7; location at(0, -1.15, 0) }\n"
      "  objects upper { quantity 1; type cuboid; size 0.3; location at(0.2, -0.65, 0) } }");
  const Finished run = program.Run({"run", "touch.cdb", "-q"});
  EXPECT_EQ(run.status, 0) << run.err;
  const auto hashes = Hashes(program.folder() / "touch.h5");
  ASSERT_EQ(hashes.size(), 2u);
  EXPECT_EQ(hashes.begin()->second, hashes.rbegin()->second);
}

TEST(Run, OneByItselfEndsInTheSameState) {
  const Program program;
  program.Write("small.cdb", kSmall);
  ASSERT_EQ(program.Run({"run", "small.cdb", "-q"}).status, 0);
  for (const auto& [id, hash] : Hashes(program.folder() / "small.h5")) {
    ASSERT_EQ(program.Run({"run", "small.cdb", "-q", "--only", id}).status, 0);
    EXPECT_EQ(Hashes(program.folder() / (id + ".h5")).begin()->second, hash);
  }
}

TEST(Run, ATimeoutEndsARunAndKeepsItsCycles) {
  const Program program;
  // So few cycles that the file holds almost nothing of what its shape would permit. A busy machine
  // may need longer to begin.
  for (double limit_s = 0.5; limit_s < 100; limit_s *= 4) {
    program.Write(
        "slow.cdb",
        fmt::format("benchmark slow {{ cycles 2000000; timeout {}; objects.quantity 300 }}",
                    limit_s));
    const Finished run = program.Run({"run", "slow.cdb", "--fresh"});
    ASSERT_EQ(run.status, 3) << run.err;
    if (results::ResultFile(program.folder() / "slow.h5").ReadCycleCount({{}, 0}) > 0) break;
  }
  const results::ResultFile file(program.folder() / "slow.h5");
  EXPECT_EQ(file.ReadStatus({{}, 0}), results::Status::kTimedOut);
  EXPECT_GT(file.ReadCycleCount({{}, 0}), 0u);
  EXPECT_EQ(file.ReadDuration(protocol::Phase::kStep, {{}, 0}).size(),
            file.ReadCycleCount({{}, 0}));
  EXPECT_GT(file.ReadReal("peak_rss", {{}, 0}), 1e6) << "of the dead as well";
}

TEST(Run, WhatNoMemoryHoldsIsRefusedBeforeAnythingRuns) {
  const Program program;
  // 10^14 bytes of poses.
  program.Write("huge.cdb",
                "benchmark huge { cycles 2000000000; record poses; objects.quantity 1000 }");
  const Finished run = program.Run({"run", "huge.cdb"});
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.err.find("huge: one run records up to"), std::string::npos) << run.err;
  EXPECT_FALSE(program.Exists("huge.h5") || program.Exists("huge.runs"));
}

TEST(Check, RefusesWhatThisMachineCannotRun) {
  const Program program;
  program.Write("many.cdb", "benchmark many { world.side 1e9; objects.quantity 2000000000 }");
  program.Write("long.cdb",
                "benchmark long { cycles 2000000000; world.side 1e6; record pairs; "
                "objects.quantity 1000000 }");
  for (const char* command : {"check", "run"}) {
    const Finished many = program.Run({command, "many.cdb"});
    EXPECT_EQ(many.status, 2) << many.err;
    EXPECT_NE(many.err.find("its 2e+09 objects need 2 TB or more"), std::string::npos) << many.err;
    EXPECT_EQ(program.Run({command, "long.cdb"}).status, 2);
  }
  EXPECT_FALSE(program.Exists("many.runs"));
}

TEST(Run, AMissingModelIsRefusedBeforeAnyRun) {
  const Program program;
  program.Write("b.cdb",
                "benchmark b { cycles 2; world.side 100\n"
                "objects { quantity 2; size 9; type sweep(sphere, any(cone, bunny)) } }");
  setenv("CDB_MODELS", program.folder().c_str(), 1);
  const Finished finished = program.Run({"run", "b.cdb"});
  unsetenv("CDB_MODELS");
  EXPECT_EQ(finished.status, 2);
  EXPECT_NE(finished.err.find("cdb: b: nothing was started: the model `bunny` is not on this "
                              "machine (looked for bunny.off in " +
                              program.folder().string()),
            std::string::npos)
      << finished.err;
  EXPECT_NE(finished.err.find("fetch-models"), std::string::npos) << finished.err;
  EXPECT_FALSE(program.Exists("b.h5"));
}

TEST(Check, FindsEveryErrorAndLeavesNoFile) {
  const Program program;
  program.Write("bad.cdb", "benchmark a { cycles 0; colour red; objects.type cuboyd }\n");
  for (const char* command : {"check", "plan", "run"}) {
    const Finished finished = program.Run({command, "bad.cdb"});
    EXPECT_EQ(finished.status, 1) << command;
    EXPECT_EQ(finished.out, "") << command;
    for (const char* part : {"bad.cdb:1:22", "colour", "did you mean 'cuboid'?"})
      EXPECT_NE(finished.err.find(part), std::string::npos) << command << ": " << finished.err;
  }
  EXPECT_EQ(program.Run({"plan", "bad.cdb", "-o", "p.yaml"}).status, 1);
  EXPECT_FALSE(program.Exists("p.yaml") || program.Exists("a.h5") || program.Exists("a.runs"));
}

TEST(Plan, PrintsRunsAndWritesYaml) {
  const Program program;
  program.Write("small.cdb", kSmall);
  const Finished table = program.Run({"plan", "small.cdb"});
  EXPECT_EQ(table.status, 0);
  EXPECT_NE(table.out.find("small: 4 runs = 2 detector x 2 quantity"), std::string::npos)
      << table.out;
  EXPECT_EQ(program.Run({"plan", "small.cdb", "-o", "p.yaml"}).out, "");
  EXPECT_EQ(program.Run({"plan", "p.yaml"}).out, table.out);
  EXPECT_EQ(program.Run({"plan", "p.yaml", "-o", "-"}).out, program.Read("p.yaml"));
}

TEST(Plan, EstimatesWhatASweepWillCost) {
  const Program program;
  program.Write("small.cdb", kSmall);
  const Finished some = program.Run({"plan", "--estimate", "small.cdb"});
  EXPECT_EQ(some.status, 0) << some.err;
  EXPECT_NE(some.out.find("small: 4 runs\n"), std::string::npos) << some.out;
  EXPECT_NE(some.out.find("Sampled: 4 of 4 points"), std::string::npos) << some.out;
  EXPECT_EQ(program.Shell("ls -A | grep -c estimate").out, "0\n") << "sampled runs are gone";
  EXPECT_EQ(program.Run({"plan", "--estimate", "small.cdb", "-o", "p.yaml"}).status, 2);
  EXPECT_EQ(program.Run({"plan", "small.cdb", "-o", "p.yaml"}).status, 0);
  EXPECT_EQ(program.Run({"plan", "--estimate", "p.yaml"}).status, 2);
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

TEST(Plan, EstimatesWhatPilesTakeToSettle) {
  const Program program;
  program.Write("pile.cdb",
                "benchmark pile { cycles 5; world.side 20; detector sweep(dbvt, sap)\n"
                "objects { quantity 4; size 1; friction sweep(0.5, 0.9); location pile } }");
  const Finished some = program.Run({"plan", "--estimate", "pile.cdb"});
  EXPECT_EQ(some.status, 0) << some.err;
  EXPECT_NE(some.out.find("piles   2, each settled once: 2 are settled by now\n"),
            std::string::npos)
      << some.out;
}

TEST(Run, FindsOneRunOfAMillion) {
  const Program program;
  program.Write("many.cdb",
                "benchmark many { seed sweep(1 .. 100); cycles sweep(1 .. 100); world.side 100\n"
                "objects { size 1; quantity 1; mass sweep(1 .. 100) } }");
  const Finished check = program.Run({"check", "many.cdb"});
  EXPECT_NE(check.out.find("many: 1000000 runs"), std::string::npos) << check.out << check.err;
  const Finished table = program.Run({"plan", "many.cdb"});
  EXPECT_NE(table.out.find("and 990000 more"), std::string::npos);
  const std::size_t row = table.out.find("  ", table.out.find("---\n")) + 2;
  const std::string id = table.out.substr(row, 16);
  EXPECT_EQ(program.Run({"run", "many.cdb", "--only", id}).status, 0) << id;
  EXPECT_TRUE(program.Exists(id + ".h5"));
  const Finished shard = program.Run({"run", "many.cdb", "--shard", "7/100000"});
  EXPECT_EQ(shard.status, 0) << shard.err;
  EXPECT_NE(shard.out.find("10 runs: 10 done"), std::string::npos) << shard.out;
}

TEST(Run, ALongSweepRunsInShardsAndIsMerged) {
  const Program program;
  const std::string text =
      "benchmark many { seed sweep(1 .. 47); cycles sweep(1 .. 50); world.side 100\n"
      "objects { size 1; quantity 1; mass sweep(1 .. 47) } }";
  program.Write("many.cdb", text);
  const Finished one = program.Run({"run", "many.cdb", "--shard", "1/11045"});
  ASSERT_EQ(one.status, 0) << one.err;
  EXPECT_NE(one.out.find("10 runs: 10 done"), std::string::npos) << one.out;
  const Finished again = program.Run({"run", "many.cdb", "--shard", "1/11045"});
  EXPECT_NE(again.out.find("10 runs: 10 done (10 of them before)"), std::string::npos) << again.out;
  const std::string plan = program.Read("many.runs/plan.yaml");
  EXPECT_LT(plan.size(), 1000u) << "the texts that it comes from, and no list";
  // The file as another machine of a cluster has it.
  program.Write("short.yaml", plan);
  std::filesystem::remove(program.folder() / "many.cdb");
  const Finished two = program.Run({"run", "short.yaml", "--shard", "2/11045", "-o", "many.h5"});
  ASSERT_EQ(two.status, 0) << two.err;
  const Finished merged = program.Run({"merge", "-o", "out.h5", "many.runs"});
  EXPECT_EQ(merged.status, 0) << merged.err;
  EXPECT_NE(merged.err.find("20 of 110450 runs in 'out.h5'"), std::string::npos) << merged.err;
  const Finished checked = program.Run({"check", "out.h5"});
  EXPECT_NE(checked.out.find("incomplete: 20 of 110450 runs"), std::string::npos)
      << checked.out << checked.err;
  // Comments do not matter; another value makes another plan.
  program.Write("many.cdb", "# again\n" + text);
  EXPECT_EQ(program.Run({"run", "many.cdb", "-q", "--shard", "3/11045"}).status, 0);
  program.Write("many.cdb", text + "# \nbenchmark other { }");
  EXPECT_EQ(program.Run({"run", "many.cdb", "-q", "-b", "many", "--shard", "3/11045"}).status, 0);
  std::string other = text;
  other.replace(other.find("1 .. 50"), 7, "2 .. 51");
  program.Write("many.cdb", other);
  const Finished mixed = program.Run({"run", "many.cdb", "--shard", "4/11045"});
  EXPECT_EQ(mixed.status, 2);
  EXPECT_NE(mixed.err.find("runs.journal is of another plan"), std::string::npos) << mixed.err;
  const Finished listed = program.Run({"plan", "short.yaml"});
  EXPECT_EQ(listed.status, 2);
  EXPECT_NE(listed.err.find("short form, as it has 110450 runs"), std::string::npos) << listed.err;
}

TEST(Run, ALongSweepHasNoReferenceRuns) {
  const Program program;
  program.Write("many.cdb",
                "benchmark many { seed sweep(1 .. 400); cycles sweep(1 .. 400); world.side 100\n"
                "accuracy { metrics position; interval 1/60 }\n"
                "objects { size 1; quantity 1 } }");
  const Finished run = program.Run({"run", "many.cdb", "--shard", "1/1000"});
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.err.find("160000 runs are too many for reference runs"), std::string::npos)
      << run.err;
}

TEST(Plan, SaysWhatEachRunLeavesOut) {
  const Program program;
  program.Write("o.cdb",
                "benchmark o { cycles 5; objects { quantity 1; size 5 }\n"
                "detector sweep(sap, dbvt); omit sweep(auto, none) }");
  const Finished table = program.Run({"plan", "o.cdb"});
  EXPECT_EQ(table.status, 0) << table.err;
  for (const char* row :
       {"  detector  omit  objects  side  cycles  left out\n",
        "  sap       auto        1    50       5  walls? raycast_tree solver? sleeping?\n",
        "  dbvt      auto        1    50       5  walls? solver? sleeping?\n",
        "  sap       none        1    50       5  -\n"})
    EXPECT_NE(table.out.find(row), std::string::npos) << row << table.out;

  const Finished why = program.Run({"plan", "--why", "o.cdb"});
  EXPECT_EQ(why.status, 0) << why.err;
  // A fall of a few millimetres in a cube of 50 m: no component is undecided, nothing touches.
  EXPECT_EQ(why.out.find("open"), std::string::npos) << why.out;
  for (const char* row :
       {"\n  walls           left out  for 6 of 6", "\n  raycast_tree    none      dbvt has none",
        "\n  gravity         kept      the accel"})
    EXPECT_NE(why.out.find(row), std::string::npos) << row << why.out;
  EXPECT_NE(why.out.find("  o: detector sap, omit auto\n"), std::string::npos) << why.out;

  const std::string id = table.out.substr(table.out.find("\n  ", table.out.find("---")) + 3, 16);
  const Finished only = program.Run({"plan", "--why", "o.cdb", "--only", id});
  EXPECT_EQ(only.status, 0) << only.err;
  EXPECT_EQ(only.out.find(id), 0u) << only.out;
  EXPECT_EQ(why.out.find(only.out), 0u) << "the first of them all";
  EXPECT_EQ(std::ranges::count(only.out, '\n'), 1 + static_cast<int>(schema::Components().size()));

  EXPECT_EQ(program.Run({"plan", "--why", "o.cdb", "--only", "nothing"}).status, 2);
  EXPECT_EQ(program.Run({"plan", "o.cdb", "--only", id}).status, 2);
  EXPECT_EQ(program.Run({"plan", "--why", "o.cdb", "-o", "p.yaml"}).status, 2);
  EXPECT_FALSE(program.Exists("p.yaml"));
}

TEST(Plan, WhySaysRepeatsOnceAndGoesOnAfterARunThatFails) {
  const Program program;
  // 40 objects have no room; and two that are stacked need a solver.
  program.Write("f.cdb",
                "benchmark f { repeats 3; cycles 300; world.side 100; omit solver\n"
                "objects { size 60; quantity sweep(40, 1, 0) } }");
  const Finished why = program.Run({"plan", "--why", "f.cdb"});
  EXPECT_EQ(why.status, 1) << why.err;
  const auto count = [&](const std::string& part) {
    int n = 0;
    for (std::size_t at = why.out.find(part); at != std::string::npos;
         at = why.out.find(part, at + 1))
      ++n;
    return n;
  };
  EXPECT_EQ(count(" and 2 more like it\n"), 3) << why.out;
  EXPECT_EQ(count("  this run fails: "), 2) << why.out;
  EXPECT_EQ(count("  this run fails: omit solver: this scene needs it: "), 1) << why.out;
  EXPECT_EQ(count("\n  solver          left out "), 1) << why.out;
}

TEST(Run, KeepsWhatItLeftOutWithTheResults) {
  const Program program;
  program.Write(
      "o.cdb",
      "benchmark o { cycles 20; objects { quantity 20; size 5; linear_velocity uniform(-9, 9) }\n"
      "detector sap32; omit sweep(none, auto, raycast_tree) }");
  const Finished run = program.Run({"run", "o.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  const results::ResultFile file(program.folder() / "o.h5");
  const auto text = [&](const char* name, std::size_t at) {
    return file.ReadText(name, {{at}, 0});
  };
  EXPECT_EQ(text("omitted", 0), "");
  EXPECT_EQ(text("omitted", 1).find("walls raycast_tree solver "), 0u) << text("omitted", 1);
  EXPECT_EQ(text("omitted", 2), "raycast_tree");
  EXPECT_NE(text("needs", 0).find("walls: kept: omit none\n"), std::string::npos);
  EXPECT_NE(text("needs", 1).find("detection: kept: record timing"), std::string::npos);
  EXPECT_NE(text("needs", 2).find("walls: kept: omit does not list it\n"), std::string::npos);
  for (const std::size_t at : {1, 2}) {
    EXPECT_EQ(text("state_hash", at), text("state_hash", 0)) << "it was needed after all";
  }
  EXPECT_NE(run.out.find("  Omitted in 2 of 3 runs: raycast_tree ("), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("  Omitted in 1 of 3 runs: walls ("), std::string::npos) << run.out;

  // `--why` printed the same before the run, in columns.
  const Finished why = program.Shell("$CDB plan --why o.cdb --only " + text("run_id", 1) +
                                     " | sed '1d; s/^  //; s/   */: /g'");
  EXPECT_EQ(why.out, text("needs", 1));
}

TEST(Run, AListThatAPlacedSceneNeedsFailsThatRun) {
  const Program program;
  program.Write("l.cdb",
                "benchmark l { cycles 300; omit walls; world.side 60; objects { size 50\n"
                "quantity 1 } }");
  const Finished run = program.Run({"run", "l.cdb"});
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_NE(run.out.find("omit walls: this scene needs"), std::string::npos) << run.out;
  EXPECT_EQ(program.Run({"plan", "--why", "l.cdb"}).status, 1);
}

TEST(Format, LaysOutInPlace) {
  const Program program;
  program.Write("x.cdb", "benchmark b{cycles 5;   objects.size 3 # s\n}");
  EXPECT_EQ(program.Run({"fmt", "--check", "x.cdb"}).status, 1);
  EXPECT_EQ(program.Run({"fmt", "x.cdb"}).status, 0);
  EXPECT_EQ(program.Run({"fmt", "--check", "x.cdb"}).status, 0);
  EXPECT_EQ(program.Run({"check", "x.cdb"}).status, 0);
}

TEST(Doc, KnowsEveryParameter) {
  const Program program;
  const Finished all = program.Run({"doc", "parameters"});
  EXPECT_EQ(all.status, 0);
  int commands = 0;
  for (const auto& parameter : schema::Schema()) {
    EXPECT_NE(all.out.find(parameter.FullName()), std::string::npos);
    if (kAnySanitizer && commands++ % 10 != 0) continue;  // they take the same path
    EXPECT_EQ(program.Run({"doc", parameter.FullName()}).status, 0) << parameter.name;
  }
  for (const char* topic :
       {"language", "omit", "accuracy", "results", "objects", "detectors", "layouts", "scenarios"})
    EXPECT_GT(program.Run({"doc", topic}).out.size(), 20u) << topic;
  const Finished omit = program.Run({"doc", "omit"});
  for (const auto& component : schema::Components())
    for (const std::string_view part : {component.name, component.doc, component.changes})
      EXPECT_NE(omit.out.find(part), std::string::npos) << part;
  EXPECT_NE(omit.out.find("default  auto"), std::string::npos) << "the parameter as well";
  EXPECT_EQ(program.Run({"doc", "detecter"}).status, 2);
  EXPECT_EQ(program.Run({"list", "detectors"}).status, 0);
}

TEST(Examples, AreWellWrittenAndSayWhatTheyAre) {
  const Program program;
  const std::filesystem::path examples = SourceFolder() / "examples";
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(examples)) {
    if (entry.path().extension() != ".cdb") continue;
    ++count;
    const std::string file = entry.path().string();
    const Finished check = program.Run({"check", file});
    EXPECT_EQ(check.status, 0) << check.err;
    EXPECT_EQ(check.err.find("error:"), std::string::npos) << check.err;  // lints may warn
    EXPECT_EQ(program.Run({"fmt", "--check", file}).status, 0) << file;
    const auto text = program.Shell("head -2 '" + file + "'").out;
    EXPECT_EQ(text.find("# "), 0u) << file;
    EXPECT_NE(text.find("\n# Look at "), std::string::npos) << file;
  }
  EXPECT_GE(count, 5);
}

TEST(Lints, AreWholeInCheckALineInPlanAndRunAndSilentInQuiet) {
  const Program program;
  program.Write("small.cdb", "benchmark b { cycles 3; objects.size 0.01 }\n");
  const Finished check = program.Run({"check", "small.cdb"});
  EXPECT_EQ(check.status, 0);
  EXPECT_NE(check.err.find("small.cdb:1:38: warning: "), std::string::npos) << check.err;
  const char* line =
      "small.cdb: Bullet may not simulate this accurately: long-step; `cdb check small.cdb` "
      "explains why\n";
  EXPECT_EQ(program.Run({"plan", "small.cdb"}).err, line);
  EXPECT_NE(program.Run({"run", "small.cdb"}).err.find(line), std::string::npos);
  EXPECT_EQ(program.Run({"run", "-q", "--fresh", "small.cdb"}).err, "");
}

TEST(CommandLine, RefusesByName) {
  const Program program;
  EXPECT_EQ(program.Run({}).status, 2);
  EXPECT_EQ(program.Run({"runn"}).status, 2);
  EXPECT_EQ(program.Run({"--version"}).status, 0);
  program.Write("b.cdb", "benchmark b { }");
  EXPECT_EQ(program.Run({"run", "b.cdb", "--shard", "3/2"}).status, 2);
  EXPECT_EQ(program.Run({"run", "b.cdb", "-j", "0"}).status, 2);
  EXPECT_FALSE(program.Exists("b.h5"));
}

}  // namespace
}  // namespace cdb::tests
