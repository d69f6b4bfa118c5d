// Turns Ctrl-C and SIGTERM into a stop request that the scheduler checks between runs.
#pragma once

#include <atomic>

namespace cdb::process {

/// Set once, from anywhere, also from a signal handler.
class StopFlag {
 public:
  /// Throws std::system_error where there is no descriptor left.
  StopFlag();
  ~StopFlag();
  StopFlag(const StopFlag&) = delete;
  StopFlag& operator=(const StopFlag&) = delete;

  /// Async-signal-safe.
  void Request(int signal);
  bool requested() const { return signal() != 0; }
  /// The first signal that asked, 0 where none did. The process then exits with 128 + signal.
  int signal() const { return signal_.load(std::memory_order_acquire); }
  /// Readable once a stop is asked for.
  int fd() const { return fd_; }

 private:
  std::atomic<int> signal_{0};
  int fd_ = -1;
};
static_assert(std::atomic<int>::is_always_lock_free);

/// While it lives, SIGINT, SIGTERM and SIGHUP set `flag`; a second one of a kind ends the process
/// at once, as always. A signal that was ignored before (nohup, a shell's background job) stays
/// ignored. One at a time in a process.
class StopOnSignals {
 public:
  explicit StopOnSignals(StopFlag& flag);
  ~StopOnSignals();
  StopOnSignals(const StopOnSignals&) = delete;
  StopOnSignals& operator=(const StopOnSignals&) = delete;
};

}  // namespace cdb::process
