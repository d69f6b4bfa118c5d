#include "runtime/engine/probes/processor_time.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <fstream>
#include <limits>
#include <string>

#include "runtime/protocol/machine/machine.h"

namespace cdb::probes {
namespace {

double ClockNs(clockid_t clock) {
  timespec time = {};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) * 1e9 + static_cast<double>(time.tv_nsec);
}

}  // namespace

ProcessorTime::Reading ProcessorTime::Read() {
  Reading now;
  const machine::TimeOfAllProcessors all = machine::ReadTimeOfAllProcessors();
  now.stolen_ns = all.stolen;
  now.busy_ns = all.busy;
  now.process_ns = ClockNs(CLOCK_PROCESS_CPUTIME_ID);
  rusage usage = {};
  getrusage(RUSAGE_THREAD, &usage);
  now.preemptions = static_cast<double>(usage.ru_nivcsw);
  now.faults = static_cast<double>(usage.ru_minflt + usage.ru_majflt);
  now.cpu_ns = ClockNs(CLOCK_THREAD_CPUTIME_ID);
  now.wall_ns = ClockNs(CLOCK_MONOTONIC);
  return now;
}

void ProcessorTime::Store(schema::RunScalars& scalars) const {
  const Reading end = Read();
  scalars.cycles_wall_ns = end.wall_ns - begin_.wall_ns;
  scalars.cycles_cpu_ns = end.cpu_ns - begin_.cpu_ns;
  scalars.preemptions = end.preemptions - begin_.preemptions;
  scalars.page_faults = end.faults - begin_.faults;
  scalars.stolen_ns = end.stolen_ns - begin_.stolen_ns;
  scalars.others_ns =
      std::max(0.0, (end.busy_ns - begin_.busy_ns) - (end.process_ns - begin_.process_ns));
  scalars.processors = machine::ProcessorCount();
}

namespace {

std::atomic<double> heap_at_start = 0;

double HeapInUse() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

}  // namespace

void BeginHeap() { heap_at_start = HeapInUse(); }
double HeapBytes() { return HeapInUse() - heap_at_start; }

void BeginPeak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";  // proc(5): resets VmHWM
}

double PeakRssBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace cdb::probes
