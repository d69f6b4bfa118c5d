// The plans of the standard suite.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/suite/standard.h"

namespace cdb::plans {

/// What a run of the suite may choose. Cycles, repeats and seeds are not among it.
struct SuiteChoice {
  bool is_long = false;                    ///< kLongRepeats, and the seeds of kLongSeeds
  std::optional<std::uint64_t> seed = {};  ///< a fresh one in place of the published ones
  /// Beside those of the suite, in scenes that sweep detectors.
  std::vector<std::string> detectors = {};
  std::vector<std::string> plugins = {};  ///< libraries that bring them
};

inline constexpr std::uint64_t kLongRepeats = 11;
inline constexpr std::uint64_t kLongSeeds[] = {0xAAAAAAAAAA, 1, 2};

/// The scene comes from the library of scenarios, whatever lies in the current folder. Throws
/// CommandError, also where the library holds no such scene.
plan::Plan StandardPlan(const suite::StandardScene& scene, const SuiteChoice& choice);

}  // namespace cdb::plans
