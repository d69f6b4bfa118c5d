// How far a worker is with settling the piles of its scene, before the first cycle.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace cdb::measure {

enum class SettlingPhase : std::uint32_t {
  kNone,     ///< no pile, not yet, or all is at rest
  kWaiting,  ///< another run settles the same pile
  kSettling,
};

/// In the header of a recording: written by the worker, read by the runner while it runs.
struct Settling {
  std::atomic<SettlingPhase> phase;
  std::atomic<std::uint32_t> at_rest, objects;  ///< of the piles
  std::atomic<double> seconds;  ///< that this run has settled for; 0 where it found its piles
};

/// `340 of 1000 objects are at rest`, `another run settles the same pile`; empty where nothing
/// settles.
std::string SettlingText(const Settling& settling);

}  // namespace cdb::measure
