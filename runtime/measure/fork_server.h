// Workers forked from one that has its libraries loaded, which saves the greater part of what a
// process costs to start. Both ends of the socket between the runner and that process.
#pragma once

#include <sys/types.h>

#include <optional>
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

struct ForkRequest {
  std::vector<std::pair<int, int>> descriptors;  ///< of the runner, and their numbers in the worker
  std::vector<std::string> arguments;            ///< without the program; none of them empty
  int cpu = -1;                                  ///< the only one to run on; -1: any
};

/// Runner: asks the process at the other end of `server` (a SOCK_SEQPACKET) for a worker, which is
/// a child of this process, as if this process had forked it. Its number; nullopt if that process
/// has ended, cannot fork so, or the request does not fit. Threads: one at a time.
std::optional<pid_t> AskForWorker(int server, const ForkRequest& request);

/// Worker: answers requests at kServerFd until the runner closes its end, then ends the process. In
/// each worker, calls `run` with the arguments of the request, and exits with what it returns. A
/// worker has the descriptors of the request beside those up to STDERR_FILENO, leads a process
/// group, and is killed when the runner ends. Heap, stack and later mappings have other addresses
/// in each worker, as in processes of their own, unless the system is told not to randomize them.
/// Between requests the server runs nothing that depends on them: every worker begins alike. To be
/// called by a process with one thread.
[[noreturn]] void ServeForks(int (*run)(const std::vector<std::string>& arguments));

}  // namespace cdb::measure
