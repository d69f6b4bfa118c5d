// No finished run is lost: the program is killed at any moment, or meets errors of the environment.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

// 3 x 2 x 2 runs that take long enough to be hit.
const char kSweep[] =
    "benchmark sweep {\n  cycles 60\n  world.side 600\n  objects { quantity sweep(20, 60, 120)\n"
    "    type any(sphere, cuboid, cone); linear_velocity uniform(-300, 300) }\n"
    "  detector sweep(sap32, dbvt)\n  precision sweep(single, double)\n}\n";

/// `hash hash …` in the order of the grid; `-` for a missing run.
std::string HashesInOrder(const fs::path& path) {
  const results::ResultFile file(path);
  std::string all;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 2; ++b)
      for (std::size_t c = 0; c < 2; ++c) {
        const results::ResultFile::Cell cell = {{a, b, c}, 0};
        all += file.ReadStatus(cell) == results::Status::kDone ? file.ReadText("state_hash", cell)
                                                               : "-";
        all += ' ';
      }
  return all;
}

TEST(Kill, ManyTimesAtRandomMomentsLosesNothing) {
  const Program program;
  program.Write("sweep.cdb", kSweep);
  ASSERT_EQ(program.Run({"run", "sweep.cdb", "-q", "-o", "alone.h5"}).status, 0);
  const std::string expected = HashesInOrder(program.folder() / "alone.h5");
  ASSERT_EQ(expected.find('-'), std::string::npos);

  // The moments are chosen from the duration of a whole sweep on this machine.
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(program.Run({"run", "sweep.cdb", "-q", "-o", "timed.h5"}).status, 0);
  const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - begin;

  std::mt19937_64 random(20);
  const int enough = std::max(5, Cases(20));
  int kills = 0;
  std::map<std::string, std::int64_t> kept;
  for (int round = 0; kills < enough; ++round) {
    ASSERT_LT(round, 200) << "no run is ever caught";
    const std::string jobs = round % 2 == 0 ? "1" : "2";
    const pid_t child = program.Start(
        {CdbPath(), "run", "sweep.cdb", "-q", "-j", jobs, "--shared-timings", "-o", "killed.h5"});
    const double part = static_cast<double>(random() >> 11) * 0x1p-53;
    std::this_thread::sleep_for(whole * part * 0.5);
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    const auto now = RunsIn(program.folder() / "killed.runs");
    if (fs::exists(program.folder() / "killed.h5")) {
      // It ended before the kill: start again, so that every kill interrupts work.
      EXPECT_EQ(HashesInOrder(program.folder() / "killed.h5"), expected);
      fs::remove(program.folder() / "killed.h5");
      fs::remove_all(program.folder() / "killed.runs");
      kept.clear();
    } else {
      for (const auto& [id, written] : kept)
        EXPECT_TRUE(now.contains(id) && now.at(id) == written) << id << " is lost";
      kept = now;
    }
    if (WIFSIGNALED(status)) ++kills;
  }
  EXPECT_EQ(program.Run({"run", "sweep.cdb", "-q", "-o", "killed.h5"}).status, 0);
  EXPECT_EQ(HashesInOrder(program.folder() / "killed.h5"), expected);
  EXPECT_FALSE(program.Exists("killed.runs"));
  for (const auto& entry : fs::directory_iterator(program.folder()))
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path() << " is left over";
}

TEST(Kill, RightAfterTheMergeLeavesNoRunsForEver) {
  const Program program;
  program.Write("sweep.cdb", kSweep);
  ASSERT_EQ(program.Run({"run", "sweep.cdb", "-q", "--shard", "1/1"}).status, 0);
  fs::create_directory(program.folder() / "copy");
  fs::rename(program.folder() / "sweep.h5", program.folder() / "copy" / "sweep.h5");
  for (const char* part : {"1/2", "2/2"})
    ASSERT_EQ(program.Run({"run", "sweep.cdb", "-q", "--shard", part}).status, 0);
  fs::rename(program.folder() / "copy" / "sweep.h5", program.folder() / "sweep.h5");
  ASSERT_TRUE(program.Exists("sweep.runs"));
  EXPECT_EQ(program.Run({"run", "sweep.cdb", "-q"}).status, 0);
  EXPECT_FALSE(program.Exists("sweep.runs"));
}

TEST(Stop, CtrlCKeepsWhatIsFinished) {
  const Program program;
  program.Write("long.cdb",
                "benchmark long { cycles 2000; world.side 2000; objects.quantity sweep(5 .. 60) }");
  const pid_t child = program.Start({CdbPath(), "run", "long.cdb", "-q"});
  while (RunsIn(program.folder() / "long.runs").empty())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(child, SIGINT);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_NE(program.Read("stderr.txt").find("the same command resumes"), std::string::npos);
  EXPECT_FALSE(RunsIn(program.folder() / "long.runs").empty());
  EXPECT_EQ(program.Run({"merge", "-o", "part.h5", "long.runs"}).status, 0);
  EXPECT_EQ(results::ResultFile(program.folder() / "part.h5").ReadStatus({{55}, 0}),
            results::Status::kMissing);
}

/// Two runs of five are finished and must not be lost.
class World : public testing::Test {
 protected:
  void SetUp() override {
    program_.Write("w.cdb", "benchmark w { cycles 5; objects.quantity sweep(2 .. 6) }");
    ASSERT_EQ(program_.Run({"run", "w.cdb", "-q", "--shard", "1/3"}).status, 0);
    runs_ = RunsIn(program_.folder() / "w.runs");
    ASSERT_FALSE(runs_.empty());
  }

  /// Exit status 2, a message that has all of `parts`, and no run lost.
  void ExpectRefused(const Finished& finished, const std::vector<std::string>& parts) {
    EXPECT_EQ(finished.status, 2) << finished.err;
    for (const std::string& part : parts)
      EXPECT_NE(finished.err.find(part), std::string::npos) << part << " in: " << finished.err;
    const auto now = RunsIn(program_.folder() / "w.runs");
    for (const auto& [id, written] : runs_) EXPECT_TRUE(now.contains(id) && now.at(id) == written);
    EXPECT_FALSE(program_.Exists("w.h5"));
  }

  Program program_;
  std::map<std::string, std::int64_t> runs_;
};

TEST_F(World, MissingFolder) {
  ExpectRefused(program_.Run({"run", "w.cdb", "-o", "no/such/w.h5"}), {"no/such", "no/such/w.h5"});
}

TEST_F(World, MissingFile) {
  ExpectRefused(program_.Run({"run", "nowhere.cdb"}), {"nowhere.cdb", "No such file"});
  ExpectRefused(program_.Run({"show", "nowhere.h5"}), {"nowhere.h5"});
  ExpectRefused(program_.Run({"plan", "nowhere.yaml"}), {"nowhere.yaml"});
}

TEST_F(World, FullDisk) {
  // To a writer, a limit on the size of files looks like a full disk. 32 blocks of 512 bytes are
  // too few for the log of a journal.
  ExpectRefused(program_.Shell("trap '' XFSZ; ulimit -f 32; exec \"$CDB\" run w.cdb"), {"w.runs"});
  EXPECT_EQ(program_.Run({"run", "w.cdb", "-q"}).status, 0);
}

TEST_F(World, TargetCannotBeWritten) {
  // Root may write anywhere, so the target is a name that cannot be a file.
  fs::create_directory(program_.folder() / "w.h5.d");
  ExpectRefused(program_.Run({"run", "w.cdb", "-o", "w.cdb/w.h5"}), {"w.cdb"});
  if (geteuid() != 0) {
    fs::create_directory(program_.folder() / "locked");
    fs::permissions(program_.folder() / "locked", fs::perms::owner_read | fs::perms::owner_exec);
    ExpectRefused(program_.Run({"run", "w.cdb", "-o", "locked/w.h5"}), {"locked"});
  }
}

TEST_F(World, JournalOfAnotherPlan) {
  program_.Write("w.cdb", "benchmark w { cycles 6; objects.quantity sweep(2 .. 6) }");
  ExpectRefused(program_.Run({"run", "w.cdb", "--shard", "1/3"}),
                {"w.runs", "another plan", "--fresh"});
  // A whole sweep merges its runs and sets them aside.
  EXPECT_EQ(program_.Run({"run", "w.cdb", "-q"}).status, 0);
  const results::ResultFile aside(program_.folder() / "w.1.h5");
  std::size_t done = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    if (aside.ReadStatus({{i}, 0}) != results::Status::kDone) continue;
    ++done;
    EXPECT_TRUE(runs_.contains(aside.ReadText("run_id", {{i}, 0})));
  }
  EXPECT_EQ(done, runs_.size());
}

TEST_F(World, ResultsThatWouldShareAFolderOfRuns) {
  ASSERT_EQ(program_.Run({"run", "w.cdb", "-q", "-o", "x"}).status, 0);
  ExpectRefused(program_.Run({"run", "w.cdb", "-o", "x.h5"}), {"'x'", "x.runs", "-o"});
  fs::rename(program_.folder() / "x", program_.folder() / "x.h5");
  const std::string before = program_.Read("x.h5");
  ExpectRefused(program_.Run({"run", "w.cdb", "-o", "x", "--fresh"}), {"'x.h5'", "x.runs", "-o"});
  EXPECT_EQ(program_.Read("x.h5"), before);
  EXPECT_EQ(program_.Run({"run", "w.cdb", "-q", "-o", "x.h5.h5"}).status, 0);
  program_.Write("w", "a file that is no results file");
  EXPECT_EQ(program_.Run({"run", "w.cdb", "-q"}).status, 0);
}

TEST_F(World, ATruncatedJournalIsSetAsideAndItsRunsRunAgain) {
  const fs::path journal = program_.folder() / "w.runs" / "runs.journal";
  fs::resize_file(journal, fs::file_size(journal) / 2);
  const Finished finished = program_.Run({"run", "w.cdb"});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_NE(finished.err.find("it is now runs.journal.broken"), std::string::npos) << finished.err;
  EXPECT_EQ(results::ResultFile(program_.folder() / "w.h5").ReadStatus({{4}, 0}),
            results::Status::kDone);
  EXPECT_FALSE(program_.Exists("w.runs"));
}

TEST_F(World, MissingWorker) {
  fs::create_directory(program_.folder() / "bin");
  fs::copy_file(CdbPath(), program_.folder() / "bin" / "cdb");
  ExpectRefused(program_.Shell("bin/cdb run w.cdb"), {"cdb-worker-f32"});
}

TEST(Race, TwoRunnersOfOneResultBothEndWell) {
  const Program program;
  program.Write("sweep.cdb", kSweep);
  ASSERT_EQ(program.Run({"run", "sweep.cdb", "-q", "-o", "alone.h5"}).status, 0);
  for (int round = 0; round < Cases(5); ++round) {
    const pid_t one = program.Start({CdbPath(), "run", "sweep.cdb", "-q", "-o", "both.h5"});
    const pid_t two = program.Start({CdbPath(), "run", "sweep.cdb", "-q", "-o", "both.h5"});
    for (const pid_t runner : {one, two}) {
      int status = 0;
      ASSERT_EQ(waitpid(runner, &status, 0), runner);
      EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << program.Read("stderr.txt");
    }
    EXPECT_EQ(HashesInOrder(program.folder() / "alone.h5"),
              HashesInOrder(program.folder() / "both.h5"));
    EXPECT_FALSE(program.Exists("both.runs"));
    fs::remove(program.folder() / "both.h5");
  }
}

TEST_F(World, NoResultsFile) {
  program_.Write("text.h5", "this is no HDF5");
  ExpectRefused(program_.Run({"show", "text.h5"}), {"text.h5"});
  ExpectRefused(program_.Run({"merge", "-o", "x.h5", "text.h5"}), {"plan.yaml"});
  ExpectRefused(program_.Run({"merge", "-o", "x.h5", "w.runs", "no.runs"}), {"no.runs"});
}

}  // namespace
}  // namespace cdb::tests
