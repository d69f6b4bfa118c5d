// Progress of a worker in settling the piles of its scene, before the first cycle.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace cdb::protocol {

enum class SettlingPhase : std::uint32_t {
  kNone,     ///< no pile, not started, or all at rest
  kWaiting,  ///< another run settles the same pile
  kSettling,
};

/// In the header of a recording: written by the worker, read by the runner meanwhile.
struct Settling {
  std::atomic<SettlingPhase> phase;
  std::atomic<std::uint32_t> at_rest, objects;  ///< over all piles
  std::atomic<double> seconds;  ///< time that this run has spent on settling; 0 if it found settled
                                ///< piles
};

/// `340 of 1000 objects are at rest`, `another run settles the same pile`; empty if no pile is
/// settling.
std::string SettlingText(const Settling& settling);

}  // namespace cdb::protocol
