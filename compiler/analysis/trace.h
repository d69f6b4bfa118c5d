// What is known of a trace, the recorded boxes that `trace "run.trace.h5"` names. Compiler and
// runner share it; reading one is the store's.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

struct TraceFacts {
  std::string sha256;        ///< of its boxes and filters, 64 hex digits
  std::uint64_t bodies = 0;  ///< with walls
  std::uint64_t cycles = 0;
  double timestep_s = 0;
  bool is_double = false;  ///< recorded in double precision
};

/// The disk, behind a function so that the compiler knows no HDF5: what `path` holds, or nullopt
/// and why it is of no use.
using ReadTrace =
    std::function<std::optional<TraceFacts>(const std::string& path, std::string& why)>;

/// The trace that a scene's detector is run on.
struct TraceName {
  std::string path, sha256;
  bool operator==(const TraceName&) const = default;
};
/// Nullopt where it runs in a live world.
std::optional<TraceName> TraceOf(const plan::Scene& scene);

}  // namespace cdb::analysis
