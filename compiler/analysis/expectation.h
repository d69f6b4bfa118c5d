// What a scene ought to do by physics, so that a verdict can say whether it did.
#pragma once

#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

enum class Expectation {
  kAnything,  ///< no more than not to gain energy
  kRest,      ///< to stand where it stands: a stack
  kEnergy,    ///< to keep its energy: nothing rubs, nothing is damped, bounces are elastic
  kDriven,    ///< a schedule moves it, so that energy says nothing
};

/// `anything`, `rest`, `energy`, `driven`.
std::string_view ExpectationName(Expectation expectation);

/// By the parameter `expect`; where that is `auto`, by the scene's own numbers. A schedule always
/// drives.
Expectation ExpectationOf(const plan::Scene& scene);

/// Nothing in the scene takes energy from objects that touch nothing: no damping, no schedule.
bool FliesFreely(const plan::Scene& scene);

/// Only contacts can take energy from the scene, by friction and by bounces that are not elastic:
/// it flies freely, nothing resists rolling, contacts are rigid, and `expect` does not say
/// `anything`.
bool OnlyContactsTakeEnergy(const plan::Scene& scene);

}  // namespace cdb::analysis
