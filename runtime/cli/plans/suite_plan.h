// The plans of the standard suite.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/figures/suite.h"

namespace cdb::plans {

/// The choices for a run of the suite. Cycles, repeats and seeds are fixed.
struct SuiteChoice {
  bool is_long = false;                    ///< kLongRepeats, and the seeds of kLongSeeds
  std::optional<std::uint64_t> seed = {};  ///< a fresh seed in place of the published ones
  /// Detectors in addition to those of the suite, in scenes that sweep detectors.
  std::vector<std::string> detectors = {};
  std::vector<std::string> plugins = {};  ///< libraries that contain them
};

inline constexpr std::uint64_t kLongRepeats = 11;
inline constexpr std::uint64_t kLongSeeds[] = {0xAAAAAAAAAA, 1, 2};

/// The plan of a scene of the library of scenarios; files in the current folder are ignored. Throws
/// CommandError, also if the library has no such scene.
plan::Plan StandardPlan(const figures::StandardScene& scene, const SuiteChoice& choice);

}  // namespace cdb::plans
