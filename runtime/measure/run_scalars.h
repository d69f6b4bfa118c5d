// The table of scalars: everything that a worker measures once in a run. The recording and the
// results follow from it.
#pragma once

#include <limits>
#include <span>
#include <string_view>

namespace cdb::measure {

/// NaN if the run did not get that far.
struct RunScalars {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double peak_rss_bytes = kNone;  ///< of the worker process
  double place_ns = kNone;        ///< placing the objects
  double build_ns = kNone;        ///< deciding the omissions and building the world
  /// Of a cycle: its clock stamps and a call of a detector that does nothing.
  double harness_ns = kNone;
  double fill_fraction = kNone;  ///< objects' volume over the cube's
  // Of the recorded cycles, with the measurements between them.
  double cycles_wall_ns = kNone, cycles_cpu_ns = kNone;
  double preemptions = kNone;  ///< of the thread: involuntary context switches
  double page_faults = kNone;  ///< of the thread
  double stolen_ns = kNone;    ///< by other virtual machines, of all processors
  double others_ns = kNone;    ///< processor time of other programs, of all processors
  double processors = kNone;   ///< that the process may run on
  /// Set by the runner: times that the run was measured, of which the quietest is kept.
  double attempts = kNone;
};

struct RunScalarInfo {
  std::string_view name;  ///< the array in the results
  std::string_view unit;
  std::string_view doc;  ///< the array's long_name
  double RunScalars::*value;
  bool is_count = false;  ///< an int32 in the results
};
std::span<const RunScalarInfo> AllRunScalars();

}  // namespace cdb::measure
