#include "runtime/sweep/process/trace_cache.h"

#include <algorithm>

#include "runtime/results/trace_file.h"

namespace cdb::process {

int TraceCache::Get(const analysis::TraceName& name) {
  const auto found =
      std::ranges::find_if(traces_, [&](const auto& trace) { return trace.first == name; });
  if (found != traces_.end()) {
    traces_.splice(traces_.begin(), traces_, found);
  } else {
    while (!traces_.empty() && traces_.size() >= places_) traces_.pop_back();
    traces_.emplace_front(name, results::LoadTrace(name.path, name.sha256));
  }
  return traces_.front().second.fd();
}

}  // namespace cdb::process
