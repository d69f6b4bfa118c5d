// `cdb run` as users see it: output, files and exit status.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>

#include "compiler/plan/foreign_model.h"
#include "compiler/schema/components.h"
#include "compiler/schema/schema.h"
#include "runtime/cli/options/provenance.h"
#include "runtime/figures/points.h"
#include "runtime/results/store.h"
#include "tests/runtime/cli/small_sweep.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

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

TEST(Run, JudgesRequirements) {
  const Program program;
  const auto scenario = [](const char* requirement) {
    return fmt::format(
        "benchmark gate {{\n  cycles 5\n  record counts, stability\n  require {}\n"
        "  objects {{ quantity sweep(3, 4); size 5 }}\n}}\n",
        requirement);
  };
  program.Write("gate.cdb", scenario("max(pairs) >= 0 %"));
  const Finished run = program.Run({"run", "gate.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("max(pairs) >= 0 %"), std::string::npos) << run.out;
  // The finished runs are judged anew.
  program.Write("gate.cdb", scenario("max(pairs) < 0"));
  const Finished again = program.Run({"run", "gate.cdb"});
  EXPECT_EQ(again.status, 5) << again.err;
  EXPECT_NE(again.out.find("max(pairs) < 0: not met at any of 2 points."), std::string::npos)
      << again.out;
  EXPECT_EQ(again.err.find("running"), std::string::npos) << again.err;
  EXPECT_EQ(program.Run({"show", "gate.h5"}).status, 5);
  const Finished junit = program.Run({"show", "gate.h5", "--junit"});
  EXPECT_EQ(junit.status, 5);
  EXPECT_NE(junit.out.find("failures=\"2\""), std::string::npos) << junit.out;
  EXPECT_EQ(program.Run({"show", "gate.h5", "--junit", "--by", "quantity"}).status, 2);
  EXPECT_EQ(program.Run({"run", "gate.cdb", "-q"}).err,
            "requirements are not met: `cdb show gate.h5` names them\n");
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
  EXPECT_EQ(program.Run({"run", "small.cdb"}).status, 0);
  EXPECT_EQ(program.Read("small.1.h5"), before);
  EXPECT_NE(program.Read("small.h5"), before);
  program.Write("small.cdb", kSmall);
  EXPECT_EQ(program.Run({"run", "small.cdb", "--fresh"}).status, 0);
  EXPECT_FALSE(program.Exists("small.2.h5")) << "--fresh replaces results";
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

TEST(Run, MakesAFolderThatIsNamedAsOne) {
  const Program program;
  program.Write("small.cdb", kSmall);
  EXPECT_EQ(program.Run({"run", "small.cdb", "--dry-run", "-o", "new/of/mine/"}).status, 0);
  EXPECT_FALSE(program.Exists("new"));
  EXPECT_EQ(program.Run({"run", "small.cdb", "-q", "-o", "new/of/mine/"}).status, 0);
  EXPECT_TRUE(program.Exists("new/of/mine/small.h5"));
}

TEST(Run, RequiresAVerdict) {
  const Program program;
  program.Write("sunk.cdb",
                "benchmark sunk { cycles 60; timestep sweep(1/1000, 1/10); world.side 20\n"
                "  objects { quantity 5; size 1; location stack } }\n");
  ASSERT_EQ(program.Run({"run", "sunk.cdb", "-q"}).status, 0);
  const Finished sunk = program.Run({"run", "sunk.cdb", "-q", "--require", "stable"});
  EXPECT_EQ(sunk.status, 3);
  EXPECT_NE(sunk.err.find("sunk.h5: 1 of 2 runs fail `--require stable`: 1 "), std::string::npos)
      << sunk.err;
  EXPECT_EQ(program.Run({"run", "sunk.cdb", "-q", "--require", "exploded"}).status, 0);
  for (const auto& [arguments, why] :
       {std::pair(std::vector<std::string>{"--require", "stabel"}, "did you mean 'stable'?"),
        std::pair(std::vector<std::string>{"--require", "stable", "--shard", "1/2"},
                  "remove --shard"),
        std::pair(std::vector<std::string>{"--require", "stable", "--set", "record=timing"},
                  "does not record stability")}) {
    std::vector<std::string> words = {"run", "sunk.cdb", "-o", "other.h5"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const Finished refused = program.Run(words);
    EXPECT_EQ(refused.status, 2) << why;
    EXPECT_NE(refused.err.find(why), std::string::npos) << refused.err;
  }
  EXPECT_FALSE(program.Exists("other.h5"));
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

TEST(Run, SetsParametersOverThoseOfTheScenario) {
  const Program program;
  program.Write("base.cdb", "benchmark base { cycles 4; objects.quantity 9 }");
  program.Write(
      "a.cdb",
      "use \"base\"\nlet n = 3\nbenchmark a from base \"The title\" { objects.quantity n }\n"
      "benchmark b { objects stones { quantity 2 } }");
  const Finished run = program.Run({"run", "a.cdb", "-b", "a", "--set", "objects.quantity=n + 4",
                                    "--set", "detector=sweep(sap, dbvt)"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("The title\n  2 runs (2 values of detector), 4 cycles"), std::string::npos)
      << run.out;
  const results::ResultFile file(program.folder() / "a.h5");
  EXPECT_NE(file.ReadProvenance("scenario_text").find("objects.quantity n + 4"), std::string::npos);
  // The command that repeats a run has the settings.
  const std::string only = figures::OnlyCommand(file, {{0}, 0});
  EXPECT_NE(only.find("--set 'objects.quantity=n + 4' --set 'detector=sweep(sap, dbvt)'"),
            std::string::npos)
      << only;
  EXPECT_EQ(program.Shell("$CDB " + only.substr(only.find(' '))).status, 0) << only;
  // It is the same plan each time, and another one than without.
  EXPECT_EQ(program
                .Run({"run", "a.cdb", "-b", "a", "--set", "objects.quantity=n + 4", "--set",
                      "detector=sweep(sap, dbvt)"})
                .status,
            0);
  EXPECT_FALSE(program.Exists("a.1.h5"));
  EXPECT_EQ(program.Run({"run", "a.cdb", "-b", "a"}).status, 0);
  EXPECT_TRUE(program.Exists("a.1.h5"));
  const Finished plan =
      program.Run({"plan", "a.cdb", "-o", "-", "-b", "b", "--set", "stones.size=3"});
  EXPECT_NE(plan.out.find("size: 3"), std::string::npos) << plan.out << plan.err;
  const Finished wrong = program.Run({"run", "a.cdb", "--set", "quantity=4"});
  EXPECT_EQ(wrong.status, 1);
  EXPECT_NE(wrong.err.find("--set.cdb:3:3: error: "), std::string::npos) << wrong.err;
  EXPECT_NE(wrong.err.find("write objects.quantity"), std::string::npos) << wrong.err;
  for (const char* let : {"n=2", "let n=2"})
    EXPECT_EQ(program.Run({"plan", "a.cdb", "-o", "-", "-b", "a", "--set", let}).status, 0) << let;
  EXPECT_EQ(program.Run({"run", "a.cdb", "--set", "quantity"}).status, 2);
  EXPECT_EQ(program.Run({"run", "plan.yaml", "--set", "cycles=2"}).status, 2);
}

TEST(Run, ImportsMeshesInItsWorkers) {
  if (plan::ImporterOf(".dae").empty()) {
    std::cout << "skipped: needs libassimp-dev (./setup --import)\n";
    GTEST_SKIP();
  }
  const Program program;
  for (const std::string name : {"angle.dae", "angle.glb"})
    program.Write(name, ReadFile(SourceFolder() / "tests/fuzz/corpus_import" / name));
  program.Write("b.cdb",
                "benchmark b { cycles 2; world.side 20\n"
                "objects a { quantity 2; size native; type mesh(\"angle.dae\") }\n"
                "objects g { quantity 1; size native; type surface(\"angle.glb\"); mass fixed } }");
  const Finished finished = program.Run({"run", "b.cdb"});
  EXPECT_EQ(finished.status, 0) << finished.err;
  const std::string shown = program.Run({"show", "b.h5", "--all"}).out;
  EXPECT_NE(shown.find("IoU 1.000, left out: 1 line\n"), std::string::npos) << shown;
  EXPECT_NE(shown.find("surface(\"angle.glb\"): 20 triangles\n"), std::string::npos);
  program.Write("angle.dae", "<COLLADA/>");
  const Finished check = program.Run({"check", "b.cdb"});
  EXPECT_NE(check.status, 0);
  EXPECT_NE((check.out + check.err).find("angle.dae: assimp cannot read it: "), std::string::npos)
      << check.out << check.err;
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
  const std::string shown = program.Run({"show", "o.h5", "--all"}).out;
  EXPECT_NE(shown.find("  Omitted in 2 of 3 runs: raycast_tree ("), std::string::npos) << shown;
  EXPECT_NE(shown.find("  Omitted in 1 of 3 runs: walls ("), std::string::npos) << shown;

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

}  // namespace
}  // namespace cdb::tests
