// Disturbances of this thread by the machine while its cycles ran: time off the processor,
// preemptions, page faults, time used by other programs and stolen by other virtual machines.
#pragma once

#include "compiler/schema/series.h"

namespace cdb::probes {

/// Measures from its construction on. Source: clock_gettime(2), getrusage(2), proc_stat(5).
/// Threads: times are of the calling thread; stolen time and other programs are summed over all
/// processors.
class ProcessorTime {
 public:
  ProcessorTime() : begin_(Read()) {}
  /// Sets the scalars to the values since construction; NaN if the system does not report them.
  void Store(schema::RunScalars& scalars) const;

 private:
  struct Reading {
    double wall_ns = 0, cpu_ns = 0, preemptions = 0, faults = 0, stolen_ns = 0, busy_ns = 0,
           process_ns = 0;
  };
  static Reading Read();

  Reading begin_;
};

// Memory usage of this process. Threads: any.

/// To be called when a run begins: a worker that serves many has some heap in use before.
void BeginHeap();
/// The heap in use since BeginHeap, bytes.
double HeapBytes();

/// To be called once the objects are made: settling a pile or decomposing a mesh takes more memory
/// than a run, and happens only in the first one.
void BeginPeak();
/// Peak memory of this process since BeginPeak, bytes, or since its start if the system cannot
/// reset it; NaN if the system does not report it.
double PeakRssBytes();

}  // namespace cdb::probes
