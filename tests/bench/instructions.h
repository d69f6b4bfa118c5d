// Counts the instructions of sections of a program: with the processor's counter, or with Valgrind,
// as most virtual machines have no such counter.
#pragma once

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#define CDB_CALLGRIND(request) CALLGRIND_##request
#else
#define CDB_CALLGRIND(request)
#define RUNNING_ON_VALGRIND false
#endif

namespace cdb::bench {

/// Counts the instructions of the thread that made it, outside the kernel. Under Valgrind, with
/// --tool=callgrind --instr-atstart=no --collect-atstart=no, those of all threads. Threads: one.
class InstructionCounter {
 public:
  InstructionCounter() {
    if (RUNNING_ON_VALGRIND) return;
    perf_event_attr wanted = {};
    wanted.size = sizeof wanted;
    wanted.type = PERF_TYPE_HARDWARE;
    wanted.config = PERF_COUNT_HW_INSTRUCTIONS;
    wanted.exclude_kernel = wanted.exclude_hv = 1;
    file_ = static_cast<int>(syscall(SYS_perf_event_open, &wanted, 0, -1, -1, 0));
  }
  ~InstructionCounter() {
    if (file_ >= 0) close(file_);
  }
  InstructionCounter(const InstructionCounter&) = delete;
  InstructionCounter& operator=(const InstructionCounter&) = delete;

  /// Starts at zero. Valgrind is slow only between Begin and Finish.
  void Begin() {
    CDB_CALLGRIND(START_INSTRUMENTATION);
    sum_ = 0;
  }
  void Start() {
    CDB_CALLGRIND(TOGGLE_COLLECT);
    started_ = Read();
  }
  void Stop() {
    sum_ += Read() - started_;
    CDB_CALLGRIND(TOGGLE_COLLECT);
  }
  /// The instructions between Start and Stop since Begin or the last call; zero if nothing counts
  /// them.
  double Take() {
    if (!RUNNING_ON_VALGRIND) return static_cast<double>(std::exchange(sum_, 0));
    CDB_CALLGRIND(DUMP_STATS);
    const std::string dump =
        "callgrind.out." + std::to_string(getpid()) + "." + std::to_string(++dumps_);
    std::ifstream in(dump);
    double total = 0;
    for (std::string line; std::getline(in, line);)
      if (line.starts_with("totals: ")) total = std::stod(line.substr(8));
    std::filesystem::remove(dump);
    return total;
  }
  /// The same, at the end.
  double Finish() {
    const double total = Take();
    CDB_CALLGRIND(STOP_INSTRUMENTATION);
    return total;
  }

 private:
  std::uint64_t Read() const {
    std::uint64_t count = 0;
    if (file_ < 0 || read(file_, &count, sizeof count) != sizeof count) return 0;
    return count;
  }

  int file_ = -1;
  inline static int dumps_ = 0;  // Valgrind numbers those of a process
  std::uint64_t sum_ = 0, started_ = 0;
};

}  // namespace cdb::bench
