// Turns Ctrl-C and SIGTERM into a stop request that the scheduler checks between runs.
#pragma once

#include <atomic>

namespace cdb::process {

/// Set once, from any thread or from a signal handler.
class StopFlag {
 public:
  /// Throws std::system_error if no descriptor is left.
  StopFlag();
  ~StopFlag();
  StopFlag(const StopFlag&) = delete;
  StopFlag& operator=(const StopFlag&) = delete;

  /// Async-signal-safe.
  void Request(int signal);
  bool requested() const { return signal() != 0; }
  /// The first signal that requested a stop, or 0. The process then exits with 128 + signal.
  int signal() const { return signal_.load(std::memory_order_acquire); }
  /// Readable once a stop is requested.
  int fd() const { return fd_; }

 private:
  std::atomic<int> signal_{0};
  int fd_ = -1;
};
static_assert(std::atomic<int>::is_always_lock_free);

/// While it lives, SIGINT, SIGTERM and SIGHUP set `flag`; a second signal of the same kind ends the
/// process at once, as by default. A signal that was ignored before (nohup, a shell's background
/// job) stays ignored. Only one may exist in a process at a time.
class StopOnSignals {
 public:
  explicit StopOnSignals(StopFlag& flag);
  ~StopOnSignals();
  StopOnSignals(const StopOnSignals&) = delete;
  StopOnSignals& operator=(const StopOnSignals&) = delete;
};

}  // namespace cdb::process
