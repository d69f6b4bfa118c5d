// Assigns a processor to each slot of a runner.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "runtime/sweep/process/process.h"

namespace cdb::process {

inline constexpr std::string_view kProcessorClaim = "cdb-processor";

/// Processors on which no other runner of this machine measures: several `cdb run` side by side, as
/// started by GNU parallel, must not share one. A claim is an address in the abstract namespace of
/// Unix sockets, which the system releases when a process is killed. Not thread-safe.
class ClaimedProcessors {
 public:
  /// Claims one processor for each of `slots`, out of those that this thread may run on, from the
  /// last one down: the first ones serve most interrupts. Claims none if too few are free. `name`:
  /// of the claims; tests use different ones.
  explicit ClaimedProcessors(std::size_t slots, std::string_view name = kProcessorClaim);

  /// The processor of a slot; -1 if there is none, and the slot may run anywhere.
  int Of(std::size_t slot) const { return cpus_.empty() ? -1 : cpus_[slot]; }

 private:
  std::vector<int> cpus_;
  std::vector<Descriptor> claims_;
};

}  // namespace cdb::process
