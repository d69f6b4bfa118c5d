// Facts about a trace, the recorded boxes named by `trace "run.trace.h5"`. Compiler and runner
// share them; the store reads traces.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

struct TraceFacts {
  std::string sha256;        ///< of its boxes and filters, 64 hex digits
  std::uint64_t bodies = 0;  ///< including walls
  std::uint64_t cycles = 0;
  double timestep_s = 0;
  bool is_double = false;  ///< recorded in double precision
};

/// Reads a trace from disk; a function, so that the compiler does not depend on HDF5. The facts
/// about `path`, or nullopt and the reason why it cannot be used.
using ReadTrace =
    std::function<std::optional<TraceFacts>(const std::string& path, std::string& why)>;

/// The trace on which the detector of a scene is run.
struct TraceName {
  std::string path, sha256;
  bool operator==(const TraceName&) const = default;
};
/// Nullopt if the scene runs in a live world.
std::optional<TraceName> TraceOf(const plan::Scene& scene);

}  // namespace cdb::analysis
