#include "library/confinement.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

namespace cdb::library {

void Confine() {
  const char* unconfined = std::getenv(kUnconfined);
  if (unconfined != nullptr && *unconfined != '\0') return;
  // Without it, the kernel allows only root to confine a process.
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  RestrictByLandlock();
  FilterSystemCalls();
}

namespace {

// From the kernel's linux/landlock.h. The header of the system may be older than its kernel.
struct Ruleset {
  std::uint64_t files, network, scopes;
};
constexpr long kCreateRuleset = 444, kRestrictSelf = 446;  // the same on every processor
constexpr unsigned kAskForVersion = 1;

// Rights of files by bit: 0 execute, 1 write, 2 and 3 read, 4 to 12 remove and make, 13 link and
// rename between folders, 14 truncate, 15 ioctl of devices.
constexpr std::uint64_t kFirstFiles = 0x1fff & ~0b1100u, kLink = 1 << 13, kTruncate = 1 << 14,
                        kDevices = 1 << 15;
constexpr std::uint64_t kAllTcp = 0b11, kAllScopes = 0b11;

}  // namespace

void RestrictByLandlock() {
  const long version = syscall(kCreateRuleset, nullptr, std::size_t{0}, kAskForVersion);
  if (version < 1) return;
  Ruleset rules = {kFirstFiles, 0, 0};
  if (version >= 2) rules.files |= kLink;
  if (version >= 3) rules.files |= kTruncate;
  if (version >= 4) rules.network = kAllTcp;
  if (version >= 5) rules.files |= kDevices;
  if (version >= 6) rules.scopes = kAllScopes;
  const std::size_t size = version >= 6   ? sizeof rules
                           : version >= 4 ? offsetof(Ruleset, scopes)
                                          : offsetof(Ruleset, network);
  // No rule is added, so none of these rights is granted anywhere.
  const long ruleset = syscall(kCreateRuleset, &rules, size, 0u);
  if (ruleset < 0) return;
  syscall(kRestrictSelf, ruleset, 0u);
  close(static_cast<int>(ruleset));
}

namespace {

#if defined(__x86_64__) && defined(__LP64__)
constexpr std::uint32_t kProcessor = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kProcessor = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kProcessor = 0;
#endif

constexpr std::uint32_t kRefused = SECCOMP_RET_ERRNO | EPERM;
/// ENOSYS makes the C library start threads by clone, whose flags a filter can see.
constexpr std::uint32_t kUnknown = SECCOMP_RET_ERRNO | ENOSYS;

constexpr int kAnyCall[] = {
    // memory
    SYS_brk,
    SYS_munmap,
    SYS_mremap,
    SYS_mprotect,
    SYS_madvise,
    SYS_mincore,
    SYS_msync,
    SYS_membarrier,
    // threads
    SYS_futex,
    SYS_set_robust_list,
    SYS_get_robust_list,
    SYS_set_tid_address,
    SYS_rseq,
    SYS_exit,
    SYS_exit_group,
    SYS_gettid,
    SYS_sched_yield,
    SYS_sched_getaffinity,
    SYS_getcpu,
    // time
    SYS_clock_gettime,
    SYS_clock_getres,
    SYS_clock_nanosleep,
    SYS_nanosleep,
    SYS_gettimeofday,
    SYS_times,
    SYS_setitimer,
    SYS_getitimer,
    SYS_timer_create,
    SYS_timer_settime,
    SYS_timer_gettime,
    SYS_timer_getoverrun,
    SYS_timer_delete,
    // signals of this process
    SYS_rt_sigaction,
    SYS_rt_sigprocmask,
    SYS_rt_sigreturn,
    SYS_rt_sigpending,
    SYS_rt_sigtimedwait,
    SYS_rt_sigsuspend,
    SYS_sigaltstack,
    SYS_restart_syscall,
    // open descriptors
    SYS_read,
    SYS_readv,
    SYS_pread64,
    SYS_write,
    SYS_writev,
    SYS_pwrite64,
    SYS_lseek,
    SYS_fstat,
    SYS_ftruncate,
    SYS_dup,
    SYS_dup3,
    SYS_pipe2,
    SYS_eventfd2,
    SYS_epoll_create1,
    SYS_close,
    SYS_close_range,
    SYS_ppoll,
    SYS_pselect6,
    // files to read
    SYS_newfstatat,
    SYS_statx,
    SYS_faccessat,
    SYS_faccessat2,
    SYS_readlinkat,
    SYS_getdents64,
    SYS_getcwd,
    // information
    SYS_getpid,
    SYS_getppid,
    SYS_getuid,
    SYS_geteuid,
    SYS_getgid,
    SYS_getegid,
    SYS_getrusage,
    SYS_uname,
    SYS_sysinfo,
    SYS_getrandom,
#ifdef __x86_64__
    SYS_time,
    SYS_pause,
    SYS_alarm,
    SYS_stat,
    SYS_lstat,
    SYS_access,
    SYS_readlink,
    SYS_dup2,
    SYS_pipe,
    SYS_poll,
    SYS_select,
#endif
};

/// Placeholder for the id of this process, which is known only at run time.
constexpr std::uint32_t kSelf = 0xfffffffe;

/// A list of instructions; each can jump forward by at most 255.
class Program {
 public:
  constexpr void Load(std::size_t offset) {
    code_.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)));
  }
  constexpr void LoadArgument(int index, bool is_upper_half = false) {
    const bool is_first_word = (std::endian::native == std::endian::big) == is_upper_half;
    Load(offsetof(seccomp_data, args) + 8 * static_cast<std::size_t>(index) +
         (is_first_word ? 0 : 4));
  }
  /// Jumps over the next `count` instructions if the comparison holds, or if it does not.
  constexpr void JumpIf(int comparison, std::uint32_t value, std::size_t count) {
    Jump(comparison, value, count, 0);
  }
  constexpr void JumpUnless(int comparison, std::uint32_t value, std::size_t count) {
    Jump(comparison, value, 0, count);
  }
  constexpr void Append(const Program& other) {
    code_.insert(code_.end(), other.code_.begin(), other.code_.end());
  }
  constexpr void Answer(std::uint32_t answer) {
    code_.push_back(BPF_STMT(BPF_RET | BPF_K, answer));
  }
  constexpr void AnswerIf(int comparison, std::uint32_t value, std::uint32_t answer) {
    JumpUnless(comparison, value, 1);
    Answer(answer);
  }
  constexpr const std::vector<sock_filter>& code() const { return code_; }

 private:
  constexpr void Jump(int comparison, std::uint32_t value, std::size_t if_true,
                      std::size_t if_false) {
    if (if_true > 255 || if_false > 255) throw "the jump is too long";
    code_.push_back(BPF_JUMP(static_cast<std::uint16_t>(BPF_JMP | BPF_K | comparison), value,
                             static_cast<std::uint8_t>(if_true),
                             static_cast<std::uint8_t>(if_false)));
  }

  std::vector<sock_filter> code_;
};

/// The part of the filter that handles the calls with these numbers.
struct Calls {
  std::uint32_t first, last;
  Program answer;
};

constexpr Calls Call(int number, Program answer) {
  const auto value = static_cast<std::uint32_t>(number);
  return {value, value, std::move(answer)};
}

constexpr Program Always(std::uint32_t answer) {
  Program program;
  program.Answer(answer);
  return program;
}

constexpr Program AllowValues(int argument, std::initializer_list<std::uint32_t> values) {
  Program program;
  program.LoadArgument(argument);
  for (const std::uint32_t value : values) program.AnswerIf(BPF_JEQ, value, SECCOMP_RET_ALLOW);
  program.Answer(kRefused);
  return program;
}

/// Allows opening files read-only.
constexpr Program AllowReading(int flags_argument) {
  constexpr std::uint32_t kTemporary = O_TMPFILE & ~O_DIRECTORY;
  Program program;
  program.LoadArgument(flags_argument);
  program.AnswerIf(BPF_JSET, O_ACCMODE | O_CREAT | O_TRUNC | kTemporary, kRefused);
  program.Answer(SECCOMP_RET_ALLOW);
  return program;
}

/// Allows private memory: what is shared, or grows like a stack, does not count towards
/// RLIMIT_DATA.
constexpr Program AllowPrivateMemory() {
  Program program;
  program.LoadArgument(3);
  program.AnswerIf(BPF_JSET, MAP_SHARED | MAP_GROWSDOWN, kRefused);
  program.Answer(SECCOMP_RET_ALLOW);
  return program;
}

/// Allows clone for threads, not for processes.
constexpr Program AllowThreads() {
  Program program;
  program.LoadArgument(0);
  program.AnswerIf(BPF_JSET, CLONE_THREAD, SECCOMP_RET_ALLOW);
  program.Answer(kRefused);
  return program;
}

/// Allows queries, not changes.
constexpr Program AllowWithoutPointer(int argument) {
  Program program;
  for (const bool is_upper_half : {false, true}) {
    program.LoadArgument(argument, is_upper_half);
    program.AnswerIf(BPF_JSET, 0xffffffff, kRefused);
  }
  program.Answer(SECCOMP_RET_ALLOW);
  return program;
}

/// All allowed calls, in the order of their numbers.
constexpr std::vector<Calls> ListCalls() {
  std::vector<Calls> calls;
  for (const int number : kAnyCall) calls.push_back(Call(number, Always(SECCOMP_RET_ALLOW)));
  calls.push_back(Call(SYS_openat, AllowReading(2)));
#ifdef __x86_64__
  calls.push_back(Call(SYS_open, AllowReading(1)));
#endif
  calls.push_back(Call(SYS_mmap, AllowPrivateMemory()));
  calls.push_back(Call(SYS_clone, AllowThreads()));
  calls.push_back(Call(SYS_clone3, Always(kUnknown)));
  calls.push_back(Call(SYS_prlimit64, AllowWithoutPointer(2)));
  calls.push_back(Call(SYS_kill, AllowValues(0, {kSelf})));
  calls.push_back(Call(SYS_tgkill, AllowValues(0, {kSelf})));  // abort
  calls.push_back(Call(SYS_sched_setaffinity, AllowValues(0, {0, kSelf})));
  calls.push_back(Call(SYS_prctl, AllowValues(0, {PR_SET_NAME, PR_GET_NAME, PR_SET_VMA})));
  calls.push_back(Call(
      SYS_fcntl, AllowValues(1, {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL, F_SETFL})));
  std::ranges::sort(calls, {}, &Calls::first);
  std::vector<Calls> joined;
  const auto is_plain = [](const Calls& one) {
    return one.answer.code().size() == 1 && one.answer.code()[0].k == SECCOMP_RET_ALLOW;
  };
  for (const Calls& one : calls) {
    if (!joined.empty() && is_plain(joined.back()) && is_plain(one) &&
        joined.back().last + 1 == one.first) {
      joined.back().last = one.last;
    } else {
      joined.push_back(one);
    }
  }
  return joined;
}

/// A binary search: the kernel runs a new filter on the number of every call.
constexpr Program Search(std::span<const Calls> calls) {
  Program program;
  if (calls.size() == 1) {
    const Calls& only = calls[0];
    const std::size_t size = only.answer.code().size();
    if (only.first == only.last) {
      program.JumpUnless(BPF_JEQ, only.first, size);
    } else {
      program.JumpUnless(BPF_JGE, only.first, size + 1);
      program.JumpIf(BPF_JGT, only.last, size);
    }
    program.Append(only.answer);
    program.Answer(kRefused);
    return program;
  }
  const std::size_t half = calls.size() / 2;
  const Program low = Search(calls.first(half));
  program.JumpIf(BPF_JGE, calls[half].first, low.code().size());
  program.Append(low);
  program.Append(Search(calls.subspan(half)));
  return program;
}

constexpr Program WholeProgram() {
  Program program;
  program.Load(offsetof(seccomp_data, arch));
  program.JumpIf(BPF_JEQ, kProcessor, 1);
  program.Answer(kRefused);
  // The numbers of the x32 ABI have a high bit set, and are not on the list.
  program.Load(offsetof(seccomp_data, nr));
  program.Append(Search(ListCalls()));
  return program;
}

/// Computed at compile time: in a newly forked worker, it would take longer than the kernel takes
/// to install it.
constexpr auto kProgram = [] {
  std::array<sock_filter, WholeProgram().code().size()> code = {};
  std::ranges::copy(WholeProgram().code(), code.begin());
  return code;
}();

}  // namespace

void FilterSystemCalls() {
  if (kProcessor == 0) return;
  auto code = kProgram;
  const auto self = static_cast<std::uint32_t>(getpid());
  for (sock_filter& instruction : code)
    if (instruction.k == kSelf) instruction.k = self;
  const sock_fprog program = {static_cast<unsigned short>(code.size()), code.data()};
  // Kernels before 5.16 otherwise enable Spectre mitigations, whose cost would be in the times.
  syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER,
          SECCOMP_FILTER_FLAG_TSYNC | SECCOMP_FILTER_FLAG_SPEC_ALLOW, &program);
}

}  // namespace cdb::library
