// What a run's samples are compared with: another run's, or a closed form.
#pragma once

#include <memory>
#include <optional>

#include "library/closed_forms/closed_form.h"
#include "runtime/measure/samples.h"

namespace cdb::accuracy {

/// What is true at each sample of a run. Not for several threads.
class Standard {
 public:
  virtual ~Standard() = default;
  /// What it says nothing of is empty.
  virtual closed_forms::Truth At(std::size_t sample) const = 0;
  virtual std::optional<double> Contacts(std::size_t sample) const = 0;
  /// What errors are divided by; 0 where the scene has none, and then they have no value.
  virtual double energy_scale() const = 0;            ///< J
  virtual double momentum_scale() const = 0;          ///< kg m/s
  virtual double angular_momentum_scale() const = 0;  ///< kg m^2/s
};

/// The samples of a reference run, which outlive it. The energy of its scene is the most kinetic
/// energy that it has at a sample, and what lifts every object by its own size: so that a stack at
/// rest has one too.
std::unique_ptr<Standard> StandardOf(const measure::Samples& reference);

/// A closed form; both outlive it. Scales of momentum are the run's own.
std::unique_ptr<Standard> StandardOf(const closed_forms::ClosedForm& form,
                                     const measure::Samples& run);

}  // namespace cdb::accuracy
