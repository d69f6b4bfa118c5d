// Facts about this machine.
#pragma once

#include <string>

namespace cdb::machine {

/// The name of this machine; `localhost` if it has none.
std::string HostName();

/// The load average of the last minute; NaN if the system does not report it.
double LoadAverage();

/// Times since the system started, ns, summed over all processors; NaN if the system does not
/// report them. The resolution is 10 ms on most systems. Source: proc_stat(5).
struct TimeOfAllProcessors {
  double busy = 0;    ///< used by programs and the system
  double stolen = 0;  ///< taken by other virtual machines
};
TimeOfAllProcessors ReadTimeOfAllProcessors();

/// The number of processors that this process may run on; NaN if the system does not report it.
double ProcessorCount();
/// The number of online processors of this machine, whether or not this process may run on them.
/// The load average counts the programs on all of them.
double OnlineProcessorCount();

}  // namespace cdb::machine
