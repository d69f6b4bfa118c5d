#include "runtime/engine/world/clock.h"

#include <time.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <stdexcept>
#include <string_view>

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#define CDB_HAS_VALGRIND 1
#else
#define CDB_HAS_VALGRIND 0
#endif

namespace cdb::world {
namespace {

int g_log = -1;

#if CDB_HAS_VALGRIND
/// The count in the answer to `status internal`: `events-1: 122514`, with the number of the thread.
/// -1: there is none.
std::int64_t CountIn(std::string_view answer) {
  constexpr std::string_view kBegin = "\nevents-1: ";
  const std::size_t begin = answer.find(kBegin);
  std::int64_t count = -1;
  if (begin != answer.npos)
    std::from_chars(answer.data() + begin + kBegin.size(), answer.data() + answer.size(), count);
  return count;
}

/// Asks Valgrind for the count. The answer is the request of callgrind_control(1), which names the
/// functions on the stack after the count: only its beginning is read.
std::int64_t ReadCount() {
  CALLGRIND_TOGGLE_COLLECT;  // off: what follows is the clock's own work
  VALGRIND_MONITOR_COMMAND("status internal");
  std::array<char, 1024> answer;
  const ssize_t size = pread(g_log, answer.data(), answer.size(), 0);
  const std::int64_t count =
      CountIn({answer.data(), size > 0 ? static_cast<std::size_t>(size) : 0});
  // Valgrind writes at the place that its descriptor shares with ours.
  if (ftruncate(g_log, 0) != 0 || lseek(g_log, 0, SEEK_SET) != 0) return -1;
  CALLGRIND_TOGGLE_COLLECT;
  return count;
}
#endif

}  // namespace

std::int64_t Now() {
#if CDB_HAS_VALGRIND
  if (g_log >= 0) return ReadCount();
#endif
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1000000000} * now.tv_sec + now.tv_nsec;
}

void CountInstructions(int log) {
#if CDB_HAS_VALGRIND
  if (!RUNNING_ON_VALGRIND)
    throw std::runtime_error("clock instructions: this worker was not started by Valgrind");
  if (ftruncate(log, 0) != 0 || lseek(log, 0, SEEK_SET) != 0)
    throw std::runtime_error("clock instructions: cannot read the log of Valgrind");
  g_log = log;
  if (ReadCount() < 0)
    throw std::runtime_error(
        "clock instructions: this version of Valgrind does not tell its count of instructions");
#else
  static_cast<void>(log);
  throw std::runtime_error(
      "clock instructions: cdb was built without the headers of Valgrind; install the package "
      "valgrind, and build cdb again");
#endif
}

}  // namespace cdb::world
