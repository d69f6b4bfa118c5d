// The formulae of the lints: one function each, for the objects of one group.
#pragma once

#include <optional>

#include "compiler/lints/lint_facts.h"
#include "compiler/lints/lints.h"

namespace cdb::lints {

/// A number that predicts a problem; the members are those of LintNumber.
struct Estimate {
  double value = 0;
  double threshold = 1;
  double remedy = 0;
  bool open = false;
};

/// `objects` belong to `scene` and move; nullopt if the lint does not apply to them.
using Formula = std::optional<Estimate>(const SceneFacts& scene, const GroupFacts& objects);

// Loads: stacking_lints.cc.
Formula TallStack;
Formula MassRatio;
Formula NarrowFoot;
Formula Overlap;
Formula ShortRun;

// Chains: chain_lints.cc.
Formula HeavyEnd;
Formula StiffSpring;

// Contacts: contact_lints.cc.
Formula LongStep;
Formula ThinWall;
Formula FastHit;
Formula SoftContact;
Formula ThinShape;

// Motion in flight: motion_lints.cc.
Formula FastSpin;
Formula SpinDrift;
Formula HugeBox;
Formula EarlySleep;

// Rounding: precision_lints.cc.
Formula CoarsePlace;
Formula LostMotion;
Formula LostFall;
Formula HeavyMass;

/// Just below the value at which warnings begin: the target of remedies.
inline double Harmless(double threshold) { return threshold * LintNumber::kDoubtful * 0.999; }

/// The factor by which a number is too large.
inline double Excess(double value, double threshold) { return value / Harmless(threshold); }

/// The time step that makes a number harmless if the number is proportional to the step, or to its
/// square.
double ShorterStep(const SceneFacts& scene, double value, double threshold);
double ShorterStepSquared(const SceneFacts& scene, double value, double threshold);

}  // namespace cdb::lints
