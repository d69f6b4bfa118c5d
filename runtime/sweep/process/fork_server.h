// Starts workers by forking them from a worker program that is already loaded.
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "runtime/protocol/fork_server.h"
#include "runtime/sweep/process/process.h"

namespace cdb::process {

/// A process of a worker program that answers protocol::ForkRequest. Ended on destruction; workers
/// that it started continue. Not thread-safe.
class ForkServer {
 public:
  /// Throws ScheduleError if the program cannot be started.
  explicit ForkServer(const std::filesystem::path& program);
  ~ForkServer();
  ForkServer(const ForkServer&) = delete;
  ForkServer& operator=(const ForkServer&) = delete;

  /// Returns no worker if the program or the system does not support it.
  protocol::ForkAnswer Start(const protocol::ForkRequest& request);
  pid_t pid() const { return pid_; }

 private:
  Descriptor socket_;
  pid_t pid_ = -1;
};

}  // namespace cdb::process
