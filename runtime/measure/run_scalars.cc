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
  };
  return kScalars;
}

}  // namespace cdb::measure
