// Random scenes, from harmless to hopeless, to compare with the lints.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::tests {

struct RandomScene {
  std::string_view theme;  ///< what is swept: `stack`, `spin`
  plan::Scene scene;
};

/// `count` scenes, the themes in turn; the same for the same seed. What a theme is about is uniform
/// in its logarithm, from where nothing can go wrong to where everything does; the rest is drawn as
/// studies have it. At most 20 objects and 300 cycles, no timing, in the engine's precision.
std::vector<RandomScene> RandomScenes(std::size_t count, std::uint64_t seed);

}  // namespace cdb::tests
