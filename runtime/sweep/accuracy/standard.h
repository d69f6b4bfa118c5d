// The standard that the samples of a run are compared with: another run or a closed form.
#pragma once

#include <memory>
#include <optional>

#include "library/closed_forms/closed_form.h"
#include "runtime/protocol/samples.h"

namespace cdb::accuracy {

/// The true values at each sample of a run. Not thread-safe.
class Standard {
 public:
  virtual ~Standard() = default;
  /// Values that the standard does not define are empty.
  virtual closed_forms::Truth At(std::size_t sample) const = 0;
  virtual std::optional<double> Contacts(std::size_t sample) const = 0;
  /// Scales that errors are divided by. A scale of 0 means that the scene has none; its errors then
  /// have no value.
  virtual double energy_scale() const = 0;            ///< J
  virtual double momentum_scale() const = 0;          ///< kg m/s
  virtual double angular_momentum_scale() const = 0;  ///< kg m^2/s
};

/// The standard given by the samples of a reference run, which must outlive it. The energy scale is
/// the largest kinetic energy at any sample plus the energy that lifts every object by its own
/// size; the second term gives a stack at rest a scale too.
std::unique_ptr<Standard> StandardOf(const protocol::Samples& reference);

/// A closed form; both arguments must outlive the result. The scales of momentum are those of the
/// run.
std::unique_ptr<Standard> StandardOf(const closed_forms::ClosedForm& form,
                                     const protocol::Samples& run);

}  // namespace cdb::accuracy
