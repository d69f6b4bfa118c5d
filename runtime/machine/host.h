// Facts about this machine.
#pragma once

#include <string>

namespace cdb::machine {

/// Its name; `localhost` where it has none.
std::string HostName();

/// The load average of the last minute; NaN if the system does not say.
double LoadAverage();

/// ns since the system began, of all processors together; NaN if it does not say. In steps of 10 ms
/// on most systems. Source: proc_stat(5).
struct TimeOfAllProcessors {
  double busy = 0;    ///< with programs and the system's own work
  double stolen = 0;  ///< taken by other virtual machines
};
TimeOfAllProcessors ReadTimeOfAllProcessors();

/// The number of processors that this process may run on; NaN if the system does not say.
double ProcessorCount();

}  // namespace cdb::machine
