#include "runtime/sweep/process/worker.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/personality.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "compiler/analysis/trace.h"
#include "compiler/plan/clock.h"
#include "dsl/text/check.h"
#include "dsl/text/utf8.h"
#include "library/layouts/pose_table.h"
#include "library/scene_error.h"
#include "runtime/protocol/machine/machine.h"
#include "runtime/protocol/recording.h"
#include "runtime/results/trace_file.h"
#include "runtime/sweep/process/launcher.h"
#include "runtime/sweep/process/process.h"
#include "runtime/sweep/process/program.h"

namespace cdb::process {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;  // CLOCK_MONOTONIC

/// While it lives, new processes start on `cpu`. A child inherits the setting, so it never runs
/// elsewhere.
class OnCpu {
 public:
  explicit OnCpu(int cpu) {
    is_set_ = sched_getaffinity(0, sizeof before_, &before_) == 0;
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(cpu, &only);
    if (is_set_) is_set_ = sched_setaffinity(0, sizeof only, &only) == 0;
  }
  ~OnCpu() {
    if (is_set_) sched_setaffinity(0, sizeof before_, &before_);
  }
  OnCpu(const OnCpu&) = delete;
  OnCpu& operator=(const OnCpu&) = delete;

 private:
  cpu_set_t before_ = {};
  bool is_set_ = false;
};

/// While it lives, new processes have the same addresses in each run. A child inherits the setting.
/// Throws ScheduleError where the system forbids it.
class FixedAddresses {
 public:
  FixedAddresses() : before_(personality(kRead)) {
    if (before_ == -1 || personality(static_cast<unsigned long>(before_) | ADDR_NO_RANDOMIZE) == -1)
      throw ScheduleError(
          fmt::format("`addresses fixed` is forbidden here ({}), as in many containers; use "
                      "`addresses shifted` or `shuffled`",
                      std::strerror(errno)));
  }
  ~FixedAddresses() { personality(static_cast<unsigned long>(before_)); }
  FixedAddresses(const FixedAddresses&) = delete;
  FixedAddresses& operator=(const FixedAddresses&) = delete;

 private:
  static constexpr unsigned long kRead = 0xffffffff;
  const int before_;
};

/// A variable whose length differs from process to process, and so moves the stack.
std::string ShuffledVariable() {
  constexpr std::size_t kMost = 4096;
  std::random_device random;
  return fmt::format("{}={}", protocol::kShuffledVariable, std::string(random() % kMost, '.'));
}

constexpr const char* kSingleWorker = "cdb-worker-f32";

fs::path OwnFolder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) FailToStart("cannot find the path of this program (/proc/self/exe)", error.value());
  return self.parent_path();
}

fs::path FindWorker(const fs::path& folder, const char* name) {
  const fs::path places[] = {folder / name, (folder / "../libexec/cdb" / name).lexically_normal()};
  for (const fs::path& place : places) {
    std::error_code error;
    if (fs::is_regular_file(place, error) && access(place.c_str(), X_OK) == 0) return place;
  }
  throw ScheduleError(
      fmt::format("cannot find the worker program {0}: neither {1} nor {2} exists. Build or "
                  "install it beside cdb (target {0})",
                  name, places[0].string(), places[1].string()));
}

/// Throws ScheduleError.
fs::path FindValgrind() {
  if (const auto program = FindProgram("valgrind")) return *program;
  throw ScheduleError(
      "`clock instructions` needs the program valgrind, which is in no folder of PATH; install the "
      "package valgrind, or use `clock time`");
}

/// Options for a program whose clock is the count of its instructions (engine/world/clock.h).
std::vector<std::string> CountingOptions() {
  return {"--tool=callgrind", "--callgrind-out-file=/dev/null", "--vgdb=no",
          fmt::format("--log-fd={}", protocol::kCountLogFd)};
}

double SecondsSinceEpoch() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// The poses that the worker cannot read itself; none if there are none.
std::optional<Descriptor> PosesFile(const plan::Scene& scene) {
  if (analysis::TraceOf(scene)) return std::nullopt;  // a run on a trace places nothing
  try {
    const std::string packed = layouts::PackPoses(scene);
    if (packed.empty()) return std::nullopt;
    return SealedFile("cdb-poses", packed);
  } catch (const library::SceneError& error) {
    throw ScheduleError(error.what());
  }
}

#ifndef __has_feature
#define __has_feature(name) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || __has_feature(address_sanitizer)
constexpr bool kAddressSanitizer = true;
#else
constexpr bool kAddressSanitizer = false;
#endif

/// Bytes; 0: no limit.
std::uint64_t MemoryLimitOf(const plan::Scene& scene) {
  if (!scene.world.WordOr("memory").empty()) return 0;
  if (plan::CountsInstructions(scene))
    throw ScheduleError(
        "`memory` cannot limit runs with `clock instructions`, as Valgrind needs memory, too; "
        "remove "
        "one of them");
  if (kAddressSanitizer)
    throw ScheduleError(
        "`memory` cannot limit runs of a build with AddressSanitizer, whose shadow memory exceeds "
        "any limit; remove it, or use another build");
  constexpr double kMost = 9e18;
  return static_cast<std::uint64_t>(std::clamp(scene.world.Real("memory"), 1.0, kMost));
}

std::optional<Clock::time_point> Deadline(const plan::Scene& scene, Clock::time_point start) {
  if (!scene.world.WordOr("timeout").empty()) return std::nullopt;
  const double seconds = scene.world.Real("timeout");
  constexpr double kLongest = 1e9;  // a larger value could overflow the clock's counter
  return start + std::chrono::duration_cast<Clock::duration>(
                     std::chrono::duration<double>(std::min(seconds, kLongest)));
}

machine::NoiseJudgement NoiseOf(const plan::Run& run, const results::RunResult& result,
                                const protocol::Recording& recording) {
  if (result.status != results::Status::kDone || plan::CountsInstructions(run.scene)) return {};
  const auto duration = recording.Reals("duration");
  const std::size_t cycles = result.n_cycles;
  const auto steps =
      duration.empty()
          ? duration
          : duration.subspan(protocol::IndexOf(protocol::Phase::kStep) * cycles, cycles);
  return machine::JudgeNoise(result.scalars, {result.load, machine::OnlineProcessorCount()},
                             run.scene.world.Count("threads"), steps);
}

}  // namespace

// ---- finding ------------------------------------------------------------------------------------

WorkerPrograms FindWorkers(const plan::Plan& plan) { return FindWorkers(plan, OwnFolder()); }

WorkerPrograms FindWorkers(const plan::Plan& plan, const fs::path& folder) {
  WorkerPrograms programs;
  const auto uses = [&plan](std::string_view precision) {
    const auto is_of_it = [precision](const plan::Run& run) {
      return run.scene.world.WordOr("precision") == precision;
    };
    return std::ranges::any_of(plan.Bounds(), is_of_it) ||
           std::ranges::any_of(plan.references, is_of_it);
  };
  if (uses("single")) programs.single = FindWorker(folder, kSingleWorker);
  if (uses("double")) programs.double_ = FindWorker(folder, "cdb-worker-f64");
  if (plan::CountsInstructions(plan)) programs.valgrind = FindValgrind();
  if (std::ranges::any_of(plan.Bounds(), [](const plan::Run& run) {
        return run.scene.world.WordOr("addresses") == "fixed";
      }))
    FixedAddresses();  // before any run
  return programs;
}

// ---- standard error -----------------------------------------------------------------------------

void TextTail::Append(std::string_view text) {
  text_.append(text.substr(text.size() - std::min(text.size(), kMaxBytes)));
  if (text_.size() > kMaxBytes) text_.erase(0, text_.size() - kMaxBytes);
}

std::string TextTail::LastLines() const {
  constexpr std::size_t kMaxLines = 5;
  constexpr std::size_t kMaxLength = 1000;
  std::string_view rest = text_;
  while (rest.ends_with('\n')) rest.remove_suffix(1);
  std::size_t from = rest.size();
  for (std::size_t lines = 0; lines < kMaxLines && from > 0; ++lines) {
    const std::size_t end_of_line = rest.rfind('\n', from - 1);
    from = end_of_line == std::string_view::npos ? 0 : end_of_line;
  }
  rest.remove_prefix(from > 0 ? from + 1 : 0);
  const bool is_cut = rest.size() > kMaxLength;
  if (is_cut) rest.remove_prefix(rest.size() - kMaxLength);
  std::string text = is_cut ? "..." : "";
  // The first bytes may be the rest of a character that was cut.
  while (is_cut && !rest.empty() && (static_cast<unsigned char>(rest[0]) & 0xc0) == 0x80)
    rest.remove_prefix(1);
  return text + text::Printable(rest);
}

// ---- processes ----------------------------------------------------------------------------------

struct ProcessLauncher::Worker {
  const plan::Run* run = nullptr;
  std::size_t slot = 0;
  std::string kept;             // components, as requested by the scheduler
  bool is_second_time = false;  // started again at its own request
  std::unique_ptr<protocol::Recording> recording;
  Descriptor contacts, narrow_input;
  Descriptor errors;  // read end of its standard error; closed at end of file
  TextTail tail;
  double started_s = 0;
  double load = 0;
  Clock::time_point start;
  std::optional<Clock::time_point> deadline;
  bool is_timed_out = false;
  pid_t pid = -1;
  Descriptor pidfd;  // readable when the process has ended

  ~Worker() {
    if (pid < 0) return;
    Kill();
    while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  /// Safe until the process is reaped: its id cannot have been reused. A newly forked worker may
  /// not lead its process group yet.
  void Kill() const {
    kill(-pid, SIGKILL);
    kill(pid, SIGKILL);
  }
};

ProcessLauncher::ProcessLauncher(WorkerPrograms programs, std::size_t slots, const StopFlag* stop,
                                 std::string_view claim)
    : programs_(std::move(programs)),
      stop_(stop),
      traces_(slots),
      processors_(slots, claim),
      workers_(slots) {}

ProcessLauncher::~ProcessLauncher() = default;

Pulse ProcessLauncher::PulseOf(std::size_t slot) const {
  CDB_CHECK(slot < workers_.size() && workers_[slot]);
  const protocol::RecordingHeader& header = workers_[slot]->recording->header();
  return {header.cycles_done.load(std::memory_order_relaxed),
          protocol::PluginCallText(header.plugin_call.load(std::memory_order_relaxed),
                                   workers_[slot]->run->scene),
          protocol::SettlingText(header.settling)};
}

void ProcessLauncher::StopAll() {
  for (const auto& worker : workers_)
    if (worker) worker->Kill();  // kill all at once, then wait for each
  for (auto& worker : workers_) worker.reset();
  servers_.clear();
}

std::vector<pid_t> ProcessLauncher::Processes() const {
  std::vector<pid_t> all;
  for (const auto& worker : workers_)
    if (worker) all.push_back(worker->pid);
  for (const auto& [key, server] : servers_)
    if (server) all.push_back(server->pid());
  return all;
}

pid_t ProcessLauncher::StartDirectly(const fs::path& program, SpawnPlan& spawn,
                                     protocol::ForkRequest how) {
  std::optional<OnCpu> pinned;
  if (how.cpu >= 0) pinned.emplace(how.cpu);
  spawn.SetVariable(fmt::format("{}={}", protocol::kRunnerVariable, getpid()));
  if (how.memory > 0)
    spawn.SetVariable(fmt::format("{}={}", protocol::kMemoryVariable, how.memory));
  return spawn.Start(program, std::move(how.arguments));
}

pid_t ProcessLauncher::StartProcess(const fs::path& program, bool has_fixed_addresses,
                                    SpawnPlan& spawn, protocol::ForkRequest how) {
  const auto [server, is_new] = servers_.try_emplace({program, has_fixed_addresses});
  try {
    if (is_new) server->second = std::make_unique<ForkServer>(program);
  } catch (const ScheduleError&) {
    // Starting the worker directly reports the reason.
  }
  if (server->second != nullptr) {
    how.descriptors = spawn.Given();
    const protocol::ForkAnswer answer = server->second->Start(how);
    if (answer.worker > 0) return answer.worker;
    server->second.reset();
    if (answer.is_uncertain) {
      EndOrphans(program, Processes());
      return -1;
    }
  }
  return StartDirectly(program, spawn, std::move(how));
}

pid_t ProcessLauncher::StartCounted(const fs::path& program, SpawnPlan& spawn,
                                    protocol::ForkRequest how) const {
  const Descriptor log = MemoryFile("cdb-counts");
  spawn.Give(log.get(), protocol::kCountLogFd);
  spawn.Give(log.get(), protocol::kCountsFd);
  std::vector<std::string> arguments = CountingOptions();
  arguments.push_back(program.string());
  how.arguments.insert(how.arguments.begin(), arguments.begin(), arguments.end());
  return StartDirectly(programs_.valgrind, spawn, std::move(how));
}

void ProcessLauncher::Start(std::size_t slot, const plan::Run& run, const std::string& kept) {
  CDB_CHECK(slot < workers_.size() && !workers_[slot]);
  auto worker = std::make_unique<Worker>();
  worker->run = &run;
  worker->slot = slot;
  try {
    worker->recording =
        std::make_unique<protocol::Recording>(protocol::Recording::Create(run.scene));
  } catch (const std::runtime_error& error) {
    throw ScheduleError(fmt::format("{} ({})", error.what(), run.id));
  }
  worker->kept = kept;
  worker->load = machine::LoadAverage();
  worker->started_s = SecondsSinceEpoch();
  worker->start = Clock::now();
  worker->deadline = Deadline(run.scene, worker->start);
  std::vector<std::string> arguments;
  if (!kept.empty())
    arguments = {protocol::kKeepOption, kept, "a run that it is compared with keeps it"};
  Launch(*worker, arguments);
  workers_[slot] = std::move(worker);
}

void ProcessLauncher::Launch(Worker& worker, const std::vector<std::string>& arguments) {
  while (!TryToLaunch(worker, arguments)) worker.recording->Clear();
}

bool ProcessLauncher::TryToLaunch(Worker& worker, std::vector<std::string> arguments) {
  const plan::Scene& scene = worker.run->scene;
  worker.contacts = MemoryFile("cdb-contacts");
  const Descriptor text = SealedFile("cdb-run", text_.YamlOf(*worker.run));
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) FailToStart("no descriptor to start a run", errno);
  worker.errors = Descriptor(ends[0]);
  const Descriptor their_errors(ends[1]);
  fcntl(ends[0], F_SETFL, O_NONBLOCK);  // only our end; the worker may block until we have read

  SpawnPlan spawn;
  spawn.Give(their_errors.get(), STDERR_FILENO);
  spawn.Give(text.get(), protocol::kRunFd);
  spawn.Give(worker.recording->fd(), protocol::kRecordingFd);
  spawn.Give(worker.contacts.get(), protocol::kContactsFd);
  if (records_narrow_input_) {
    worker.narrow_input = MemoryFile("cdb-narrow-input");
    spawn.Give(worker.narrow_input.get(), protocol::kNarrowInputFd);
    arguments.insert(arguments.begin(), protocol::kNarrowInputOption);
  }
  const auto poses = PosesFile(scene);
  if (poses) spawn.Give(poses->get(), protocol::kPosesFd);
  if (const auto trace = analysis::TraceOf(scene)) {
    try {
      spawn.Give(traces_.Get(*trace), protocol::kTraceFd);
    } catch (const std::system_error& error) {
      throw ScheduleError(error.what());
    } catch (const files::StoreError& error) {
      throw ScheduleError(error.what());
    }
  }
  const bool is_single = scene.world.WordOr("precision") == "single";
  const int cpu = scene.world.Count("threads") > 1 ? -1 : processors_.Of(worker.slot);
  const fs::path& program = is_single ? programs_.single : programs_.double_;
  protocol::ForkRequest how = {{}, std::move(arguments), cpu, MemoryLimitOf(scene)};
  const std::string_view addresses = scene.world.WordOr("addresses");
  const bool is_fixed = addresses == "fixed", is_shuffled = addresses == "shuffled";
  std::optional<FixedAddresses> fixed;
  if (is_fixed) fixed.emplace();
  if (is_shuffled) spawn.SetVariable(ShuffledVariable());
  worker.pid = plan::CountsInstructions(scene) ? StartCounted(program, spawn, std::move(how))
               : is_shuffled                   ? StartDirectly(program, spawn, std::move(how))
                             : StartProcess(program, is_fixed, spawn, std::move(how));
  if (worker.pid < 0) return false;
  worker.pidfd = WatchProcess(worker.pid);
  return true;
}

bool ProcessLauncher::StartAgain(Worker& worker) {
  const protocol::RecordingHeader& header = worker.recording->header();
  if (worker.is_second_time || worker.is_timed_out ||
      header.outcome.load(std::memory_order_acquire) != protocol::WorkerOutcome::kAgain)
    return false;
  std::string kept = protocol::kStartAgainKeeps, why = header.message.str();
  if (!worker.kept.empty()) kept += ' ' + worker.kept;
  if (why.empty()) return false;
  worker.recording->Clear();
  worker.is_second_time = true;
  worker.tail = {};
  Launch(worker, {protocol::kKeepOption, std::move(kept), std::move(why)});
  return true;
}

std::optional<Ending> ProcessLauncher::Wait(double seconds) {
  const Clock::time_point until =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(
                         std::chrono::duration<double>(std::clamp(seconds, 0.0, 1e9)));
  while (true) {
    Clock::time_point next = until;
    std::vector<pollfd> watched;
    for (const auto& worker : workers_) {
      if (!worker) continue;
      watched.push_back({worker->pidfd.get(), POLLIN, 0});
      watched.push_back({worker->errors.get(), POLLIN, 0});  // -1 once closed: ignored by poll
      if (worker->deadline && !worker->is_timed_out) next = std::min(next, *worker->deadline);
    }
    if (stop_ != nullptr) watched.push_back({stop_->fd(), POLLIN, 0});

    const auto left = std::max(next - Clock::now(), Clock::duration::zero());
    const auto whole = std::chrono::duration_cast<std::chrono::seconds>(left);
    const timespec timeout = {
        whole.count(), std::chrono::duration_cast<std::chrono::nanoseconds>(left - whole).count()};
    if (ppoll(watched.data(), watched.size(), &timeout, nullptr) < 0 && errno != EINTR)
      FailToStart("cannot wait for a worker", errno);

    std::size_t i = 0;
    Worker* ended = nullptr;
    const Clock::time_point now = Clock::now();
    for (const auto& worker : workers_) {
      if (!worker) continue;
      const bool has_ended = watched[i].revents != 0;
      if (watched[i + 1].revents != 0) DrainErrors(*worker);
      i += 2;
      if (has_ended) {
        ended = worker.get();
      } else if (worker->deadline && !worker->is_timed_out && now >= *worker->deadline) {
        worker->is_timed_out = true;
        worker->Kill();
      }
    }
    if (ended != nullptr) {
      if (auto ending = Reap(*ended)) return ending;
      continue;
    }
    if ((stop_ != nullptr && stop_->requested()) || now >= until) return std::nullopt;
  }
}

void ProcessLauncher::DrainErrors(Worker& worker) {
  char buffer[16384];
  // Bounded, so that a worker that never stops writing cannot block us here.
  for (int rounds = 0; rounds < 64 && worker.errors.get() >= 0; ++rounds) {
    const ssize_t got = read(worker.errors.get(), buffer, sizeof buffer);
    if (got > 0) {
      worker.tail.Append({buffer, static_cast<std::size_t>(got)});
    } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
      worker.errors.Close();
    } else if (errno == EAGAIN) {
      return;
    }
  }
}

std::optional<Ending> ProcessLauncher::Reap(Worker& worker) {
  Ending ending;
  ending.slot = worker.slot;
  ending.wall_s = std::chrono::duration<double>(Clock::now() - worker.start).count();
  // Kills the processes that it left running, before its process group id can be reused.
  worker.Kill();
  DrainErrors(worker);
  ProcessEnd end;
  rusage usage = {};
  while (wait4(worker.pid, &end.wait_status, 0, &usage) < 0) {
    if (errno != EINTR) FailToStart("cannot wait for a worker", errno);
  }
  worker.pid = -1;
  if (end.wait_status == 0 && StartAgain(worker)) return std::nullopt;
  end.is_timed_out = worker.is_timed_out;
  end.last_lines = worker.tail.LastLines();
  try {
    ending.result = Collect(*worker.run, end, *worker.recording, worker.contacts.get());
  } catch (const std::system_error& error) {
    throw ScheduleError(error.what());
  }
  double& peak = ending.result.scalars.peak_rss_bytes;
  if (plan::CountsInstructions(worker.run->scene)) {
    peak = schema::RunScalars::kNone;  // it is Valgrind's
  } else if (std::isnan(peak)) {
    // The worker ended before it reported the value: as counted by the system.
    peak = static_cast<double>(usage.ru_maxrss) * 1024;
  }
  ending.result.started_s = worker.started_s;
  ending.result.load = worker.load;
  ending.result.noise = NoiseOf(*worker.run, ending.result, *worker.recording);
  ending.result.host = machine::HostName();
  ending.recording = std::move(worker.recording);
  ending.narrow_input = std::move(worker.narrow_input);
  workers_[worker.slot].reset();
  return ending;
}

ForkServer::ForkServer(const std::filesystem::path& program) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    FailToStart("no descriptor to start a run", errno);
  socket_ = Descriptor(ends[0]);
  const Descriptor theirs(ends[1]), nowhere(open("/dev/null", O_WRONLY | O_CLOEXEC));
  SpawnPlan spawn;
  spawn.Give(nowhere.get(), STDERR_FILENO);  // if the server fails, a directly started worker
                                             // reports the reason
  spawn.Give(theirs.get(), protocol::kServerFd);
  spawn.SetVariable(std::string(protocol::kBindNow) + "=1");
  pid_ = spawn.Start(program, {protocol::kServeOption});
}

ForkServer::~ForkServer() {
  kill(pid_, SIGKILL);  // it has not been reaped, so its id is still valid
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

protocol::ForkAnswer ForkServer::Start(const protocol::ForkRequest& request) {
  return protocol::AskForWorker(socket_.get(), request);
}

int TraceCache::Get(const analysis::TraceName& name) {
  const auto found =
      std::ranges::find_if(traces_, [&](const auto& trace) { return trace.first == name; });
  if (found != traces_.end()) {
    traces_.splice(traces_.begin(), traces_, found);
  } else {
    while (!traces_.empty() && traces_.size() >= places_) traces_.pop_back();
    traces_.emplace_front(name, results::LoadTrace(name.path, name.sha256));
  }
  return traces_.front().second.fd();
}

}  // namespace cdb::process
