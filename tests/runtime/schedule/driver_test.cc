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
#include "runtime/schedule/schedule.h"
#include "tests/runtime/schedule/plans.h"
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
    return pid;
  }

  /// The exit status, or the negative signal.
  static int Wait(pid_t pid) {
    int status = 0;
    EXPECT_EQ(waitpid(pid, &status, 0), pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  int Run(const plan::Plan& plan, int jobs = 1, const std::string& file_limit = "") {
    return Wait(Start(plan, jobs, file_limit));
  }

  std::map<std::string, fs::file_time_type> Shards() const {
    std::map<std::string, fs::file_time_type> shards;
    if (!fs::exists(folder)) return shards;
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".h5")
        shards[entry.path().filename().string()] = fs::last_write_time(entry.path());
    return shards;
  }

  /// Expects a complete shard for every run, with the values that the test worker writes.
  void ExpectComplete(const plan::Plan& plan) const {
    EXPECT_EQ(Shards().size(), plan.runs.size());
    for (const plan::Run& run : plan.runs) {
      const fs::path shard = folder / (run.id + ".h5");
      ASSERT_TRUE(fs::exists(shard)) << run.id;
      const shards::ShardInfo info = shards::ReadShardInfo(shard);
      EXPECT_EQ(info.outcome.status, store::Status::kDone);
      EXPECT_EQ(info.plan_sha256, plan.Sha256());
      const store::ResultFile file(shard);
      const std::vector<double> pairs = file.ReadSeries("pairs", {{0, 0}, 0});
      ASSERT_EQ(pairs.size(), 10u);
      for (std::size_t i = 0; i < 10; ++i)
        EXPECT_EQ(pairs[i], static_cast<double>(i * run.scene.ObjectCount()));
    }
  }

  /// Waits until `driver` has written this number of shards, or has ended.
  void WaitForShards(std::size_t count, pid_t driver) const {
    siginfo_t ended = {};
    while (Shards().size() < count && ended.si_pid == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      waitid(P_PID, static_cast<id_t>(driver), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
  }

  TemporaryFolder root;
  fs::path folder = root.path() / "study.runs";
  fs::path log = root.path() / "log";
};

TEST_F(DriverTest, TwentyKillsLoseNoFinishedRun) {
  PlanShape shape;
  shape.quantities.clear();
  for (std::uint64_t i = 0; i < 40; ++i) shape.quantities.push_back(i);
  const plan::Plan plan = MakePlan(shape);
  std::mt19937 random(20);
  std::map<std::string, fs::file_time_type> finished;
  for (int kill_number = 0; kill_number < 20; ++kill_number) {
    const pid_t driver = Start(plan, 1 + kill_number % 2);
    // Any moment, from before it has started to several runs later.
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 60'000));
    kill(driver, SIGKILL);
    const int end = Wait(driver);
    EXPECT_TRUE(end == -SIGKILL || end == 0) << end << ReadFile(log);
    const auto now = Shards();
    for (const auto& [name, when] : finished) {
      const auto found = now.find(name);
      ASSERT_NE(found, now.end()) << name << " was finished and is gone";
      EXPECT_EQ(found->second, when) << name << " was finished and run again";
    }
    for (const auto& [name, when] : now) EXPECT_NO_THROW(shards::ReadShardInfo(folder / name));
    finished = now;
  }
  EXPECT_EQ(Run(plan), 0) << ReadFile(log);
  ExpectComplete(plan);
  for (const std::string& name : FilesIn(folder))
    EXPECT_TRUE(name == "plan.yaml" || name.ends_with(".h5")) << name << " is left over";
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
  for (const std::string& name : FilesIn(folder))
    EXPECT_TRUE(name == "plan.yaml" || name.ends_with(".h5")) << name;
}

TEST_F(DriverTest, OneJobAndTwoGiveTheSame) {
  const plan::Plan plan = MakePlan({.repeats = 2});
  EXPECT_EQ(Run(plan, 1), 0) << ReadFile(log);
  ExpectComplete(plan);
  const auto one = FilesIn(folder);
  fs::remove_all(folder);
  EXPECT_EQ(Run(plan, 2), 0) << ReadFile(log);
  ExpectComplete(plan);
  EXPECT_EQ(FilesIn(folder), one);
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
    WaitForShards(2, driver);
    kill(driver, signal_number);
    EXPECT_EQ(Wait(driver), 128 + signal_number) << ReadFile(log);
    EXPECT_EQ(Shards().size(), 2u);
    EXPECT_NE(ReadFile(log).find("4 runs: 2 done, 2 not run"), std::string::npos) << ReadFile(log);
  }
}

TEST_F(DriverTest, AFullDiskKeepsWhatIsFinished) {
  PlanShape shape;
  shape.quantities = {1, 2, 3};
  shape.detectors = {"dbvt"};
  plan::Plan plan = MakePlan(shape);
  // The last run records more than the file limit permits; its memory use is below it.
  ASSERT_EQ(Run(plan), 0) << ReadFile(log);
  std::uintmax_t largest = 0;
  for (const auto& entry : fs::directory_iterator(folder))
    largest = std::max(largest, entry.file_size());
  const auto whole = Shards();
  fs::remove(folder / whole.begin()->first);
  fs::remove(folder / std::next(whole.begin())->first);

  const std::uintmax_t shard = fs::file_size(folder / std::prev(whole.end())->first);
  EXPECT_EQ(Run(plan, 1, std::to_string(shard - 1)), 2);
  const std::string text = ReadFile(log);
  EXPECT_NE(text.find("1 of 3 runs are safe in " + folder.string()), std::string::npos) << text;
  EXPECT_EQ(Shards().size(), 1u);
  for (const std::string& name : FilesIn(folder))
    EXPECT_TRUE(name == "plan.yaml" || name.ends_with(".h5")) << name << " is left over";

  EXPECT_EQ(Run(plan), 0) << ReadFile(log);
  ExpectComplete(plan);
}

TEST_F(DriverTest, BadRunsAreTheThirdExitStatus) {
  const plan::Plan plan = MakeBehaviourPlan({kFinishes, kFails, kSegfaults, kAborts});
  EXPECT_EQ(Run(plan, 2), 3);
  const std::string text = ReadFile(log);
  EXPECT_NE(text.find("4 runs: 1 done, 1 failed, 2 crashed"), std::string::npos) << text;
  EXPECT_NE(text.find("the cube is 140 % full"), std::string::npos) << text;
  const store::ResultFile file(folder / (plan.runs[2].id + ".h5"));
  EXPECT_EQ(file.ReadStatus({{0}, 0}), store::Status::kCrashed);
  EXPECT_EQ(file.ReadCycleCount({{0}, 0}), 3u);
  EXPECT_EQ(file.ReadText("message", {{0}, 0}),
            "the worker was ended by signal 11 (SIGSEGV, Segmentation fault)");
}

}  // namespace
}  // namespace cdb::tests
