// Job scripts, executed by the shell with a stub for cdb.
#include "runtime/sweep/cluster/submission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "runtime/sweep/cluster/slurm.h"
#include "runtime/sweep/process/program.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

TEST(IndexList, JoinsNeighbours) {
  EXPECT_EQ(cluster::IndexList({}), "");
  EXPECT_EQ(cluster::IndexList({7}), "7");
  EXPECT_EQ(cluster::IndexList({1, 2, 3, 7, 9, 10}), "1-3,7,9-10");
}

TEST(LogName, IsKnownAgain) {
  EXPECT_TRUE(cluster::IsLogName(cluster::LogName("12", 3)));
  EXPECT_TRUE(cluster::IsLogName("slurm-13.log"));
  for (const char* other : {"slurm-.log", "slurm-x.log", "slurm-12_3.txt", "my-slurm-1.log", ""})
    EXPECT_FALSE(cluster::IsLogName(other)) << other;
}

/// Paths with every character that a shell treats specially.
class JobScript : public testing::Test {
 protected:
  JobScript() {
    fs::create_directories(sweep_.files.runs);
    WriteFile(sweep_.files.runs / "plan.yaml", "");
    SetProgram("exit 0");
  }
  /// `body` runs after the arguments have been recorded.
  void SetProgram(const std::string& body) const {
    WriteFile(sweep_.files.program, "#!/bin/sh\npwd >>'" + noted_ +
                                        "'\nfor word; do echo \"$word\"; done >>'" + noted_ +
                                        "'\n" + body + "\n");
    fs::permissions(sweep_.files.program, fs::perms::owner_all);
  }
  process::ProgramEnd Run(const cluster::Job& job) const {
    setenv("SLURM_ARRAY_TASK_ID", "2", 1);
    return *process::RunProgram({"sh"}, job.script);
  }
  std::string Noted() const { return ReadFile(noted_); }

  const TemporaryFolder root_;
  const std::string noted_ = (root_ / "noted").string();
  const fs::path odd_ = root_ / "it's \"$HOME\" `x` \\ 100%j *";
  const cluster::Sweep sweep_ = {
      "rain",
      {odd_ / "a cdb", odd_, odd_ / "out.runs", odd_ / "out.runs/plan.yaml", odd_ / "out;.h5"},
      3,
      2,
      {1, 3}};
  const cluster::JobOptions options_;
};

TEST_F(JobScript, ATaskExecutesItsPart) {
  const auto end = Run(cluster::ArrayJob(sweep_, options_));
  EXPECT_EQ(end.status, 0) << end.err;
  const std::string odd = odd_.string();
  EXPECT_EQ(Noted(), odd + "\nrun\n-q\n" + odd + "/out.runs/plan.yaml\n-o\n" + odd +
                         "/out;.h5\n--shard\n2/3\n");
}

TEST_F(JobScript, TheMergeRemovesWhatItMerged) {
  EXPECT_EQ(Run(cluster::MergeJob(sweep_, options_, "12")).status, 0);
  EXPECT_THAT(Noted(), HasSubstr("merge\n--wait\n90\n--remove\n-o\n"));
}

TEST_F(JobScript, AKilledCdbIsStartedAgainAndOthersAreNot) {
  const cluster::Job job = cluster::ArrayJob(sweep_, options_);
  const auto starts = [&](const std::string& body, int status) {
    fs::remove(noted_);
    SetProgram(body);
    EXPECT_EQ(Run(job).status, status) << body;
    const std::string noted = Noted();
    std::size_t count = 0;
    for (std::size_t at = 0; (at = noted.find("--shard", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(starts("exit 3", 0), 1u) << "a run that failed is a result";
  EXPECT_EQ(starts("exit 2", 2), 1u);
  EXPECT_EQ(starts("kill -TERM $$", 143), 1u);
  EXPECT_EQ(starts("kill -KILL $$", 75), 3u);
}

TEST_F(JobScript, SaysWhatANodeLacks) {
  fs::remove(sweep_.files.program);
  const auto end = Run(cluster::ArrayJob(sweep_, options_));
  EXPECT_EQ(end.status, 2);
  EXPECT_THAT(end.err, HasSubstr("does not have cdb"));
}

TEST_F(JobScript, WordsAreThoseOfSbatch) {
  const auto words =
      cluster::ArrayJob(sweep_, {"long", "1:00:00", "physics", true, {"--mem=2G"}}).words;
  for (const char* word :
       {"--parsable", "--array=1,3", "--cpus-per-task=2", "--requeue", "--exclusive",
        "--partition=long", "--time=1:00:00", "--account=physics", "--mem=2G"})
    EXPECT_THAT(words, Contains(word));
  const auto plain = cluster::ArrayJob(sweep_, options_).words;
  EXPECT_THAT(plain, Not(Contains("--exclusive")));
  EXPECT_THAT(plain, Not(Contains(HasSubstr("--partition"))));
  EXPECT_THAT(cluster::MergeJob(sweep_, options_, "12").words,
              Contains("--dependency=afterany:12"));
}

TEST_F(JobScript, TheDryRunIsAScriptThatSubmitsBoth) {
  const fs::path binaries = root_ / "bin";
  fs::create_directory(binaries);
  // Prints an id as a federation of clusters does, and executes the script.
  WriteFile(binaries / "sbatch", "#!/bin/sh\nfor word; do echo \"$word\"; done >>'" + noted_ +
                                     "'\nsh >&2\necho '12;bench'\n");
  fs::permissions(binaries / "sbatch", fs::perms::owner_all);
  const std::string script =
      "PATH='" + binaries.string() + "':$PATH\n" + cluster::DryRunText(sweep_, options_, "true");
  setenv("SLURM_ARRAY_TASK_ID", "1", 1);
  const auto end = process::RunProgram({"sh"}, script);
  EXPECT_EQ(end->status, 0) << end->err;
  EXPECT_THAT(Noted(), HasSubstr("--shard\n1/3\n"));
  EXPECT_THAT(Noted(), HasSubstr("--dependency=afterany:12\n"));
  EXPECT_THAT(Noted(), HasSubstr("merge\n--wait\n"));
  EXPECT_THAT(Noted(), HasSubstr("--chdir=" + odd_.string() + "/out.runs\n"));
}

TEST_F(JobScript, ALineBreakInANameIsRefused) {
  cluster::Sweep sweep = sweep_;
  sweep.files.out = "two\nlines.h5";
  EXPECT_THROW(cluster::ArrayJob(sweep, options_), std::invalid_argument);
}

}  // namespace
}  // namespace cdb::tests
