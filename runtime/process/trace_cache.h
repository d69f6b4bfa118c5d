// Caches traces: each file is read once for all runs that need it.
#pragma once

#include <cstddef>
#include <list>
#include <utility>

#include "compiler/analysis/trace.h"
#include "runtime/measure/trace_memory.h"

namespace cdb::process {

/// Keeps the last few: a worker's copy of the descriptor keeps its own alive. Not for several
/// threads.
class TraceCache {
 public:
  explicit TraceCache(std::size_t places) : places_(places) {}

  /// The descriptor of the trace, valid until as many others were asked for as there are places.
  /// Throws StoreError, std::system_error.
  int Get(const analysis::TraceName& name);

 private:
  std::size_t places_;
  std::list<std::pair<analysis::TraceName, measure::TraceMemory>>
      traces_;  ///< the last asked for first
};

}  // namespace cdb::process
