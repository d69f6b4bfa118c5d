// The table of scalars that a worker measures once per run. The layouts of the recording and of the
// results are derived from it.
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
  /// Overhead of a cycle: its clock stamps and a call of a detector that does nothing.
  double harness_ns = kNone;
  double fill_fraction = kNone;  ///< objects' volume over the cube's
  // For all recorded cycles, including the measurements between them.
  double cycles_wall_ns = kNone, cycles_cpu_ns = kNone;
  double preemptions = kNone;  ///< involuntary context switches of the thread
  double page_faults = kNone;  ///< of the thread
  double stolen_ns = kNone;    ///< taken by other virtual machines, summed over all processors
  double others_ns = kNone;    ///< processor time of other programs, summed over all processors
  double processors = kNone;   ///< number that the process may run on
  /// Set by the runner: the number of times that the run was measured; the quietest one is kept.
  double attempts = kNone;
};

struct RunScalarInfo {
  std::string_view name;  ///< name of the array in the results
  std::string_view unit;
  std::string_view doc;  ///< the array's long_name
  double RunScalars::*value;
  bool is_count = false;  ///< stored as int32 in the results
};
std::span<const RunScalarInfo> AllRunScalars();

}  // namespace cdb::measure
