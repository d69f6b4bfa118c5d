// Starts workers by a worker program that is loaded already and forks itself for each.
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "runtime/measure/fork_server.h"
#include "runtime/process/process.h"

namespace cdb::process {

/// A process of a worker program that serves measure::ForkRequest. Ended at the end; workers that
/// it started go on. Not for several threads.
class ForkServer {
 public:
  /// Throws ScheduleError if the program cannot be started.
  explicit ForkServer(const std::filesystem::path& program);
  ~ForkServer();
  ForkServer(const ForkServer&) = delete;
  ForkServer& operator=(const ForkServer&) = delete;

  /// No worker if the program or the system cannot do it.
  measure::ForkAnswer Start(const measure::ForkRequest& request);
  pid_t pid() const { return pid_; }

 private:
  Descriptor socket_;
  pid_t pid_ = -1;
};

}  // namespace cdb::process
