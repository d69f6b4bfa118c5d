#include "runtime/measure/run_scalars.h"

namespace cdb::measure {

std::span<const RunScalarInfo> AllRunScalars() {
  static constexpr RunScalarInfo kScalars[] = {
      {"peak_rss", "bytes", "peak memory of the run's process", &RunScalars::peak_rss_bytes},
      {"place_time", "ns", "time to place the objects", &RunScalars::place_ns},
      {"build_time", "ns", "time to decide the omissions and build the world",
       &RunScalars::build_ns},
      {"harness", "ns",
       "measurement overhead of a cycle: time stamps, and calling a detector that does nothing",
       &RunScalars::harness_ns},
      {"fill_fraction", "", "volume of the objects over that of the world",
       &RunScalars::fill_fraction},
      {"cycles_time", "ns",
       "wall-clock time of the recorded cycles, with what is measured between them",
       &RunScalars::cycles_wall_ns},
      {"cpu_time", "ns", "of cycles_time, the time that the thread spent on a processor",
       &RunScalars::cycles_cpu_ns},
      {"preemptions", "", "how often the thread was taken off its processor meanwhile",
       &RunScalars::preemptions, true},
      {"page_faults", "", "page faults of the thread meanwhile", &RunScalars::page_faults, true},
      {"steal", "ns", "processor time taken by other virtual machines meanwhile, of all processors",
       &RunScalars::stolen_ns},
      {"other_time", "ns", "processor time of other programs meanwhile, of all processors",
       &RunScalars::others_ns},
      {"processors", "", "processors that the run was allowed to use", &RunScalars::processors,
       true},
      {"attempts", "", "times that the run was measured, of which the quietest is kept",
       &RunScalars::attempts, true},
  };
  return kScalars;
}

}  // namespace cdb::measure
