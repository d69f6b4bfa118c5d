// A worker whose behaviour depends on the seed of its run: see Behaviour.
#include <dirent.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/protocol/fork_server.h"
#include "runtime/protocol/recording.h"
#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

void FloodErrors() {
  std::string lines;
  while (lines.size() < 1 << 20) lines += "the same complaint, over and over\n";
  for (int i = 0; i < 32; ++i) protocol::WriteAll(STDERR_FILENO, lines);
}

[[noreturn]] void DieOf(int signal_number) {
  signal(signal_number, SIG_DFL);  // a sanitizer has its own handler
  raise(signal_number);
  _exit(98);
}

[[noreturn]] void Hang(bool is_deaf) {
  if (is_deaf) {
    for (int i = 1; i < NSIG; ++i) signal(i, SIG_IGN);
    if (fork() == 0) prctl(PR_SET_PDEATHSIG, SIGKILL);
  }
  while (true) pause();
}

/// Allocates private memory without using a page.
bool TakeMemory() {
  constexpr std::size_t kPiece = std::size_t{1} << 30;
  for (int i = 0; i < 64; ++i)
    if (mmap(nullptr, kPiece, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE,
             -1, 0) == MAP_FAILED)
      return false;
  return true;
}

class Worker {
 public:
  Worker(const plan::Run& run, protocol::Recording& recording)
      : recording_(recording),
        cycles_(run.scene.world.Count("cycles")),
        quantity_(run.scene.ObjectCount()),
        with_contacts_(run.scene.world.Lists("record", "contacts")) {
    protocol::RecordingHeader& header = recording_.header();
    header.omitted = "raycast_tree pools";
    header.decisions = "walls: kept: a test\npools: left out: a test\n";
  }

  /// Writes predictable values: cycle i has the duration 1000 * phase + i, and so on.
  void Write(std::uint64_t cycle, bool with_contact_records = true) {
    const auto i = static_cast<std::int32_t>(cycle);
    if (const auto duration = recording_.Reals("duration"); !duration.empty())
      for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase)
        duration[phase * cycles_ + cycle] = 1000.0 * static_cast<double>(phase) + i;
    if (const auto pairs = recording_.Ints("pairs"); !pairs.empty())
      pairs[cycle] = i * static_cast<std::int32_t>(quantity_);
    if (const auto contacts = recording_.Ints("contacts"); !contacts.empty()) contacts[cycle] = i;
    if (const auto poses = recording_.Reals("poses"); !poses.empty())
      for (std::size_t k = 0; k < quantity_ * protocol::kPoseSize; ++k)
        poses[cycle * quantity_ * protocol::kPoseSize + k] = static_cast<double>(k) + i;
    if (!with_contacts_ || !with_contact_records) return;
    for (std::uint64_t k = 0; k < cycle; ++k) {
      protocol::ContactRecord record = {};
      record.body_a = static_cast<double>(cycle);
      record.body_b = static_cast<double>(k);
      record.distance = -1;
      if (write(protocol::kContactsFd, &record, sizeof record) != sizeof record) _exit(97);
    }
  }

  void Cycle(std::uint64_t cycle, bool with_contact_records = true) {
    Write(cycle, with_contact_records);
    recording_.header().cycles_done.store(cycle + 1, std::memory_order_release);
  }

  void Cycles(std::uint64_t count) {
    for (std::uint64_t cycle = 0; cycle < count; ++cycle) Cycle(cycle);
  }

  int Report(protocol::WorkerOutcome outcome, const char* message = "") {
    protocol::RecordingHeader& header = recording_.header();
    header.message = message;
    header.state_hash = "0123456789abcdef";
    header.scalars.peak_rss_bytes = 4096;
    header.scalars.place_ns = 1;
    header.scalars.build_ns = 2;
    header.scalars.fill_fraction = 0.25;
    header.outcome.store(outcome, std::memory_order_release);
    return 0;
  }

  std::uint64_t cycles() const { return cycles_; }
  protocol::Recording& recording() { return recording_; }

 private:
  protocol::Recording& recording_;
  std::uint64_t cycles_, quantity_;
  bool with_contacts_;
};

bool g_is_forked = false;

/// Reports the number of processors, the first of them, blocked or ignored signals, open
/// descriptors, whether it leads its group, and whether a server forked it; and, as far as it fits,
/// the addresses of its stack, its heap and a new mapping.
void TellPlace(std::span<std::int32_t> told) {
  cpu_set_t cpus;
  sched_getaffinity(0, sizeof cpus, &cpus);
  told[0] = CPU_COUNT(&cpus);
  told[1] = 0;
  while (!CPU_ISSET(told[1], &cpus)) ++told[1];
  told[2] = 0;
  sigset_t blocked;
  sigprocmask(SIG_BLOCK, nullptr, &blocked);
  for (int i = 1; i < SIGRTMIN; ++i) {
    if (i == SIGKILL || i == SIGSTOP) continue;
    struct sigaction action = {};
    sigaction(i, nullptr, &action);
    told[2] += sigismember(&blocked, i) == 1 || action.sa_handler == SIG_IGN;
  }
  told[3] = 0;
  DIR* const folder = opendir("/proc/self/fd");
  while (const dirent* entry = readdir(folder)) told[3] += entry->d_name[0] != '.';
  --told[3];  // the folder itself
  closedir(folder);
  told[4] = getpgrp() == getpid();
  told[5] = g_is_forked;
  const auto place = [](const void* address) {
    return static_cast<std::int32_t>(reinterpret_cast<std::uintptr_t>(address) >> 4 & 0x7fffffff);
  };
  told[6] = place(&cpus);
  told[7] = place(sbrk(0));
  told[8] = place(mmap(nullptr, 1 << 20, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
}

int Behave(const plan::Run& run, protocol::Recording& recording) {
  Worker worker(run, recording);
  const std::uint64_t cycles = worker.cycles();
  switch (run.scene.world.Count("seed")) {
    case kFails:
      worker.Cycles(2);
      return worker.Report(protocol::WorkerOutcome::kFailed, "the cube is 140 % full");
    case kSegfaults:
      worker.Cycles(3);
      DieOf(SIGSEGV);
    case kAborts:
      protocol::WriteAll(STDERR_FILENO, "first line\nassertion `mass > 0` failed\n");
      DieOf(SIGABRT);
    case kHangs:
    case kHangsDeaf:
      worker.Cycles(4);
      Hang(run.scene.world.Count("seed") == kHangsDeaf);
    case kDiesHalfway:
      worker.Cycles(cycles / 2);
      worker.Write(cycles / 2);
      DieOf(SIGKILL);
    case kFloodsErrors:
      FloodErrors();
      break;
    case kFloodsAndDies:
      FloodErrors();
      protocol::WriteAll(STDERR_FILENO, "the last straw\n");
      _exit(7);
    case kClosesFiles:
      for (int fd = 0; fd < 64; ++fd) close(fd);
      _exit(0);
    case kEndsWithoutReport:
      _exit(0);
    case kLiesAboutCycles:
      worker.Cycles(cycles / 2);
      return worker.Report(protocol::WorkerOutcome::kDone);
    case kSpoilsHeader:
      worker.Cycles(1);
      std::memset(static_cast<void*>(&recording.header()), 0xff, sizeof(protocol::RecordingHeader));
      DieOf(SIGSEGV);
    case kWritesBinary:
      protocol::WriteAll(STDERR_FILENO, "caf\xc3\xa9 \xff\xfe\x01\x1b[31m \xc0\xaf end\n\n");
      _exit(1);
    case kTellsPlace:
      worker.Cycles(cycles);
      TellPlace(recording.Ints("pairs"));
      return worker.Report(protocol::WorkerOutcome::kDone);
    case kContactsLost:
      for (std::uint64_t i = 0; i < cycles; ++i) worker.Cycle(i, i + 2 < cycles);
      DieOf(SIGSEGV);
    case kTakesMemory:
    case kNeedsMemory:
      worker.Cycles(3);
      if (TakeMemory()) break;
      if (run.scene.world.Count("seed") == kNeedsMemory) DieOf(SIGSEGV);
      recording.header().is_out_of_memory.store(1);
      return worker.Report(protocol::WorkerOutcome::kFailed, "out of memory");
    default:
      break;
  }
  worker.Cycles(cycles);
  worker.Report(protocol::WorkerOutcome::kDone);
  const std::uint64_t step = protocol::IndexOf(protocol::Phase::kStep) * cycles;
  switch (run.scene.world.Count("seed")) {
    case kGoesBackInTime:
      recording.Reals("duration")[4] = -5;
      break;
    case kHasNoTime:
      recording.Reals("duration")[step + 4] = schema::RunScalars::kNone;
      break;
    case kHasNoPairs:
      recording.Ints("pairs")[4] = -1;
      break;
    case kHasNoMemory:
      recording.header().scalars.peak_rss_bytes = -1;
      break;
    case kHasNoHash:
      recording.header().state_hash = "<no hash>";
      break;
    case kTouchesNobody: {
      const protocol::ContactRecord record = {-3, schema::RunScalars::kNone, {}, {}, 0};
      if (pwrite(protocol::kContactsFd, &record, sizeof record, 0) != sizeof record) _exit(97);
      break;
    }
    default:
      break;
  }
  return 0;
}

int Execute(const std::vector<std::string>& /*arguments*/) {
  protocol::BindToRunner();
  const plan::Run run = yaml::RunFromYaml(protocol::ReadAll(protocol::kRunFd), "the run");
  auto recording = protocol::Recording::Open(protocol::kRecordingFd, run.scene);
  return Behave(run, recording);
}

}  // namespace
}  // namespace cdb::tests

using namespace cdb;
using namespace cdb::tests;

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  // Under another name, it cannot serve forks.
  g_is_forked = std::string_view(argv[0]).ends_with("schedule_test_worker") &&
                arguments == std::vector<std::string>{protocol::kServeOption};
  if (g_is_forked) protocol::ServeForks(Execute);
  if (arguments == std::vector<std::string>{"wait"}) Hang(false);
  return arguments.empty() ? Execute(arguments) : 2;
}
