// Facts about this machine.
#pragma once

#include <string>

namespace cdb::measure {

/// Its name; `localhost` where it has none.
std::string HostName();

/// The load average of the last minute; NaN if the system does not say.
double LoadAverage();

/// ns: the time that other virtual machines took from all processors together since the system
/// began; NaN if it does not say. Source: proc_stat(5).
double StolenTime();

/// The number of processors that this process may run on; NaN if the system does not say.
double ProcessorCount();

}  // namespace cdb::measure
