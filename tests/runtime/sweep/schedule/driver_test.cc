// A sweep whose driver is killed, started twice, stopped, or out of disk space, with real processes
// and the real store.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <string>
#include <thread>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/results/journal/journals.h"
#include "runtime/sweep/schedule/schedule.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/runtime/sweep/schedule/plans.h"
#include "tests/support/folders.h"

extern char** environ;

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

class DriverTest : public testing::Test {
 protected:
  /// Starts a driver; its output goes to `log`.
  pid_t Start(const plan::Plan& plan, int jobs = 1, const std::string& file_limit = "") {
    WriteFile(root.path() / "plan.yaml", yaml::ToYaml(plan));
    const std::string binaries = BuildFolder();
    std::vector<std::string> words = {binaries + "/schedule_test_driver",
                                      (root.path() / "plan.yaml").string(), folder.string(),
                                      std::to_string(jobs), binaries + "/schedule_test_worker"};
    if (!file_limit.empty()) words.push_back(file_limit);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    pid_t pid = -1;
    EXPECT_EQ(posix_spawn(&pid, arguments[0], &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    running = pid;
    return pid;
  }

  /// A test that fails leaves no driver behind; its workers end with it.
  void TearDown() override {
    if (running < 0) return;
    kill(running, SIGKILL);
    waitpid(running, nullptr, 0);
  }

  /// The exit status, or the negative signal.
  int Wait(pid_t pid) {
    int status = 0;
    EXPECT_EQ(waitpid(pid, &status, 0), pid);
    running = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  int Run(const plan::Plan& plan, int jobs = 1, const std::string& file_limit = "") {
    return Wait(Start(plan, jobs, file_limit));
  }

  /// When each finished run was written.
  std::map<std::string, std::int64_t> Runs() const { return RunsIn(folder); }

  /// Expects a complete record for every run, with the values that the test worker writes, and
  /// nothing else in the folder.
  void ExpectComplete(const plan::Plan& plan) const {
    EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"plan.yaml", "runs.journal"}));
    EXPECT_EQ(Runs().size(), plan.runs.size());
    journal::Merge(plan, {}, folder, root.path() / "merged.h5");
    const results::ResultFile file(root.path() / "merged.h5");
    for (const plan::Run& run : plan.runs) {
      EXPECT_EQ(file.ReadStatus({run.at, run.rep}), results::Status::kDone);
      const std::vector<double> pairs = file.ReadSeries("pairs", {run.at, run.rep});
      ASSERT_EQ(pairs.size(), 10u);
      for (std::size_t i = 0; i < 10; ++i)
        EXPECT_EQ(pairs[i], static_cast<double>(i * run.scene.ObjectCount()));
    }
  }

  /// Waits until `driver` has written this number of runs, or has ended.
  void WaitForRuns(std::size_t count, pid_t driver) const {
    siginfo_t ended = {};
    while (Runs().size() < count && ended.si_pid == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      waitid(P_PID, static_cast<id_t>(driver), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
  }

  TemporaryFolder root;
  fs::path folder = root.path() / "study.runs";
  fs::path log = root.path() / "log";
  pid_t running = -1;
};

TEST_F(DriverTest, TwentyKillsLoseNoFinishedRun) {
  PlanShape shape;
  shape.quantities.clear();
  for (std::uint64_t i = 0; i < 40; ++i) shape.quantities.push_back(i);
  const plan::Plan plan = MakePlan(shape);
  std::mt19937 random(20);
  std::map<std::string, std::int64_t> finished;
  for (int kill_number = 0; kill_number < 20; ++kill_number) {
    const pid_t driver = Start(plan, 1 + kill_number % 2);
    // Any moment, from before it has started to several runs later.
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 60'000));
    kill(driver, SIGKILL);
    const int end = Wait(driver);
    EXPECT_TRUE(end == -SIGKILL || end == 0) << end << ReadFile(log);
    const auto now = Runs();
    for (const auto& [name, when] : finished) {
      const auto found = now.find(name);
      ASSERT_NE(found, now.end()) << name << " was finished and is gone";
      EXPECT_EQ(found->second, when) << name << " was finished and run again";
    }
    journal::Journals journals({folder});
    for (const auto& [id, when] : now) EXPECT_TRUE(journals.Find(id));
    finished = now;
  }
  EXPECT_EQ(Run(plan), 0) << ReadFile(log);
  ExpectComplete(plan);
}

TEST_F(DriverTest, TwoDriversFillOneFolder) {
  PlanShape shape;
  shape.quantities = {1, 2, 3, 4, 5, 6, 7, 8};
  const plan::Plan plan = MakePlan(shape);
  const pid_t one = Start(plan);
  const pid_t two = Start(plan, 2);
  EXPECT_EQ(Wait(one), 0) << ReadFile(log);
  EXPECT_EQ(Wait(two), 0) << ReadFile(log);
  ExpectComplete(plan);
}

TEST_F(DriverTest, OneJobAndTwoGiveTheSame) {
  const plan::Plan plan = MakePlan({.repeats = 2});
  EXPECT_EQ(Run(plan, 1), 0) << ReadFile(log);
  ExpectComplete(plan);
  fs::remove_all(folder);
  EXPECT_EQ(Run(plan, 2), 0) << ReadFile(log);
  ExpectComplete(plan);
}

TEST_F(DriverTest, ASignalKeepsWhatIsFinishedAndEndsTheWorkers) {
  // The runs of the second quantity never end.
  plan::Plan plan = MakePlan({.quantities = {1, 2}, .detectors = {"dbvt", "sap"}});
  for (const std::size_t i : {2, 3}) {
    plan.runs[i].scene.world.Set("seed", std::uint64_t{kHangsDeaf});
    plan.runs[i].id = plan::RunId(plan.runs[i].scene, plan.runs[i].rep);
  }
  for (const int signal_number : {SIGINT, SIGTERM}) {
    fs::remove_all(folder);
    const pid_t driver = Start(plan, 2);
    WaitForRuns(2, driver);
    kill(driver, signal_number);
    EXPECT_EQ(Wait(driver), 128 + signal_number) << ReadFile(log);
    EXPECT_EQ(Runs().size(), 2u);
    EXPECT_NE(ReadFile(log).find("4 runs: 2 done, 2 not run"), std::string::npos) << ReadFile(log);
  }
}

TEST_F(DriverTest, AFullDiskKeepsWhatIsFinished) {
  PlanShape shape;
  shape.quantities = {1, 2, 3, 4, 5, 6, 7, 8};
  shape.detectors = {"dbvt"};
  plan::Plan plan = MakePlan(shape);
  fs::create_directories(folder);
  WriteFile(folder / "plan.yaml", yaml::ToYaml(plan));
  {
    auto journal = journal::Journal::OpenToWrite(folder, plan.Sha256());
    results::RunResult result;
    result.status = results::Status::kDone;
    const results::Provenance none;
    journal::RunWriter(plan, none).Write(plan.runs[0], result, journal);
  }
  const auto before = Runs();
  // The index of the log takes 32 KiB, and the log itself more than that for all runs.
  EXPECT_EQ(Run(plan, 1, "33000"), 2);
  const std::string text = ReadFile(log);
  EXPECT_NE(text.find(std::to_string(Runs().size()) + " of 8 runs are safe in " + folder.string()),
            std::string::npos)
      << text;
  EXPECT_LT(Runs().size(), 8u);
  EXPECT_EQ(Runs().at(before.begin()->first), before.begin()->second);

  EXPECT_EQ(Run(plan), 0) << ReadFile(log);
  EXPECT_EQ(Runs().size(), 8u);
  EXPECT_EQ(Runs().at(before.begin()->first), before.begin()->second);
}

TEST_F(DriverTest, BadRunsAreTheThirdExitStatus) {
  const plan::Plan plan = MakeBehaviourPlan({kFinishes, kFails, kSegfaults, kAborts});
  EXPECT_EQ(Run(plan, 2), 3);
  const std::string text = ReadFile(log);
  EXPECT_NE(text.find("4 runs: 1 done, 1 failed, 2 crashed"), std::string::npos) << text;
  EXPECT_NE(text.find("the cube is 140 % full"), std::string::npos) << text;
  const auto record = journal::Journals({folder}).Find(plan.runs[2].id).value();
  EXPECT_EQ(journal::InfoOf(record).outcome.status, results::Status::kCrashed);
  EXPECT_EQ(record.Number("n_cycles"), 3);
  EXPECT_EQ(record.Text("run/message"),
            "the worker was ended by signal 11 (SIGSEGV, Segmentation fault)");
}

}  // namespace
}  // namespace cdb::tests
