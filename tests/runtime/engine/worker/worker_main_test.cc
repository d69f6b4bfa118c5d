// The worker program, started as `cdb run` starts it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/protocol/fork_server.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/cache.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

plan::Run WorkerRun() {
  plan::Run run;
  run.scene = EngineScene(40, 280);
  SetWorld(run.scene, "cycles", std::uint64_t{100});
  SetWorld(run.scene, "acceleration", Vector3d(0, -98, 0));
  SetGroup(run.scene, "type", AnyType());
  SetGroup(run.scene, "linear_velocity", Normal(0.0, 60.0));
  run.id = plan::RunId(run.scene, run.rep);
  return run;
}

/// A copy of `fd` at or above 100, so that moving it to 3, 4 or 5 overwrites none of the others.
int OutOfTheWay(int fd) { return fcntl(fd, F_DUPFD, 100); }

/// Starts the worker with the text on descriptor 3 and returns its exit status.
int Start(const std::string& text, const protocol::Recording& recording,
          const std::vector<std::string>& environment = {},
          const std::vector<std::string>& arguments = {}) {
  const int run_fd = memfd_create("run", 0);
  const int contacts_fd = memfd_create("contacts", 0);
  EXPECT_EQ(write(run_fd, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  lseek(run_fd, 0, SEEK_SET);
  const pid_t child = fork();
  if (child == 0) {
    const int fds[] = {OutOfTheWay(run_fd), OutOfTheWay(recording.fd()), OutOfTheWay(contacts_fd)};
    dup2(fds[0], protocol::kRunFd);
    dup2(fds[1], protocol::kRecordingFd);
    dup2(fds[2], protocol::kContactsFd);
    for (const std::string& variable : environment) putenv(const_cast<char*>(variable.c_str()));
    std::vector<const char*> words = {CDB_WORKER};
    for (const std::string& argument : arguments) words.push_back(argument.c_str());
    words.push_back(nullptr);
    execv(CDB_WORKER, const_cast<char**>(words.data()));
    _exit(127);
  }
  close(run_fd);
  close(contacts_fd);
  int status = -1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(Worker, GivesWhatTheSameRunGivesHere) {
  const plan::Run run = WorkerRun();
  const std::string expected = RunHere(run.scene).hash();
  // The addresses differ each time: the system randomises them, and an environment of changing size
  // moves the stack.
  for (std::size_t i = 0; i < 5; ++i) {
    protocol::Recording recording = protocol::Recording::Create(run.scene);
    const std::vector<std::string> environment = {"PADDING=" + std::string(i * 1237, 'x')};
    ASSERT_EQ(Start(yaml::RunToYaml(run), recording, environment), 0);
    EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kDone)
        << recording.header().message.str();
    EXPECT_EQ(recording.header().state_hash.str(), expected);
    EXPECT_EQ(recording.header().cycles_done.load(), 100u);
    EXPECT_GT(recording.header().scalars.peak_rss_bytes, 1e6);
    EXPECT_GT(recording.Reals("duration").back(), 0);
  }
}

TEST(Worker, NeedsNoMoreMemoryIfItSettlesThePile) {
  const TemporaryCache cache;
  plan::Run run;
  run.scene = EngineScene(300, 40);
  SetWorld(run.scene, "cycles", std::uint64_t{20});
  SetWorld(run.scene, "record", schema::WordList{"timing", "memory"});
  SetGroup(run.scene, "size", 1.0);
  SetGroup(run.scene, "location", schema::Call{"pile", {schema::Word{"fit"}}});
  SeedStreams(run.scene);
  run.id = plan::RunId(run.scene, run.rep);
  double peaks[2], heaps[2];
  for (int i = 0; i < 2; ++i) {
    protocol::Recording recording = protocol::Recording::Create(run.scene);
    ASSERT_EQ(Start(yaml::RunToYaml(run), recording), 0);
    ASSERT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kDone)
        << recording.header().message.str();
    peaks[i] = recording.header().scalars.peak_rss_bytes;
    heaps[i] = recording.Reals("heap").back();
  }
  // Settled, and found in the cache. Which pages of the program are mapped depends on the machine's
  // load.
  EXPECT_NEAR(peaks[0] / peaks[1], 1, 0.06);
  EXPECT_NEAR(heaps[0], heaps[1], 0.005 * heaps[1]);  // both 0 with AddressSanitizer's allocator
}

/// Two objects whose boxes overlap but which do not touch, placed so by the seed.
plan::Scene Neighbours() {
  plan::Scene scene = EngineScene(2, 250);
  SetWorld(scene, "cycles", std::uint64_t{200});
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    SeedStreams(scene, seed);
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    const Vector3d apart = state.objects[0].pose.position - state.objects[1].pose.position;
    if (apart.cwiseAbs().maxCoeff() < 45 && apart.norm() > 55) return scene;
  }
  ADD_FAILURE() << "no seed places two objects so";
  return scene;
}

TEST(Worker, AsksToStartAgainWithAllWallsWhereItTrips) {
  // When they come to rest, the order in which dbvt removes pairs could matter.
  plan::Run run;
  run.scene = Neighbours();
  run.id = plan::RunId(run.scene, run.rep);
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  ASSERT_EQ(Start(yaml::RunToYaml(run), recording), 0);
  ASSERT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kAgain);
  const std::string why = recording.header().message.str();
  recording.Clear();
  ASSERT_EQ(Start(yaml::RunToYaml(run), recording, {},
                  {protocol::kKeepOption, protocol::kStartAgainKeeps, why}),
            0);
  ASSERT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kDone)
      << recording.header().message.str();
  const Recorded here = RunHere(run.scene);
  EXPECT_EQ(recording.header().state_hash.str(), here.hash());
  EXPECT_EQ(recording.header().decisions.str(), here.header().decisions.str());
  EXPECT_NE(recording.header().decisions.str().find("walls: kept: object 1 came to rest"),
            std::string::npos)
      << recording.header().decisions.str();
  EXPECT_EQ(recording.header().cycles_done.load(), 200u);
  // An explicit list is followed exactly.
  SetWorld(run.scene, "omit", schema::WordList{"walls"});
  run.id = plan::RunId(run.scene, run.rep);
  ASSERT_EQ(Start(yaml::RunToYaml(run), recording), 0);
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kFailed);
  EXPECT_NE(recording.header().message.str().find("omit walls: this scene needs them"),
            std::string::npos);
}

TEST(Worker, EndsAtOnceWhereItsRunnerIsGone) {
  const plan::Run run = WorkerRun();
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  const std::string other =
      std::string(protocol::kRunnerVariable) + '=' + std::to_string(getpid() + 1);
  EXPECT_EQ(Start(yaml::RunToYaml(run), recording, {other}), 0);
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kRunning);
}

TEST(Worker, ReportsASceneThatCannotBe) {
  plan::Run run = WorkerRun();
  SetGroup(run.scene, "size", 300.0);
  run.id = plan::RunId(run.scene, run.rep);
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  EXPECT_EQ(Start(yaml::RunToYaml(run), recording), 0);
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kFailed);
  EXPECT_NE(recording.header().message.str().find("does not fit"), std::string::npos);
}

TEST(Worker, RefusesARunOfTheOtherPrecision) {
  plan::Run run = WorkerRun();
  SetWorld(run.scene, "precision", Word(sizeof(btScalar) == 4 ? "double" : "single"));
  run.id = plan::RunId(run.scene, run.rep);
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  EXPECT_EQ(Start(yaml::RunToYaml(run), recording), 0);
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kFailed);
  EXPECT_NE(recording.header().message.str().find("precision"), std::string::npos);
}

TEST(Worker, SaysByItsStatusWhatItCannotReport) {
  const plan::Run run = WorkerRun();
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  EXPECT_EQ(Start("no: run", recording), 2);
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kRunning);
  plan::Run other = run;
  SetWorld(other.scene, "cycles", std::uint64_t{101});
  other.id = plan::RunId(other.scene, other.rep);
  EXPECT_EQ(Start(yaml::RunToYaml(other), recording), 2);
}

std::string Output(const std::string& command, int* status) {
  FILE* pipe = popen(command.c_str(), "r");
  std::string text(4096, '\0');
  text.resize(fread(text.data(), 1, text.size(), pipe));
  *status = WEXITSTATUS(pclose(pipe));
  return text;
}

TEST(Worker, StartedByHandSaysWhatToUse) {
  int status = 0;
  const std::string text =
      Output(std::string(CDB_WORKER) + " 3<&- 4<&- 5<&- 2>&1 </dev/null", &status);
  EXPECT_EQ(status, 2);
  EXPECT_NE(text.find("cdb run"), std::string::npos) << text;
}

TEST(Worker, Version) {
  int status = 1;
  const std::string text = Output(std::string(CDB_WORKER) + " --version", &status);
  EXPECT_EQ(status, 0);
  EXPECT_NE(text.find("Bullet 3.24"), std::string::npos) << text;
  EXPECT_NE(text.find(world::EnginePrecision()), std::string::npos) << text;
}

}  // namespace
}  // namespace cdb::tests
