#include "runtime/engine/probes/soundness.h"

#include <limits>

#include "compiler/analysis/expectation.h"

namespace cdb::probes {

Soundness::Soundness(const plan::Scene& scene, world::Engine& engine,
                     std::span<const double> least_sides)
    : engine_(engine),
      passes_(engine),
      presses_(engine, least_sides,
               analysis::ExpectationOf(scene) == analysis::Expectation::kDriven),
      sleepers_(engine) {
  if (analysis::OnlyContactsTakeEnergy(scene)) audit_.emplace(engine);
}

void Soundness::Begin(double kinetic, double energy) {
  ReadStates(engine_, before_);
  if (audit_) audit_->Begin(kinetic, energy);
}

Soundness::Seen Soundness::After(double kinetic, double energy) {
  ReadStates(engine_, now_);
  const PressWatch::Seen pressed = presses_.After();
  const Seen seen{passes_.After(before_, now_), pressed.pressed, pressed.inverted,
                  sleepers_.After(before_, now_),
                  audit_ ? audit_->After(before_, now_, kinetic, energy)
                         : std::numeric_limits<double>::quiet_NaN()};
  before_.swap(now_);
  return seen;
}

}  // namespace cdb::probes
