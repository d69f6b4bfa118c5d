// Memory usage of this process. Threads: any.
#pragma once

namespace cdb::probes {

/// The heap in use, bytes.
double HeapBytes();

/// Peak memory of this process, bytes; NaN if the system does not report it.
double PeakRssBytes();

}  // namespace cdb::probes
