// `cdb run` after an edit of the scenario: what is kept, what is set aside, and that nothing is
// lost wherever it is interrupted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "runtime/cli/options/provenance.h"
#include "runtime/cli/plans/earlier_runs.h"
#include "runtime/cli/plans/plan_changes.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/journal/journals.h"
#include "tests/runtime/cli/small_sweep.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/compile_text.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string Scenario(const std::string& quantity, int repeats, int cycles = 5) {
  return fmt::format(
      "benchmark b {{\n  cycles {}\n  repeats {}\n  world.side 400\n  detector sweep(sap, dbvt)\n"
      "  objects {{ quantity sweep({}); linear_velocity uniform(-200, 200) }}\n}}\n",
      cycles, repeats, quantity);
}

/// When each run began, by its final state.
std::map<std::string, double> StartsIn(const fs::path& file) {
  const results::ResultFile result(file);
  std::map<std::string, double> starts;
  for (std::size_t q = 0; q < result.axes()[0].values.size(); ++q)
    for (std::size_t d = 0; d < result.axes()[1].values.size(); ++d)
      for (std::uint64_t rep = 0; rep < result.repeats(); ++rep)
        starts[fmt::format("{} {} {}", plan::CoordinateText(result.axes()[0].values[q]),
                           plan::CoordinateText(result.axes()[1].values[d]), rep)] =
            result.ReadReal("started", {{q, d}, rep});
  return starts;
}

class Edited : public testing::Test {
 protected:
  void Edit(const std::string& quantity, int repeats, int cycles = 5) const {
    program_.Write("s.cdb", Scenario(quantity, repeats, cycles));
  }
  fs::path At(const std::string& name) const { return program_.folder() / name; }
  /// The results have what a fresh run of the scenario gives.
  void ExpectAsFresh(const std::string& name) const {
    ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "-o", "fresh.h5", "--fresh"}).status, 0);
    EXPECT_EQ(Hashes(At(name)), Hashes(At("fresh.h5")));
  }

  const Program program_;
};

TEST_F(Edited, KeepsTheRunsThatAreStillPartOfThePlan) {
  Edit("5, 20", 2);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 0);
  const auto before = StartsIn(At("s.h5"));
  const std::string bytes = program_.Read("s.h5");

  Edit("5, 30, 20", 3);
  const Finished dry = program_.Run({"run", "--dry-run", "s.cdb"});
  EXPECT_EQ(dry.status, 0);
  EXPECT_THAT(dry.out, HasSubstr("b: objects.quantity + 30, repeats 2 -> 3; 8 of 18 runs are kept, "
                                 "10 are new; the earlier results would be renamed to 's.1.h5'"));
  EXPECT_THAT(dry.out, HasSubstr("b: 10 of 18 runs would be executed, into 's.h5'"));
  EXPECT_EQ(program_.Read("s.h5"), bytes);
  EXPECT_FALSE(program_.Exists("s.runs"));

  const Finished run = program_.Run({"run", "s.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("8 of 18 runs are kept, 10 are new; the earlier results are now "
                                 "'s.1.h5'"));
  EXPECT_EQ(program_.Read("s.1.h5"), bytes);
  const auto now = StartsIn(At("s.h5"));
  EXPECT_EQ(now.size(), 18u);
  for (const auto& [place, started] : before) EXPECT_EQ(now.at(place), started) << place;
  ExpectAsFresh("s.h5");
  EXPECT_THAT(program_.Run({"run", "s.cdb", "--dry-run"}).out, HasSubstr("nothing would be"));
}

TEST_F(Edited, KeepsNothingThatAnotherCdbOrMachineMade) {
  Edit("5, 20", 1);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 0);
  Edit("5, 20, 30", 1);
  const plans::SizedPlan sized = {CompileText(Scenario("5, 20, 30", 1)).plans.at(0), nullptr, {}};
  results::Provenance elsewhere = options::CollectProvenance();
  elsewhere["bullet_version"] = "2.0";
  elsewhere["host"] = "elsewhere";
  const auto earlier = plans::KeepEarlierRuns(sized, At("s.h5"), elsewhere);
  ASSERT_TRUE(earlier);
  EXPECT_EQ(earlier->kept, 0u);
  EXPECT_EQ(earlier->others, 4u);
  EXPECT_THAT(Describe(*earlier, "b", false),
              HasSubstr("4 of them run again, as the bullet_version, host differs"));
  EXPECT_TRUE(RunsIn(At("s.runs")).empty());
}

/// The scenario is edited while results and an unfinished sweep are there.
TEST_F(Edited, KeepsTheRunsOfAnUnfinishedSweep) {
  Edit("5, 20", 1);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "--shard", "1/2"}).status, 0);
  const std::size_t finished = RunsIn(At("s.runs")).size();
  ASSERT_GT(finished, 0u);
  Edit("5, 20, 30", 1);
  EXPECT_THAT(program_.Run({"run", "s.cdb", "--dry-run"}).out,
              HasSubstr(fmt::format("{} of 6 runs are kept", finished)));
  const Finished run = program_.Run({"run", "s.cdb"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, HasSubstr(fmt::format("{} of 6 runs are kept", finished)));
  // A part of the sweep has all detectors of a point.
  for (const std::size_t quantity : {0, 1})
    EXPECT_EQ(results::ResultFile(At("s.1.h5")).ReadStatus({{0, quantity}, 0}),
              results::ResultFile(At("s.1.h5")).ReadStatus({{1, quantity}, 0}));
  ExpectAsFresh("s.h5");
}

/// Results of plan A, and an interrupted `--fresh` of plan B in the same place: both are set aside.
TEST_F(Edited, SetsAsideBothResultsAndAnInterruptedFreshSweep) {
  Edit("5", 1);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 0);
  const plan::Plan fresh = CompileText(Scenario("20, 30", 1)).plans.at(0);
  Edit("20, 30", 1);
  for (const char* part : {"1/2", "2/2"})
    ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "--shard", part, "-o", "other.h5"}).status, 0);
  fs::rename(At("other.runs"), At("s.runs"));
  journal::Ask(At("s.runs"), fresh.Sha256(), journal::kFresh, fresh.Sha256());
  Edit("20, 40", 1);
  const Finished run = program_.Run({"run", "s.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("2 of 4 runs are kept"));
  EXPECT_EQ(Hashes(At("s.1.h5")).size(), 2u);
  EXPECT_EQ(Hashes(At("s.2.h5")).size(), 4u);
  ExpectAsFresh("s.h5");
}

/// A run that the results only have a place for is no copy of theirs.
TEST_F(Edited, LosesNoRunOfASweepBesidePartialResults) {
  Edit("5, 20", 1);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "--shard", "1/2", "-o", "a.h5"}).status, 0);
  ASSERT_EQ(program_.Run({"merge", "-o", "s.h5", "a.runs"}).status, 0);
  Edit("5, 20, 30", 1);
  for (const char* part : {"1/2", "2/2"})
    ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "--shard", part, "-o", "b.h5"}).status, 0);
  fs::rename(At("b.runs"), At("s.runs"));
  const auto finished = RunsIn(At("s.runs"));
  EXPECT_EQ(finished.size(), 6u);
  Edit("40", 1);
  EXPECT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 0);
  EXPECT_EQ(Hashes(At("s.2.h5")).size(), 6u);
}

TEST_F(Edited, RefusesForAPartAndForOneRun) {
  Edit("5, 20", 1);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 0);
  const std::string bytes = program_.Read("s.h5");
  const std::string id = Hashes(At("s.h5")).begin()->first;
  Edit("5, 20, 30", 1);
  for (const auto& more :
       std::vector<std::vector<std::string>>{{"--shard", "1/2"}, {"--only", id, "-o", "s.h5"}}) {
    std::vector<std::string> words = {"run", "s.cdb"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished refused = program_.Run(words);
    EXPECT_EQ(refused.status, 2);
    EXPECT_THAT(refused.err, HasSubstr("another plan"));
  }
  EXPECT_EQ(program_.Read("s.h5"), bytes);
}

/// All files of a folder, and all finished runs in them, by id.
std::set<std::string> RunsAnywhere(const fs::path& folder) {
  std::set<std::string> ids;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".runs")
      for (const auto& [id, written] : RunsIn(entry.path())) ids.insert(id);
    if (entry.path().extension() == ".h5")
      for (const auto& [id, hash] : Hashes(entry.path())) ids.insert(id);
  }
  return ids;
}

/// The states that a kill leaves, one after each step that changes the disk: a call after it loses
/// no finished run, and runs no more than one that was not killed.
TEST_F(Edited, AKillAfterAnyStepLosesNothing) {
  Edit("5, 20", 1);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 0);
  const std::set<std::string> finished = RunsAnywhere(program_.folder());
  fs::copy(At("s.h5"), At("whole"));
  Edit("5, 20, 30", 1);
  const plan::Plan plan = CompileText(Scenario("5, 20, 30", 1)).plans.at(0);
  const plans::SizedPlan sized = {plan, nullptr, {}};
  enum Step {
    kNothing,
    kFolder,
    kPlanFile,
    kEmptyJournal,
    kSomeCopied,
    kAllCopied,
    kRenamed,
    kEnd
  };
  for (int step = kNothing; step < kEnd; ++step) {
    SCOPED_TRACE(step);
    for (const char* name : {"s.h5", "s.1.h5", "s.2.h5"}) fs::remove(At(name));
    fs::remove_all(At("s.runs"));
    fs::copy(At("whole"), At("s.h5"));
    if (step == kSomeCopied || step >= kAllCopied) {
      ASSERT_TRUE(plans::KeepEarlierRuns(sized, At("s.h5"), options::CollectProvenance()));
      if (step < kRenamed) fs::rename(At("s.1.h5"), At("s.h5"));
      if (step == kSomeCopied)
        journal::Journal::OpenToWrite(At("s.runs"), plan.Sha256()).Forget(*finished.begin());
    } else if (step >= kFolder) {
      fs::create_directory(At("s.runs"));
      if (step >= kPlanFile) {
        ASSERT_EQ(program_.Run({"plan", "s.cdb", "-o", "s.runs/plan.yaml"}).status, 0);
      }
      if (step >= kEmptyJournal) journal::Journal::OpenToWrite(At("s.runs"), plan.Sha256());
    }
    const Finished run = program_.Run({"run", "s.cdb"});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("6 runs, 4 of them already done"));
    EXPECT_FALSE(program_.Exists("s.2.h5"));
    EXPECT_EQ(program_.Read("s.1.h5"), program_.Read("whole"));
    const std::set<std::string> now = RunsAnywhere(program_.folder());
    for (const std::string& id : finished) EXPECT_TRUE(now.contains(id)) << id << " is lost";
  }
  // Killed while copying, and edited once more: what was copied is still in the results.
  for (const char* name : {"s.h5", "s.1.h5"}) fs::remove(At(name));
  fs::copy(At("whole"), At("s.h5"));
  ASSERT_TRUE(plans::KeepEarlierRuns(sized, At("s.h5"), options::CollectProvenance()));
  fs::rename(At("s.1.h5"), At("s.h5"));
  Edit("5, 20, 40", 1);
  EXPECT_THAT(program_.Run({"run", "s.cdb"}).err, HasSubstr("4 of 6 runs are kept"));
  EXPECT_FALSE(program_.Exists("s.2.h5"));
}

TEST(Aside, NeverReplacesAFile) {
  const TemporaryFolder folder;
  for (const char* name : {"x.h5", "x.1.h5", "x.3.h5", "plain"}) WriteFile(folder / name, name);
  EXPECT_EQ(files::SetAside(folder / "x.h5"), folder / "x.2.h5");
  EXPECT_EQ(ReadFile(folder / "x.2.h5"), "x.h5");
  EXPECT_EQ(files::SetAside(folder / "plain"), folder / "plain.1");
  EXPECT_THROW(files::SetAside(folder / "nothing"), files::StoreError);
}

TEST(Changes, AreNamedAsInTheScenario) {
  const auto changes = [](const std::string& before, const std::string& now) {
    return plans::DescribeChanges(CompileText(before).plans.at(0), CompileText(now).plans.at(0));
  };
  const std::string one = "benchmark b { cycles 5; objects { quantity 100 } }";
  EXPECT_EQ(changes(one, "benchmark b { cycles 5; objects { quantity 200 } }"),
            "objects.quantity 100 -> 200, world.side 5000 -> 10000");
  EXPECT_EQ(changes(one,
                    "benchmark b { cycles 5; detector sweep(dbvt, sap); repeats 3\n"
                    "objects { quantity 100 } }"),
            "detector + sap, repeats 1 -> 3");
  EXPECT_EQ(changes("benchmark b { cycles sweep(5, 6, 7); objects { quantity 100 } }", one),
            "cycles - 6, 7");
  EXPECT_THAT(changes(one, "benchmark b { cycles 5; objects stones { quantity 100 } }"),
              HasSubstr("stones.quantity + 100"));
}

TEST(ResultNames, FollowTheFileWithOneBenchmark) {
  const Program program;
  program.Write("one.cdb", "benchmark tower { cycles 2 }\n");
  program.Write("two.cdb", "benchmark a { cycles 2 }\nbenchmark b { cycles 3 }\n");
  const Finished none = program.Run({"show", "one.cdb"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, HasSubstr("('one.h5'): `cdb run one.cdb` makes them"));
  ASSERT_EQ(program.Run({"run", "-q", "one.cdb"}).status, 0);
  ASSERT_EQ(program.Run({"run", "-q", "two.cdb"}).status, 0);
  EXPECT_TRUE(program.Exists("one.h5") && program.Exists("a.h5") && program.Exists("b.h5"));
  EXPECT_EQ(program.Run({"show", "one.cdb"}).out, program.Run({"show", "one.h5"}).out);
  EXPECT_EQ(program.Run({"report", "one.cdb"}).status, 0);
  EXPECT_TRUE(program.Exists("one.html"));
  EXPECT_THAT(program.Run({"show", "two.cdb"}).err, HasSubstr("several results: a.h5, b.h5"));
  // As an earlier cdb named it.
  fs::rename(program.folder() / "one.h5", program.folder() / "tower.h5");
  for (const char* name : {"one.cdb", "one.h5"}) {
    const Finished show = program.Run({"show", name});
    EXPECT_EQ(show.status, 0);
    EXPECT_THAT(show.err, HasSubstr("are in 'tower.h5'"));
  }
  EXPECT_EQ(program.Run({"run", "-q", "one.cdb"}).status, 0);
  EXPECT_FALSE(program.Exists("one.h5"));
  // It is of another file.
  program.Write("other.cdb", "benchmark tower { cycles 3 }\n");
  EXPECT_EQ(program.Run({"run", "-q", "other.cdb"}).status, 0);
  EXPECT_TRUE(program.Exists("other.h5"));
  ASSERT_EQ(program.Run({"run", "-q", "--shard", "1/2", "one.cdb", "-o", "left.h5"}).status, 0);
  EXPECT_THAT(program.Run({"show", "left.h5"}).err, HasSubstr("only an unfinished sweep"));
}

TEST(Set, IsForCheckViewAndSubmit) {
  const Program program;
  program.Write("a.cdb", "benchmark a { cycles 4; objects.quantity 9 }\n");
  EXPECT_EQ(program.Run({"check", "a.cdb", "--set", "cycles=5"}).status, 0);
  EXPECT_EQ(program.Run({"check", "a.cdb", "--set", "cycle=5"}).status, 1);
  EXPECT_THAT(program.Run({"view", "a.cdb", "--set", "objects.quantity=3"}).err,
              HasSubstr("3 objects"));
  EXPECT_EQ(program.Run({"view", "a.cdb", "--serve", "--set", "cycles=3"}).status, 2);
  EXPECT_THAT(program.Run({"submit", "a.cdb", "--dry-run", "--set", "cycles=5"}).out,
              HasSubstr("--set cycles=5 -o"));
}

}  // namespace
}  // namespace cdb::tests
