// Caches traces: each file is read once for all runs that need it.
#pragma once

#include <cstddef>
#include <list>
#include <utility>

#include "compiler/analysis/trace.h"
#include "runtime/protocol/trace_memory.h"

namespace cdb::process {

/// Keeps the most recent traces. A worker has a copy of the descriptor, which keeps its trace
/// alive. Not thread-safe.
class TraceCache {
 public:
  explicit TraceCache(std::size_t places) : places_(places) {}

  /// The descriptor of the trace, valid until it has been displaced by others. Throws StoreError,
  /// std::system_error.
  int Get(const analysis::TraceName& name);

 private:
  std::size_t places_;
  std::list<std::pair<analysis::TraceName, protocol::TraceMemory>>
      traces_;  ///< the most recently requested first
};

}  // namespace cdb::process
