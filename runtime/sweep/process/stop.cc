#include "runtime/sweep/process/stop.h"

#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

#include "dsl/text/check.h"

namespace cdb::process {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

/// Global, because a signal handler has no user argument.
std::atomic<StopFlag*> g_flag{nullptr};

void HandleSignal(int signal) {
  const int saved_errno = errno;
  if (StopFlag* flag = g_flag.load(std::memory_order_acquire)) flag->Request(signal);
  errno = saved_errno;
}

}  // namespace

StopFlag::StopFlag() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "cannot watch for signals");
}

StopFlag::~StopFlag() { close(fd_); }

void StopFlag::Request(int signal) {
  int none = 0;
  signal_.compare_exchange_strong(none, signal, std::memory_order_acq_rel);
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(fd_, &one, sizeof one);
}

StopOnSignals::StopOnSignals(StopFlag& flag) {
  StopFlag* none = nullptr;
  CDB_CHECK(g_flag.compare_exchange_strong(none, &flag));
  for (const int signal : kSignals) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler == SIG_IGN) continue;
    struct sigaction action = {};
    action.sa_handler = HandleSignal;
    action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    sigaction(signal, &action, nullptr);
  }
}

StopOnSignals::~StopOnSignals() {
  for (const int signal : kSignals) {
    struct sigaction now = {};
    sigaction(signal, nullptr, &now);
    if (now.sa_handler != HandleSignal) continue;
    struct sigaction action = {};
    action.sa_handler = SIG_DFL;
    sigaction(signal, &action, nullptr);
  }
  g_flag.store(nullptr, std::memory_order_release);
}

}  // namespace cdb::process
