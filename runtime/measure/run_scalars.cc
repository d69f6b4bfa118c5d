#include "runtime/measure/run_scalars.h"

namespace cdb::measure {

std::span<const RunScalarInfo> AllRunScalars() {
  static constexpr RunScalarInfo kScalars[] = {
      {"peak_rss", "bytes", "most memory that the run's process held", &RunScalars::peak_rss_bytes},
      {"place_time", "ns", "time of finding a place for every object", &RunScalars::place_ns},
      {"build_time", "ns", "time of making the world", &RunScalars::build_ns},
      {"harness", "ns", "what a cycle's calling of a detector costs beside the detector's own work",
       &RunScalars::harness_ns},
      {"fill_fraction", "", "volume of the objects over that of the world",
       &RunScalars::fill_fraction},
  };
  return kScalars;
}

}  // namespace cdb::measure
