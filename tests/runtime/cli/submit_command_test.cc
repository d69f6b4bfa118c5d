// `cdb submit` with stubs for the programs of Slurm. tests/cluster/ uses the real ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/results/store.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Submit : public testing::Test {
 protected:
  Submit() {
    fs::create_directory(program_.folder() / "bin");
    program_.Write("s.cdb",
                   "benchmark s { cycles 4; world.side 500; objects.quantity sweep(2 .. 9) }");
    // Executes the tasks of an array one after the other, except those in `lost`.
    Stub("sbatch",
         "cat >script; echo \"$@\" >>said\n"
         "for word; do case $word in --array=*) list=${word#--array=};; esac; done\n"
         "if [ -n \"$list\" ]; then\n"
         "  echo \"$list\" | tr , '\\n' | while IFS=- read -r from to; do\n"
         "    for k in $(seq $from ${to:-$from}); do\n"
         "      [ -e lost.$k ] || SLURM_ARRAY_TASK_ID=$k sh script >&2\n"
         "    done\n"
         "  done\n"
         "else [ -e lost.merge ] || sh script >&2; fi\n"
         "n=$(cat ids 2>/dev/null || echo 40); n=$((n + 1)); echo $n >ids; echo $n");
    Stub("squeue", "cat active 2>/dev/null || true");
    Stub("sinfo", "echo 'bench*|0/8/0/8'");
    Stub("scontrol", "echo 'MaxArraySize            = 1001'");
    Stub("sacct", "exit 1");
    Stub("scancel", "echo \"$@\" >>cancelled");
  }
  void Stub(const std::string& name, const std::string& body) const {
    const fs::path file = program_.folder() / "bin" / name;
    // The files of the test are in the folder where cdb was started; tasks run elsewhere.
    WriteFile(file, "#!/bin/sh\ncd '" + program_.folder().string() + "'\n" + body + "\n");
    fs::permissions(file, fs::perms::owner_all);
  }
  Finished Run(const std::string& words) const {
    return program_.Shell("PATH=\"$PWD/bin:$PATH\" \"$CDB\" submit " + words);
  }
  results::ResultFile Results() const { return results::ResultFile(program_.folder() / "s.h5"); }

  const Program program_;
};

TEST_F(Submit, ExecutesMergesAndShows) {
  const Finished done = Run("s.cdb --tasks 3");
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.err, HasSubstr("submitted job 41: 3 of 3 tasks of 8 runs; and job 42"));
  EXPECT_THAT(done.out, HasSubstr("8 runs"));
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(Results().ReadStatus({{i}, 0}), results::Status::kDone);
  EXPECT_FALSE(program_.Exists("s.runs"));
  EXPECT_THAT(program_.Read("said"), HasSubstr("--dependency=afterany:41"));
  EXPECT_THAT(Run("s.cdb").err, HasSubstr("'s.h5' is complete"));
}

TEST_F(Submit, TheSameCommandSubmitsOnlyWhatIsMissing) {
  program_.Write("lost.2", "");
  const Finished first = Run("s.cdb --tasks 3");
  EXPECT_EQ(first.status, 2) << first.err;
  EXPECT_THAT(first.err, HasSubstr("runs are missing; the same command submits them again"));
  EXPECT_THAT(first.err, HasSubstr("slurm-*.log"));
  fs::remove(program_.folder() / "lost.2");
  const Finished second = Run("s.cdb");
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_THAT(second.err, HasSubstr("1 of 3 tasks"));
  EXPECT_THAT(program_.Read("said"), HasSubstr("--array=2 "));
  EXPECT_FALSE(program_.Exists("s.runs"));
}

TEST_F(Submit, RetryRunsJustTheCellsThatEndedSo) {
  // The third of the four runs always fails.
  program_.Write("s.cdb",
                 "benchmark s { cycles 4; world.side 500\n"
                 "acceleration (0, sweep(0, 1, -1e39, -1) as g, 0) }");
  EXPECT_EQ(Run("s.cdb --tasks 4").status, 3);
  ASSERT_EQ(Results().ReadStatus({{2}, 0}), results::Status::kFailed);
  const auto starts = [&] {
    std::vector<double> all;
    for (std::size_t i = 0; i < 4; ++i) all.push_back(Results().ReadReal("started", {{i}, 0}));
    return all;
  };
  std::vector<double> before = starts();

  program_.Write("lost.3", "");
  const Finished lost = Run("s.cdb --tasks 4 --retry failed,crashed");
  EXPECT_EQ(lost.status, 2) << lost.err;
  EXPECT_THAT(lost.err, HasSubstr("1 of 4 tasks"));
  EXPECT_THAT(program_.Read("said"), HasSubstr("--array=3 "));
  EXPECT_THAT(lost.err, HasSubstr("1 of 4 runs are missing"));
  EXPECT_EQ(starts(), before);

  // It continues, with or without these options.
  fs::remove(program_.folder() / "lost.3");
  program_.Write("lost.merge", "");
  const Finished again = Run("s.cdb");
  EXPECT_EQ(again.status, 3) << again.err;
  EXPECT_GT(starts()[2], before[2]);
  before[2] = starts()[2];
  EXPECT_EQ(starts(), before);
  EXPECT_FALSE(program_.Exists("s.runs"));

  fs::remove(program_.folder() / "lost.merge");
  EXPECT_EQ(Run("s.cdb --retry failed").status, 3);
  EXPECT_GT(starts()[2], before[2]);
  before[2] = starts()[2];
  EXPECT_EQ(starts(), before);
  EXPECT_FALSE(program_.Exists("s.runs"));
  EXPECT_THAT(Run("s.cdb --retry crashed").err,
              HasSubstr("no run of 's.h5' is crashed; nothing to repeat"));
  EXPECT_EQ(starts(), before);
}

TEST_F(Submit, RefusesARetryThatItCannotCarryOut) {
  const auto refused = [&](const std::string& words, const std::string& message) {
    const Finished finished = Run(words);
    EXPECT_EQ(finished.status, 2) << words;
    EXPECT_THAT(finished.err, HasSubstr(message)) << words;
  };
  refused("s.cdb --retry fialed", "did you mean 'failed'?");
  refused("s.cdb --retry failed --dry-run", "remove --retry");
  program_.Write("lost.1", "");
  EXPECT_EQ(Run("s.cdb --tasks 2").status, 2);
  refused("s.cdb --retry failed", "has finished runs that are not merged yet");
  fs::remove(program_.folder() / "lost.1");
  program_.Write("lost.merge", "");
  EXPECT_EQ(Run("s.cdb --tasks 2 --no-follow").status, 0);
  program_.Write("active", "RUNNING|None\nPENDING|Dependency\n");
  refused("s.cdb --retry failed", "retry when it has ended");
}

TEST_F(Submit, MergesWhereTheMergeWasLost) {
  program_.Write("lost.merge", "");
  const Finished done = Run("s.cdb --tasks 2");
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(Results().ReadStatus({{7}, 0}), results::Status::kDone);
  EXPECT_FALSE(program_.Exists("s.runs"));
}

TEST_F(Submit, AJobAtWorkIsFollowedAndNotSubmittedAgain) {
  program_.Write("lost.1", "");
  program_.Write("lost.merge", "");
  EXPECT_EQ(Run("s.cdb --tasks 2 --no-follow").status, 0);
  program_.Write("active", "RUNNING|None\nPENDING|Dependency\n");
  const Finished again = Run("s.cdb --no-follow");
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("job 41 is working on 's.h5'"));
  EXPECT_THAT(again.err, HasSubstr("`scancel 41 42` ends it"));
  EXPECT_THAT(again.err, Not(HasSubstr("submitted job")));
  Stub("squeue", "echo 'slurm_load_jobs error: Unable to contact slurm controller' >&2; exit 1");
  const Finished silent = Run("s.cdb --no-follow");
  EXPECT_EQ(silent.status, 2);
  EXPECT_THAT(silent.err, HasSubstr("cannot tell whether job 41 is still running"));
}

TEST_F(Submit, TheJobIsOfThePlanAsItWas) {
  program_.Write("lost.1", "");
  EXPECT_EQ(Run("s.cdb --tasks 2").status, 2);
  program_.Write("s.cdb", "benchmark s { cycles 5; world.side 500; objects.quantity 3 }");
  const Finished other = Run("s.cdb");
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("another plan"));
}

TEST_F(Submit, TheNumberOfTasksFitsWorkAndCluster) {
  EXPECT_THAT(Run("s.cdb --no-follow").err, HasSubstr("1 of 1 tasks")) << "a second of work";
  program_.Write("long.cdb",
                 "benchmark long { cycles 20000; world.side 2000; objects.quantity sweep(400 .. "
                 "499) }");
  const Finished script = Run("long.cdb --dry-run");
  EXPECT_THAT(script.out, HasSubstr("--array=1-15")) << "100 runs of 9 s, a minute in each";
  EXPECT_THAT(Run("long.cdb --dry-run --partition small").out, HasSubstr("--partition=small"));
  Stub("sinfo", "echo 'bench*|0/2/0/2'");
  EXPECT_THAT(Run("long.cdb --dry-run").out, HasSubstr("--array=1-8")) << "four for each core";
  EXPECT_THAT(Run("s.cdb --dry-run --tasks 100").out, HasSubstr("--array=1-8"))
      << "one run in each";
  const Finished many = Run("s.cdb --dry-run --tasks 5000");
  EXPECT_EQ(many.status, 2);
  EXPECT_THAT(many.err, HasSubstr("at most 1000 tasks"));
}

TEST_F(Submit, ADryRunChangesNothing) {
  const Finished script = Run("s.cdb --dry-run --tasks 2");
  EXPECT_EQ(script.status, 0) << script.err;
  EXPECT_FALSE(program_.Exists("s.runs"));
  EXPECT_FALSE(program_.Exists("said"));
  program_.Write("script.sh", script.out);
  const Finished run = program_.Shell("PATH=\"$PWD/bin:$PATH\" sh script.sh");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(Results().ReadStatus({{7}, 0}), results::Status::kDone);
}

TEST_F(Submit, ErrorsNameCauseAndRemedy) {
  const Finished none = program_.Shell("PATH=/nowhere \"$CDB\" submit s.cdb");
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, HasSubstr("sbatch is not in PATH"));
  EXPECT_THAT(none.err, HasSubstr("cdb doc cluster"));
  EXPECT_FALSE(program_.Exists("s.runs"));
  Stub("sbatch", "echo 'sbatch: error: invalid partition specified: x' >&2; exit 1");
  const Finished refused = Run("s.cdb");
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("invalid partition specified: x"));
  const Finished folder = Run("s.cdb -o nowhere/s.h5");
  EXPECT_EQ(folder.status, 2);
  EXPECT_THAT(folder.err, HasSubstr("the folder 'nowhere' of 'nowhere/s.h5' does not exist"));
}

}  // namespace
}  // namespace cdb::tests
