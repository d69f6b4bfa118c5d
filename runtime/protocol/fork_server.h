// Forks workers from a process that has its libraries loaded, which saves most of the cost of
// starting a process. Both ends of the socket between the runner and that process.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace cdb::protocol {

/// Option of the worker program: wait for requests at kServerFd instead of executing a run.
inline constexpr const char* kServeOption = "--serve";
inline constexpr int kServerFd = 3;
/// Environment variable of that process: the linker resolves all functions at once. Otherwise each
/// worker would resolve them in its first cycle, and copy the page to which the results are
/// written.
inline constexpr const char* kBindNow = "LD_BIND_NOW";

/// Environment variable of a worker that the runner starts itself: the runner's process id. A
/// worker with another parent has outlived its runner.
inline constexpr const char* kRunnerVariable = "CDB_RUNNER";
/// The same for the worker's memory limit, in bytes.
inline constexpr const char* kMemoryVariable = "CDB_MEMORY_LIMIT";
/// The same for a worker of a run with `addresses shuffled`: a text of any length, which moves the
/// stack even if the system does not randomise addresses.
inline constexpr const char* kShuffledVariable = "CDB_SHUFFLED";
/// Worker: makes this process die with its runner, at once if the runner is already dead, and sets
/// the memory limit and moves the heap as the environment says. Unsets the variables.
void BindToRunner();

struct ForkRequest {
  std::vector<std::pair<int, int>> descriptors;  ///< of the runner, with their numbers in the
                                                 ///< worker
  std::vector<std::string> arguments;            ///< without the program; none is empty
  int cpu = -1;                                  ///< the only processor to run on; -1: any
  std::uint64_t memory = 0;                      ///< limit of private memory, bytes; 0: no limit
};

struct ForkAnswer {
  pid_t worker = -1;  ///< a child of this process, as if it had forked it; -1: none
  /// The server ended before it answered: no worker is known, but one may have been started.
  bool is_uncertain = false;
};

/// Runner: requests a worker from the process at the other end of `server` (a SOCK_SEQPACKET).
/// There is none if that process has ended or cannot fork in this way, or if the request is too
/// long. Threads: one at a time.
ForkAnswer AskForWorker(int server, const ForkRequest& request);

/// Worker: answers requests at kServerFd until the runner closes its end, then ends the process. In
/// each worker, calls `run` with the arguments of the request, and exits with its return value. A
/// worker has the descriptors of the request in addition to those up to STDERR_FILENO, leads a
/// process group, and is killed when the runner ends. Heap, stack and later mappings have different
/// addresses in each worker, as in independent processes, unless the system is told not to
/// randomize them. The state of the server does not depend on earlier requests: every worker begins
/// alike. Must be called by a process with one thread.
[[noreturn]] void ServeForks(int (*run)(const std::vector<std::string>& arguments));

}  // namespace cdb::protocol
