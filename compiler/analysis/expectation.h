// The physical behaviour expected of a scene, which a verdict compares with its motion.
#pragma once

#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

enum class Expectation {
  kAnything,  ///< nothing except that it must not gain energy
  kRest,      ///< to stay where it is: a stack
  kEnergy,    ///< to keep its energy: no friction, no damping, elastic bounces
  kDriven,    ///< a schedule moves it, so that its energy proves nothing
};

/// `anything`, `rest`, `energy`, `driven`.
std::string_view ExpectationName(Expectation expectation);

/// From the parameter `expect`; if that is `auto`, from the settings of the scene. A scene with a
/// schedule is always driven.
Expectation ExpectationOf(const plan::Scene& scene);

/// True if nothing takes energy from objects without contacts: no damping, no schedule.
bool FliesFreely(const plan::Scene& scene);

/// True if only contacts can take energy from the scene, by friction and by inelastic bounces: it
/// flies freely, nothing resists rolling, contacts are rigid, and `expect` is not `anything`.
bool OnlyContactsTakeEnergy(const plan::Scene& scene);

}  // namespace cdb::analysis
