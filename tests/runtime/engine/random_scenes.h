// Random scenes, from harmless to hopeless, to compare with the lints.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::tests {

struct RandomScene {
  std::string_view theme;  ///< the quantity that is swept: `stack`, `spin`
  plan::Scene scene;
};

/// `count` scenes, with the themes in turn; the same for the same seed. The quantity of a theme is
/// uniform in its logarithm, from harmless values to hopeless ones; the rest is drawn as in typical
/// studies. At most 20 objects and 300 cycles, without timing, in the engine's precision.
std::vector<RandomScene> RandomScenes(std::size_t count, std::uint64_t seed);

}  // namespace cdb::tests
