// Workers forked from one that has its libraries loaded, which saves the greater part of what a
// process costs to start. Both ends of the socket between the runner and that process.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace cdb::measure {

/// The worker's option to wait for requests at kServerFd in place of running a run.
inline constexpr const char* kServeOption = "--serve";
inline constexpr int kServerFd = 3;
/// In its environment: the linker looks up all functions at once, and not in the first cycle of
/// each worker, which would also have to copy the page that the result is written to.
inline constexpr const char* kBindNow = "LD_BIND_NOW";

/// In the environment of a worker that the runner starts itself: its process number. A worker whose
/// parent is another one has outlived it.
inline constexpr const char* kRunnerVariable = "CDB_RUNNER";
/// The same for its memory limit, in bytes.
inline constexpr const char* kMemoryVariable = "CDB_MEMORY_LIMIT";
/// Worker: dies when its runner does, from now on, and at once if that has happened; takes the
/// memory limit of its environment. Unsets both variables.
void BindToRunner();

struct ForkRequest {
  std::vector<std::pair<int, int>> descriptors;  ///< of the runner, and their numbers in the worker
  std::vector<std::string> arguments;            ///< without the program; none of them empty
  int cpu = -1;                                  ///< the only one to run on; -1: any
  std::uint64_t memory = 0;                      ///< bytes of private memory at most; 0: no limit
};

struct ForkAnswer {
  pid_t worker = -1;  ///< a child of this process, as if it had forked it; -1: none
  /// No worker is known, and yet one may have been started: the server ended before it answered.
  bool is_uncertain = false;
};

/// Runner: asks the process at the other end of `server` (a SOCK_SEQPACKET) for a worker. There is
/// none if that process has ended, cannot fork so, or the request does not fit. Threads: one at a
/// time.
ForkAnswer AskForWorker(int server, const ForkRequest& request);

/// Worker: answers requests at kServerFd until the runner closes its end, then ends the process. In
/// each worker, calls `run` with the arguments of the request, and exits with what it returns. A
/// worker has the descriptors of the request beside those up to STDERR_FILENO, leads a process
/// group, and is killed when the runner ends. Heap, stack and later mappings have other addresses
/// in each worker, as in processes of their own, unless the system is told not to randomize them.
/// Between requests the server runs nothing that depends on them: every worker begins alike. To be
/// called by a process with one thread.
[[noreturn]] void ServeForks(int (*run)(const std::vector<std::string>& arguments));

}  // namespace cdb::measure
