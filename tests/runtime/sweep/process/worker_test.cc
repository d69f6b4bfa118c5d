#include "runtime/sweep/process/worker.h"
#include "runtime/protocol/machine/machine.h"
#include "runtime/sweep/process/launcher.h"
#include "runtime/sweep/process/process.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/personality.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>

#include "tests/runtime/sweep/schedule/plans.h"
#include "tests/support/folders.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

process::WorkerPrograms TestWorker() {
  const fs::path program = BuildFolder() / "schedule_test_worker";
  return {program, program};
}

/// Long enough for the slowest machine; a wait ends as soon as the worker does.
constexpr double kForever = 300;

process::Ending RunOne(const plan::Plan& plan, const process::StopFlag* stop = nullptr) {
  process::ProcessLauncher launcher(TestWorker(), 1, stop);
  launcher.Start(0, plan.runs.at(0), "");
  std::optional<process::Ending> ending = launcher.Wait(kForever);
  if (!ending) throw std::runtime_error("no end");
  return std::move(*ending);
}

template <typename T>
std::vector<T> Values(const process::Ending& ending, std::string_view name) {
  for (const auto& [series, bytes] : ending.result.series) {
    if (series->name != name) continue;
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  return {};
}

bool Has(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

TEST(WorkerTest, ARunThatFinishes) {
  const auto plan = MakeBehaviourPlan({kFinishes});
  const double before = static_cast<double>(time(nullptr));
  const process::Ending ending = RunOne(plan);
  const results::RunResult& result = ending.result;
  EXPECT_EQ(result.status, results::Status::kDone) << result.message;
  EXPECT_EQ(result.message, "");
  EXPECT_EQ(result.n_cycles, 10u);
  EXPECT_EQ(result.state_hash, "0123456789abcdef");
  EXPECT_EQ(result.omitted, "raycast_tree pools");
  EXPECT_EQ(result.decisions, "walls: kept: a test\npools: left out: a test\n");
  EXPECT_EQ(result.scalars.peak_rss_bytes, 4096);
  EXPECT_EQ(result.scalars.place_ns, 1);
  EXPECT_EQ(result.scalars.build_ns, 2);
  EXPECT_EQ(result.scalars.fill_fraction, 0.25);
  EXPECT_EQ(result.host, machine::HostName());
  EXPECT_GE(result.load, 0);
  EXPECT_GE(result.started_s, before - 1);
  EXPECT_GT(ending.wall_s, 0);
  EXPECT_TRUE(result.contacts.empty());

  const auto duration = Values<double>(ending, "duration");
  ASSERT_EQ(duration.size(), 60u);
  for (std::size_t phase = 0; phase < 6; ++phase)
    for (std::size_t cycle = 0; cycle < 10; ++cycle)
      EXPECT_EQ(duration[phase * 10 + cycle], 1000.0 * phase + cycle);
  const auto pairs = Values<std::int32_t>(ending, "pairs");
  ASSERT_EQ(pairs.size(), 10u);
  EXPECT_EQ(pairs[9], 27);
  EXPECT_TRUE(Values<double>(ending, "energy").empty()) << "not asked for";
}

TEST(WorkerTest, ARunThatFails) {
  const process::Ending ending = RunOne(MakeBehaviourPlan({kFails}));
  EXPECT_EQ(ending.result.status, results::Status::kFailed);
  EXPECT_EQ(ending.result.message, "the cube is 140 % full");
  EXPECT_EQ(ending.result.n_cycles, 2u);
  EXPECT_EQ(ending.result.state_hash, "");
}

TEST(WorkerTest, ASignalIsNamed) {
  const process::Ending ending = RunOne(MakeBehaviourPlan({kSegfaults}));
  EXPECT_EQ(ending.result.status, results::Status::kCrashed);
  EXPECT_EQ(ending.result.n_cycles, 3u);
  EXPECT_EQ(ending.result.message,
            "the worker was ended by signal 11 (SIGSEGV, Segmentation fault)");
  EXPECT_EQ(ending.result.omitted, "raycast_tree pools") << "settled before the first cycle";
  EXPECT_GT(ending.result.scalars.peak_rss_bytes, 1e5) << "of the dead as well";
}

TEST(WorkerTest, ACrashTellsTheLastWords) {
  const process::Ending ending = RunOne(MakeBehaviourPlan({kAborts}));
  EXPECT_EQ(ending.result.status, results::Status::kCrashed);
  EXPECT_EQ(ending.result.message,
            "the worker was ended by signal 6 (SIGABRT, Aborted): first line\n"
            "assertion `mass > 0` failed");
}

TEST(WorkerTest, WhatACrashedRunFinishedIsKept) {
  PlanShape shape;
  shape.record = {"timing", "counts", "poses"};
  const process::Ending ending = RunOne(MakeBehaviourPlan({kDiesHalfway}, shape));
  EXPECT_EQ(ending.result.status, results::Status::kCrashed);
  EXPECT_TRUE(Has(ending.result.message, "SIGKILL")) << ending.result.message;
  EXPECT_TRUE(Has(ending.result.message, "memory")) << ending.result.message;
  ASSERT_EQ(ending.result.n_cycles, 5u);
  const auto duration = Values<double>(ending, "duration");
  const auto pairs = Values<std::int32_t>(ending, "pairs");
  const auto poses = Values<double>(ending, "poses");
  ASSERT_EQ(poses.size(), 10u * 3 * 7);
  for (std::size_t cycle = 0; cycle < 10; ++cycle) {
    const bool is_finished = cycle < 5;  // the sixth cycle was written, but not finished
    for (std::size_t phase = 0; phase < 6; ++phase)
      EXPECT_EQ(!std::isnan(duration[phase * 10 + cycle]), is_finished) << phase << " " << cycle;
    EXPECT_EQ(pairs[cycle], is_finished ? static_cast<int>(cycle) * 3 : -1);
    for (std::size_t i = 0; i < 21; ++i)
      EXPECT_EQ(!std::isnan(poses[cycle * 21 + i]), is_finished) << cycle;
  }
}

TEST(WorkerTest, ATimeoutEndsIt) {
  PlanShape shape;
  shape.timeout_s = 0.25;
  for (const std::uint64_t seed : {kHangs, kHangsDeaf}) {
    const process::Ending ending = RunOne(MakeBehaviourPlan({seed}, shape));
    EXPECT_EQ(ending.result.status, results::Status::kTimedOut);
    EXPECT_GE(ending.wall_s, 0.25);
    // Zero on a machine so busy that it had not started.
    EXPECT_LE(ending.result.n_cycles, 4u);
    EXPECT_TRUE(Has(ending.result.message, "timeout of 0.25 s")) << ending.result.message;
    EXPECT_TRUE(Has(ending.result.message, "of 10")) << ending.result.message;
  }
}

TEST(WorkerTest, ATimeoutWhileAPileSettlesSaysSo) {
  PlanShape shape;
  shape.timeout_s = 2;
  const plan::Plan plan = MakeBehaviourPlan({kFinishes}, shape);
  protocol::Recording recording = protocol::Recording::Create(plan.runs[0].scene);
  protocol::Settling& settling = recording.header().settling;
  settling.phase = protocol::SettlingPhase::kSettling;
  settling.at_rest = 340;
  settling.objects = 1000;
  const auto message = [&] {
    return process::Collect(plan.runs[0], {SIGKILL, true, ""}, recording, -1).message;
  };
  EXPECT_EQ(message(),
            "ended at its timeout of 2 s after 0 of 10 cycles, while its pile settled (340 of 1000 "
            "objects at rest); use a longer timeout: a pile settles once for all its runs");
  settling.phase = protocol::SettlingPhase::kWaiting;
  EXPECT_TRUE(Has(message(), "(another run settles the same pile)")) << message();
  settling.phase = protocol::SettlingPhase::kNone;
  EXPECT_EQ(message(), "ended at its timeout of 2 s after 0 of 10 cycles");
}

TEST(WorkerTest, AMemoryLimitEndsItsRunAlone) {
  if (kAddressSanitizer) GTEST_SKIP() << "shadow memory exceeds any limit";
  PlanShape shape;
  shape.memory_bytes = 3e9;
  rlimit before = {}, after = {};
  getrlimit(RLIMIT_DATA, &before);
  EXPECT_EQ(RunOne(MakeBehaviourPlan({kTakesMemory})).result.status, results::Status::kDone);
  const process::Ending over = RunOne(MakeBehaviourPlan({kTakesMemory}, shape));
  EXPECT_EQ(over.result.status, results::Status::kFailed);
  EXPECT_EQ(over.result.message,
            "ended at its memory limit of 3 GB after 3 of 10 cycles; raise `memory`, or use fewer "
            "objects");
  const process::Ending crashed = RunOne(MakeBehaviourPlan({kNeedsMemory}, shape));
  EXPECT_EQ(crashed.result.status, results::Status::kCrashed);
  EXPECT_TRUE(Has(crashed.result.message, "SIGSEGV")) << crashed.result.message;
  EXPECT_TRUE(crashed.result.message.ends_with("; its memory was limited to 3 GB"))
      << crashed.result.message;
  EXPECT_GT(crashed.result.scalars.peak_rss_bytes, 1e5);
  EXPECT_EQ(RunOne(MakeBehaviourPlan({kFinishes}, shape)).result.status, results::Status::kDone);
  getrlimit(RLIMIT_DATA, &after);
  EXPECT_EQ(before.rlim_cur, after.rlim_cur) << "the runner itself has no limit";
  EXPECT_EQ(before.rlim_max, after.rlim_max);
}

TEST(WorkerTest, AMemoryLimitHoldsForAWorkerThatIsStarted) {
  if (kAddressSanitizer) GTEST_SKIP() << "shadow memory exceeds any limit";
  TemporaryFolder folder;
  const fs::path program = folder.path() / "another_name";
  fs::create_symlink(TestWorker().single, program);
  PlanShape shape;
  shape.memory_bytes = 3e9;
  const plan::Plan plan = MakeBehaviourPlan({kTakesMemory}, shape);
  process::ProcessLauncher launcher({program, program}, 1, nullptr);
  launcher.Start(0, plan.runs[0], "");
  EXPECT_EQ(launcher.Wait(kForever).value().result.status, results::Status::kFailed);
}

TEST(WorkerTest, WaitingForATimeoutCostsNoProcessorTime) {
  PlanShape shape;
  shape.timeout_s = 0.5;
  const auto plan = MakeBehaviourPlan({kHangs}, shape);
  const std::clock_t before = std::clock();
  RunOne(plan);
  EXPECT_LT(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC, 0.25);
}

TEST(WorkerTest, ATimeoutThatIsNotReachedChangesNothing) {
  PlanShape shape;
  shape.timeout_s = 1e300;
  EXPECT_EQ(RunOne(MakeBehaviourPlan({kFinishes}, shape)).result.status, results::Status::kDone);
}

TEST(WorkerTest, AFloodOfErrorsIsReadAndDropped) {
  const process::Ending ending = RunOne(MakeBehaviourPlan({kFloodsErrors}));
  EXPECT_EQ(ending.result.status, results::Status::kDone);
  EXPECT_EQ(ending.result.message, "");
  const process::Ending dead = RunOne(MakeBehaviourPlan({kFloodsAndDies}));
  EXPECT_EQ(dead.result.status, results::Status::kCrashed);
  EXPECT_TRUE(dead.result.message.starts_with(
      "the worker ended with exit status 7: the same complaint, over and over\n"))
      << dead.result.message;
  EXPECT_TRUE(dead.result.message.ends_with("\nthe last straw")) << dead.result.message;
  EXPECT_LT(dead.result.message.size(), 2000u);
}

TEST(WorkerTest, AnEndWithoutAReportIsACrash) {
  for (const std::uint64_t seed : {kEndsWithoutReport, kClosesFiles}) {
    const process::Ending ending = RunOne(MakeBehaviourPlan({seed}));
    EXPECT_EQ(ending.result.status, results::Status::kCrashed);
    EXPECT_EQ(ending.result.message, "the worker ended without a report");
    EXPECT_EQ(ending.result.n_cycles, 0u);
  }
}

TEST(WorkerTest, AReportIsChecked) {
  const process::Ending ending = RunOne(MakeBehaviourPlan({kLiesAboutCycles}));
  EXPECT_EQ(ending.result.status, results::Status::kCrashed);
  EXPECT_EQ(ending.result.message, "the worker ended after 5 of 10 cycles");
}

TEST(WorkerTest, ASpoiledRecordingDoesNoHarm) {
  const process::Ending ending = RunOne(MakeBehaviourPlan({kSpoilsHeader}));
  EXPECT_EQ(ending.result.status, results::Status::kCrashed);
  EXPECT_LE(ending.result.n_cycles, 10u);
  EXPECT_TRUE(Has(ending.result.message, "SIGSEGV"));
  EXPECT_EQ(ending.result.omitted + ending.result.decisions, "");
}

TEST(WorkerTest, WhatNoRunCanHaveRecordedIsAFailureAndDropped) {
  PlanShape shape;
  shape.record = {"timing", "counts", "contacts"};
  const struct {
    Behaviour behaviour;
    std::string_view fault;
  } cases[] = {{kGoesBackInTime, "duration holds -5, which is no duration"},
               {kHasNoTime, "duration has no value in cycle 4"},
               {kHasNoPairs, "pairs has no value in cycle 4"},
               {kHasNoMemory, "run/peak_rss holds -1"},
               {kHasNoHash, "its state hash is none"},
               {kTouchesNobody, "contact_body holds -3, which is no body"}};
  for (const auto& [behaviour, fault] : cases) {
    const process::Ending ending = RunOne(MakeBehaviourPlan({behaviour}, shape));
    const results::RunResult& result = ending.result;
    EXPECT_EQ(result.status, results::Status::kFailed) << fault;
    EXPECT_TRUE(Has(result.message, fault)) << result.message;
    EXPECT_EQ(result.n_cycles, 0u) << fault;
    EXPECT_EQ(result.judgement.verdict, protocol::Verdict::kUnknown) << fault;
    EXPECT_EQ(result.state_hash, "") << fault;
    EXPECT_TRUE(result.contacts.empty()) << fault;
    for (const double value : Values<double>(ending, "duration")) EXPECT_TRUE(std::isnan(value));
    for (const std::int32_t value : Values<std::int32_t>(ending, "pairs")) EXPECT_EQ(value, -1);
  }
}

TEST(WorkerTest, LastWordsAreText) {
  const process::Ending ending = RunOne(MakeBehaviourPlan({kWritesBinary}));
  EXPECT_EQ(ending.result.message, "the worker ended with exit status 1: café ????[31m ?? end");
}

TEST(WorkerTest, ContactsComeInOrder) {
  PlanShape shape;
  shape.record = {"contacts"};
  const process::Ending ending = RunOne(MakeBehaviourPlan({kContacts}, shape));
  EXPECT_EQ(ending.result.status, results::Status::kDone);
  ASSERT_EQ(ending.result.contacts.size(), 45u);
  std::size_t at = 0;
  for (std::size_t cycle = 0; cycle < 10; ++cycle)
    for (std::size_t k = 0; k < cycle; ++k, ++at) {
      EXPECT_EQ(ending.result.contacts[at].body_a, static_cast<double>(cycle));
      EXPECT_EQ(ending.result.contacts[at].body_b, static_cast<double>(k));
    }
}

TEST(WorkerTest, CyclesWhoseContactsAreLostAreNotCounted) {
  PlanShape shape;
  shape.record = {"contacts", "counts"};
  const process::Ending ending = RunOne(MakeBehaviourPlan({kContactsLost}, shape));
  EXPECT_EQ(ending.result.status, results::Status::kCrashed);
  EXPECT_EQ(ending.result.n_cycles, 8u);
  EXPECT_EQ(ending.result.contacts.size(), 28u);
  const auto contacts = Values<std::int32_t>(ending, "contacts");
  EXPECT_EQ(contacts[7], 7);
  EXPECT_EQ(contacts[8], -1);
}

TEST(WorkerTest, AWorkerIsLeftOnlyWhatItNeeds) {
  // Descriptors that a shell or a test leaves open, and signals that it ignores, must not reach a
  // worker.
  const int stray = dup(STDERR_FILENO);
  signal(SIGPIPE, SIG_IGN);
  sigset_t blocked;
  sigset_t before;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGUSR1);
  sigprocmask(SIG_BLOCK, &blocked, &before);
  const process::Ending ending = RunOne(MakeBehaviourPlan({kTellsPlace}));
  sigprocmask(SIG_SETMASK, &before, nullptr);
  signal(SIGPIPE, SIG_DFL);
  close(stray);
  const auto told = Values<std::int32_t>(ending, "pairs");
  ASSERT_EQ(told.size(), 10u);
  EXPECT_EQ(told[2], 0) << "signals blocked or ignored";
  EXPECT_EQ(told[3], 5) << "descriptors 0 to 5, and the recording's is closed";
  EXPECT_EQ(told[4], 1) << "a process group of its own";
}

/// The environment that a worker reports, for runs by one launcher.
std::vector<std::vector<std::int32_t>> Places(const fs::path& program, std::size_t runs,
                                              const char* addresses = "shifted") {
  auto plan = MakeBehaviourPlan({kTellsPlace});
  plan.runs[0].scene.world.Set("addresses", schema::Word{addresses});
  process::ProcessLauncher launcher({program, program}, 1, nullptr);
  std::vector<std::vector<std::int32_t>> places;
  for (std::size_t i = 0; i < runs; ++i) {
    launcher.Start(0, plan.runs[0], "");
    places.push_back(Values<std::int32_t>(launcher.Wait(kForever).value(), "pairs"));
  }
  return places;
}

TEST(WorkerTest, WorkersAreForkedFromOneThatIsLoaded) {
  for (const auto& told : Places(TestWorker().single, 2)) {
    EXPECT_EQ(told.at(5), 1);
    EXPECT_EQ(told.at(2), 0) << "signals blocked or ignored";
    EXPECT_EQ(told.at(3), 5) << "descriptors 0 to 5, and the recording's is closed";
    EXPECT_EQ(told.at(4), 1) << "a process group of its own";
  }
}

TEST(WorkerTest, AWorkerThatCannotBeForkedIsStarted) {
  TemporaryFolder folder;
  const fs::path program = folder.path() / "another_name";
  fs::create_symlink(TestWorker().single, program);
  for (const auto& told : Places(program, 2)) {
    EXPECT_EQ(told.at(5), 0);
    EXPECT_EQ(told.at(3), 5) << "descriptors 0 to 5, and the recording's is closed";
  }
}

TEST(WorkerTest, ForkedWorkersHaveAddressesOfTheirOwn) {
  if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer has a heap of its own";
  if ((personality(0xffffffff) & ADDR_NO_RANDOMIZE) != 0) GTEST_SKIP() << "addresses are fixed";
  const auto places = Places(TestWorker().single, 8);
  for (const std::size_t what : {6, 7, 8}) {
    std::set<std::int32_t> addresses;
    for (const auto& told : places) addresses.insert(told.at(what));
    EXPECT_GT(addresses.size(), 4u) << what;
  }
}

TEST(WorkerTest, FixedAddressesAreTheSameInEachRun) {
  if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer has a heap of its own";
  const auto places = Places(TestWorker().single, 4, "fixed");
  for (const std::size_t what : {6, 7, 8}) {
    std::set<std::int32_t> addresses;
    for (const auto& told : places) addresses.insert(told.at(what));
    EXPECT_EQ(addresses.size(), 1u) << what;
  }
  EXPECT_EQ(personality(0xffffffff) & ADDR_NO_RANDOMIZE, 0) << "is the worker's alone";
}

TEST(WorkerTest, ShuffledAddressesAreOfAWorkerThatIsStarted) {
  if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer has a heap of its own";
  std::set<std::int32_t> mappings;
  for (const auto& told : Places(TestWorker().single, 8, "shuffled")) {
    EXPECT_EQ(told.at(5), 0) << "no server forked it";
    mappings.insert(told.at(8));
  }
  EXPECT_GT(mappings.size(), 4u);
}

/// The fork server after its worker has ended: the only child.
pid_t ServerAfterARun(process::ProcessLauncher& launcher, const plan::Run& run) {
  launcher.Start(0, run, "");
  launcher.Wait(kForever);
  std::ifstream children("/proc/self/task/" + std::to_string(gettid()) + "/children");
  pid_t server = -1;
  children >> server;
  return server;
}

TEST(WorkerTest, AServerThatWasKilledIsDoneWithout) {
  const auto plan = MakeBehaviourPlan({kTellsPlace});
  process::ProcessLauncher launcher(TestWorker(), 1, nullptr);
  const pid_t server = ServerAfterARun(launcher, plan.runs[0]);
  ASSERT_GT(server, 0);
  kill(server, SIGKILL);
  launcher.Start(0, plan.runs[0], "");
  const process::Ending ending = launcher.Wait(kForever).value();
  EXPECT_EQ(ending.result.status, results::Status::kDone) << ending.result.message;
  EXPECT_EQ(Values<std::int32_t>(ending, "pairs").at(5), 0);
}

TEST(WorkerTest, AServerThatDiesBeforeItAnswersStartsNoRunTwice) {
  const auto plan = MakeBehaviourPlan({kTellsPlace});
  process::ProcessLauncher launcher(TestWorker(), 1, nullptr);
  const pid_t server = ServerAfterARun(launcher, plan.runs[0]);
  ASSERT_GT(server, 0);
  kill(server, SIGSTOP);  // it has received the request, but does not answer
  // A child of this process that runs the program and is unknown to the launcher.
  process::SpawnPlan spawn;
  const pid_t stray = spawn.Start(TestWorker().single, {"wait"});
  std::thread killer([server] {
    usleep(50'000);
    kill(server, SIGKILL);
  });
  launcher.Start(0, plan.runs[0], "");
  killer.join();
  EXPECT_LT(waitpid(stray, nullptr, WNOHANG), 0) << "it was ended and reaped";
  const process::Ending ending = launcher.Wait(kForever).value();
  EXPECT_EQ(ending.result.status, results::Status::kDone) << ending.result.message;
  EXPECT_EQ(Values<std::int32_t>(ending, "pairs").at(5), 0);
}

TEST(WorkerTest, SlotsHaveProcessorsOfTheirOwn) {
  cpu_set_t allowed;
  sched_getaffinity(0, sizeof allowed, &allowed);
  const std::string claim = fmt::format("cdb-test-{}", getpid());
  const auto plan = MakeBehaviourPlan({kTellsPlace, kTellsPlace});
  const auto all = static_cast<std::size_t>(CPU_COUNT(&allowed));
  for (const std::size_t slots : {std::size_t{1}, std::size_t{2}, all + 1}) {
    process::ProcessLauncher launcher(TestWorker(), slots, nullptr, claim);
    std::set<std::int32_t> processors;
    const std::size_t runs = std::min<std::size_t>(slots, 2);
    for (std::size_t slot = 0; slot < runs; ++slot) launcher.Start(slot, plan.runs[slot], "");
    for (std::size_t i = 0; i < runs; ++i) {
      const process::Ending ending = launcher.Wait(kForever).value();
      const auto told = Values<std::int32_t>(ending, "pairs");
      EXPECT_EQ(told[0], all >= slots ? 1 : CPU_COUNT(&allowed));
      EXPECT_TRUE(CPU_ISSET(told[1], &allowed));
      processors.insert(told[1]);
    }
    EXPECT_TRUE(all < slots || processors.size() == runs);
  }
  cpu_set_t after;
  sched_getaffinity(0, sizeof after, &after);
  EXPECT_TRUE(CPU_EQUAL(&allowed, &after)) << "the runner itself is where it was";
}

TEST(WorkerTest, ADetectorWithThreadsMayRunAnywhere) {
  cpu_set_t allowed;
  sched_getaffinity(0, sizeof allowed, &allowed);
  plan::Plan plan = MakeBehaviourPlan({kTellsPlace, kTellsPlace});
  plan.runs[1].scene.world.Set("threads", std::uint64_t{2});
  plan.runs[1].id = plan::RunId(plan.runs[1].scene, 0);
  process::ProcessLauncher launcher(TestWorker(), 1, nullptr, fmt::format("cdb-test-{}", getpid()));
  for (const std::size_t run : {0, 1, 0}) {
    launcher.Start(0, plan.runs[run], "");
    const auto told = Values<std::int32_t>(launcher.Wait(kForever).value(), "pairs");
    EXPECT_EQ(told[0], run == 0 ? 1 : CPU_COUNT(&allowed));
  }
}

TEST(Recording, LiesBetweenPagesThatCannotBeTouched) {
  const plan::Plan plan = MakeBehaviourPlan({kFinishes});
  protocol::Recording recording = protocol::Recording::Create(plan.runs[0].scene);
  auto* begin = reinterpret_cast<volatile char*>(&recording.header());
  const std::size_t whole = (recording.header().bytes + 0xffff) & ~std::size_t{0xffff};
  const auto dies = [](volatile char* place) {
    const pid_t child = fork();
    if (child == 0) {
      *place = 1;
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status != 0;
  };
  EXPECT_FALSE(dies(begin));
  EXPECT_TRUE(dies(begin - 1));
  EXPECT_TRUE(dies(begin + whole));
}

TEST(WorkerTest, WaitsNoLongerThanAsked) {
  const auto plan = MakeBehaviourPlan({kHangs});
  process::ProcessLauncher launcher(TestWorker(), 1, nullptr);
  launcher.Start(0, plan.runs[0], "");
  EXPECT_FALSE(launcher.Wait(0).has_value());
  EXPECT_FALSE(launcher.Wait(0.02).has_value());
  launcher.StopAll();
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "no child is left";
  EXPECT_EQ(errno, ECHILD);
  // The slot is free again.
  const auto more = MakeBehaviourPlan({kFinishes});
  launcher.Start(0, more.runs[0], "");
  EXPECT_EQ(launcher.Wait(kForever).value().result.status, results::Status::kDone);
}

TEST(WorkerTest, AStopEndsTheWaiting) {
  process::StopFlag stop;
  const auto plan = MakeBehaviourPlan({kHangs});
  process::ProcessLauncher launcher(TestWorker(), 1, &stop);
  launcher.Start(0, plan.runs[0], "");
  stop.Request(SIGINT);
  EXPECT_FALSE(launcher.Wait(kForever).has_value());
}

TEST(WorkerTest, WhatHasEndedIsHandedOutBeforeAStop) {
  process::StopFlag stop;
  const auto plan = MakeBehaviourPlan({kEndsWithoutReport});
  process::ProcessLauncher launcher(TestWorker(), 1, &stop);
  launcher.Start(0, plan.runs[0], "");
  // The child has ended, but has not been waited for.
  siginfo_t info = {};
  ASSERT_EQ(waitid(P_ALL, 0, &info, WEXITED | WNOWAIT), 0);
  stop.Request(SIGINT);
  EXPECT_TRUE(launcher.Wait(kForever).has_value());
  EXPECT_FALSE(launcher.Wait(kForever).has_value());
}

TEST(WorkerTest, LeavesNoDescriptorBehind) {
  const auto count = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  RunOne(MakeBehaviourPlan({kFinishes}));
  const auto before = count();
  for (const std::uint64_t seed : {kFinishes, kSegfaults, kClosesFiles})
    RunOne(MakeBehaviourPlan({seed}));
  EXPECT_EQ(count(), before);
}

TEST(WorkerTest, WhatCannotBeStartedIsNamed) {
  TemporaryFolder folder;
  const fs::path text = folder.path() / "cdb-worker-f32";
  WriteFile(text, "no program");
  fs::permissions(text, fs::perms::owner_all);
  const auto plan = MakeBehaviourPlan({kFinishes});
  for (const fs::path& program : {text, folder.path() / "gone"}) {
    process::ProcessLauncher launcher({program, program}, 1, nullptr);
    try {
      launcher.Start(0, plan.runs[0], "");
      ADD_FAILURE() << "started " << program;
    } catch (const process::ScheduleError& error) {
      EXPECT_TRUE(Has(error.what(), program.string())) << error.what();
    }
  }
}

TEST(WorkerTest, NoDescriptorLeftIsAnError) {
  if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer needs descriptors for its own checks";
  const auto plan = MakeBehaviourPlan({kFinishes});
  rlimit before = {};
  getrlimit(RLIMIT_NOFILE, &before);
  for (rlim_t most = 3; most < 19; ++most) {
    process::ProcessLauncher launcher(TestWorker(), 1, nullptr);
    rlimit few = before;
    few.rlim_cur = most;
    setrlimit(RLIMIT_NOFILE, &few);
    EXPECT_THROW(launcher.Start(0, plan.runs[0], ""), process::ScheduleError) << most;
    setrlimit(RLIMIT_NOFILE, &before);
  }
  EXPECT_EQ(RunOne(plan).result.status, results::Status::kDone);
}

TEST(WorkerTest, NoMemoryForTheRecordingIsAnError) {
  PlanShape shape;
  shape.cycles = 2147483647;
  shape.record = {"poses"};
  auto plan = MakeBehaviourPlan({kFinishes}, shape);
  plan.runs[0].scene.groups[0].settings.Set("quantity", std::uint64_t{2147483647});
  process::ProcessLauncher launcher(TestWorker(), 1, nullptr);
  EXPECT_THROW(launcher.Start(0, plan.runs[0], ""), process::ScheduleError);
}

}  // namespace
}  // namespace cdb::tests
