#include "runtime/protocol/fork_server.h"

#include <alloca.h>
#include <fcntl.h>
#include <linux/sched.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/personality.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace cdb::protocol {
namespace {

constexpr std::size_t kMostDescriptors = 8, kMostText = 32 << 10;
/// Descriptors are kept above this number until they get their final ones.
constexpr int kAboveAllTargets = 16;

struct RequestHead {
  std::uint64_t memory;
  std::int32_t cpu;
  std::uint32_t descriptors;
  std::array<std::int32_t, kMostDescriptors> targets;
};

/// A received request, in memory whose layout does not depend on the request.
struct Received {
  RequestHead head;
  std::array<char, kMostText> text;  ///< arguments, each terminated by a NUL
  std::size_t text_size;
  std::array<int, kMostDescriptors> descriptors;
};

/// Ancillary data of a message: descriptors.
union Ancillary {
  cmsghdr align;
  char bytes[CMSG_SPACE(sizeof(int) * kMostDescriptors)];
};

/// False at the end of the connection, and for a message that AskForWorker does not send.
bool Receive(int server, Received& request) {
  std::array<iovec, 2> parts = {
      {{&request.head, sizeof request.head}, {request.text.data(), request.text.size()}}};
  Ancillary ancillary;
  msghdr message = {};
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  message.msg_control = ancillary.bytes;
  message.msg_controllen = sizeof ancillary.bytes;
  ssize_t got = -1;
  do {
    got = recvmsg(server, &message, MSG_CMSG_CLOEXEC);
  } while (got < 0 && errno == EINTR);
  if (got < static_cast<ssize_t>(sizeof request.head)) return false;
  request.text_size = static_cast<std::size_t>(got) - sizeof request.head;
  const cmsghdr* rights = CMSG_FIRSTHDR(&message);
  const std::size_t bytes = request.head.descriptors * sizeof(int);
  if (request.head.descriptors > kMostDescriptors || rights == nullptr ||
      rights->cmsg_type != SCM_RIGHTS || rights->cmsg_len != CMSG_LEN(bytes))
    return false;
  std::memcpy(request.descriptors.data(), CMSG_DATA(rights), bytes);
  return true;
}

/// Creates a child of our parent, with one thread and a copy of our memory, as fork would create a
/// child of ours; returns a negative number on failure. `tid` is the address where the C library
/// keeps the id of the thread, which fork would set.
pid_t ForkSibling(void* tid) {
  clone_args how = {};
  how.flags = CLONE_PARENT | CLONE_CHILD_SETTID | CLONE_CHILD_CLEARTID;
  how.child_tid = reinterpret_cast<std::uintptr_t>(tid);
  return static_cast<pid_t>(syscall(SYS_clone3, &how, sizeof how));
}

/// Gives the descriptors their numbers and closes all others.
bool TakeDescriptors(const Received& request) {
  int last = STDERR_FILENO;
  std::array<int, kMostDescriptors> raised = {};
  for (std::size_t i = 0; i < request.head.descriptors; ++i)
    raised[i] = fcntl(request.descriptors[i], F_DUPFD_CLOEXEC, kAboveAllTargets);
  for (std::size_t i = 0; i < request.head.descriptors; ++i) {
    const int target = request.head.targets[i];
    if (raised[i] < 0 || dup2(raised[i], target) != target) return false;
    last = std::max(last, target);
  }
  return syscall(SYS_close_range, static_cast<unsigned>(last) + 1, ~0U, 0) == 0;
}

/// Moves later allocations of the heap within their page, to any place that malloc aligns to.
void ShuffleHeap() {
  constexpr std::size_t kPage = 4096, kStep = 16;
  std::uint32_t random = 0;
  if (getrandom(&random, sizeof random, 0) != sizeof random) return;
  // Kept, so that its place is not used again.
  static void* kept = nullptr;
  kept = malloc(kStep + random % (kPage / kStep) * kStep);
  static_cast<void>(kept);
}

/// The number of bytes by which addresses are moved.
struct Shift {
  std::size_t heap = 0, stack = 0;
};

/// Moves later allocations. The caller moves the stack.
Shift ShiftAddresses() {
  const int persona = personality(0xffffffff);
  std::array<std::uint32_t, 3> random = {};
  if ((persona != -1 && (persona & ADDR_NO_RANDOMIZE) != 0) ||
      getrandom(random.data(), sizeof random, 0) != sizeof random)
    return {};
  // The space is never touched, so it costs no memory. A process that cannot get it does without.
  constexpr std::size_t kPage = 4096, kHeapPages = 1 << 10, kMappedPages = 1 << 14;
  constexpr std::size_t kStackBytes = 1 << 14, kStackStep = 16;
  const std::size_t heap = random[0] % kHeapPages * kPage;
  const bool is_moved = sbrk(static_cast<std::intptr_t>(heap)) != reinterpret_cast<void*>(-1);
  [[maybe_unused]] const void* mapped =
      mmap(nullptr, (1 + random[1] % kMappedPages) * kPage, PROT_NONE,
           MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return {is_moved ? heap : 0, random[2] % kStackBytes / kStackStep * kStackStep};
}

std::vector<std::string> ArgumentsOf(const Received& request) {
  std::vector<std::string> arguments;
  std::string_view rest(request.text.data(), request.text_size);
  for (std::size_t end; (end = rest.find('\0')) != std::string_view::npos;
       rest.remove_prefix(end + 1))
    arguments.emplace_back(rest.substr(0, end));
  return arguments;
}

/// Limits heap, anonymous mappings and stacks of threads, and each file, which may be one in
/// memory. False if a limit cannot be set.
bool LimitMemory(std::uint64_t bytes) {
  signal(SIGXFSZ, SIG_IGN);  // so that a write beyond the limit fails
  for (const auto resource : {RLIMIT_DATA, RLIMIT_FSIZE}) {
    rlimit limit = {};
    if (getrlimit(resource, &limit) != 0) return false;
    limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(limit.rlim_max, bytes);
    if (setrlimit(resource, &limit) != 0) return false;
  }
  return true;
}

[[noreturn]] void BeWorker(const Received& request, pid_t runner,
                           int (*run)(const std::vector<std::string>& arguments)) {
  constexpr int kCannotBegin = 125;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != runner || setpgid(0, 0) != 0 || !TakeDescriptors(request)) _exit(kCannotBegin);
  const Shift shift = ShiftAddresses();
  auto* room = static_cast<volatile char*>(alloca(shift.stack + 1));
  *room = 0;
  // The random shift must not count towards the limit.
  if (request.head.memory > 0 && !LimitMemory(request.head.memory + shift.heap))
    _exit(kCannotBegin);
  exit(run(ArgumentsOf(request)));
}

}  // namespace

void BindToRunner() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const char* runner = getenv(kRunnerVariable);
  if (runner != nullptr && std::strtol(runner, nullptr, 10) != getppid()) _exit(0);
  unsetenv(kRunnerVariable);  // processes started by this one have it as parent
  const char* memory = getenv(kMemoryVariable);
  if (memory != nullptr && !LimitMemory(std::strtoull(memory, nullptr, 10))) _exit(0);
  unsetenv(kMemoryVariable);
  if (getenv(kShuffledVariable) != nullptr) ShuffleHeap();
  unsetenv(kShuffledVariable);
}

ForkAnswer AskForWorker(int server, const ForkRequest& request) {
  RequestHead head = {
      request.memory, request.cpu, static_cast<std::uint32_t>(request.descriptors.size()), {}};
  std::string text;
  for (const std::string& argument : request.arguments) text.append(argument).push_back('\0');
  if (request.descriptors.size() > kMostDescriptors || text.size() > kMostText) return {};
  std::array<iovec, 2> parts = {{{&head, sizeof head}, {text.data(), text.size()}}};
  Ancillary ancillary = {};
  msghdr message = {};
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  message.msg_control = ancillary.bytes;
  message.msg_controllen = CMSG_SPACE(sizeof(int) * request.descriptors.size());
  cmsghdr* rights = CMSG_FIRSTHDR(&message);
  rights->cmsg_level = SOL_SOCKET;
  rights->cmsg_type = SCM_RIGHTS;
  rights->cmsg_len = CMSG_LEN(sizeof(int) * request.descriptors.size());
  for (std::size_t i = 0; i < request.descriptors.size(); ++i) {
    head.targets[i] = request.descriptors[i].second;
    std::memcpy(CMSG_DATA(rights) + i * sizeof(int), &request.descriptors[i].first, sizeof(int));
  }
  ssize_t done = -1;
  do {
    done = sendmsg(server, &message, MSG_NOSIGNAL);
  } while (done < 0 && errno == EINTR);
  if (done < 0) return {};
  std::int32_t answer = -1;
  do {
    done = recv(server, &answer, sizeof answer, 0);
  } while (done < 0 && errno == EINTR);
  if (done != sizeof answer) return {-1, true};
  return {answer > 0 ? answer : -1, false};
}

void ServeForks(int (*run)(const std::vector<std::string>& arguments)) {
  static Received request;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // The process that made the socket may have died before this program was loaded.
  ucred maker = {};
  socklen_t size = sizeof maker;
  const pid_t runner =
      getsockopt(kServerFd, SOL_SOCKET, SO_PEERCRED, &maker, &size) == 0 ? maker.pid : getppid();
  if (getppid() != runner) _exit(0);
  const int server = fcntl(kServerFd, F_DUPFD_CLOEXEC, kAboveAllTargets);
  void* tid = nullptr;
  const bool can_fork = prctl(PR_GET_TID_ADDRESS, &tid) == 0 && tid != nullptr;
  close(kServerFd);
  unsetenv(kBindNow);  // programs started by a worker must not inherit it
  unsetenv(kRunnerVariable);
  cpu_set_t all;
  if (sched_getaffinity(0, sizeof all, &all) != 0) CPU_ZERO(&all);
  while (Receive(server, request)) {
    cpu_set_t cpus = all;
    if (request.head.cpu >= 0) {
      CPU_ZERO(&cpus);
      CPU_SET(static_cast<unsigned>(request.head.cpu), &cpus);
    }
    sched_setaffinity(0, sizeof cpus, &cpus);  // the worker then never runs on another processor
    const pid_t worker = can_fork ? ForkSibling(tid) : -1;
    if (worker == 0) BeWorker(request, runner, run);
    for (std::size_t i = 0; i < request.head.descriptors; ++i) close(request.descriptors[i]);
    const std::int32_t answer = worker;
    if (send(server, &answer, sizeof answer, MSG_NOSIGNAL) != sizeof answer) break;
  }
  _exit(0);
}

}  // namespace cdb::protocol
