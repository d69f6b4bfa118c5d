// Which processor each slot of a runner measures on.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "runtime/process/process.h"

namespace cdb::process {

inline constexpr std::string_view kProcessorClaim = "cdb-processor";

/// Processors that no other runner of this machine measures on: several `cdb run` side by side, as
/// GNU parallel starts them, must not meet on one. A claim is an address in the abstract namespace
/// of Unix sockets, which the system takes back from a process that is killed. Not for several
/// threads.
class ClaimedProcessors {
 public:
  /// One for each of `slots`, of those that this thread may run on, the last ones first: the first
  /// ones serve most interrupts. None where fewer are free. `name`: of the claims; tests have their
  /// own.
  explicit ClaimedProcessors(std::size_t slots, std::string_view name = kProcessorClaim);

  /// Of a slot; -1 where there is none: it may run anywhere.
  int Of(std::size_t slot) const { return cpus_.empty() ? -1 : cpus_[slot]; }

 private:
  std::vector<int> cpus_;
  std::vector<Descriptor> claims_;
};

}  // namespace cdb::process
