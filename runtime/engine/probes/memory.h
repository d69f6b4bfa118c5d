// What this process takes of the machine's memory. Threads: any.
#pragma once

namespace cdb::probes {

/// The heap in use, bytes.
double HeapBytes();

/// The most memory that this process has had at once, bytes; NaN where the system does not say.
double PeakRssBytes();

}  // namespace cdb::probes
