// Small scenes whose outcome follows from physics and from known properties of Bullet, and sound
// look-alikes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::tests {

/// The fault that a scene has or seems to have.
enum class Fault { kPassing, kCrushing, kLosing, kSleeping };
inline constexpr std::string_view kFaultNames[] = {"passing through", "crushing", "losing energy",
                                                   "false sleep"};

struct KnownScene {
  Fault fault;
  bool is_sound;
  std::string_view family;
  std::string_view why;  ///< the reason for its outcome
  std::string variant;   ///< what differs within the family
  plan::Scene scene;
};

/// At least twenty of each fault and as many look-alikes; in the engine's precision.
std::vector<KnownScene> KnownScenes();

}  // namespace cdb::tests
