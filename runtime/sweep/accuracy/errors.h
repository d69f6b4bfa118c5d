// Computes the errors of a run from its samples and the true values: pure functions. The formulae
// are those of compiler/schema/metrics.h and `cdb doc accuracy`.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "compiler/schema/metrics.h"
#include "library/closed_forms/closed_form.h"
#include "runtime/protocol/samples.h"

namespace cdb::accuracy {

// The standard that the samples of a run are compared with: another run or a closed form.

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

/// The reference is trusted until its twin is this far from it: the root mean square over
/// the objects of the distance in sizes.
inline constexpr double kHorizonDistance = 0.1;

/// The first sample at which the two runs are that far apart or cannot be compared; the number of
/// samples if there is none.
std::size_t HorizonOf(const protocol::Samples& reference, const protocol::Samples& twin);

/// One value per sample. NaN where the standard has no value, for errors of a step at the start,
/// and for overlaps where there are none. `standard` may be null if no error of `errors` needs it.
/// Result: [error][sample].
std::vector<std::vector<double>> ErrorSeries(std::span<const schema::ErrorInfo* const> errors,
                                             const protocol::Samples& run,
                                             const Standard* standard);

/// Reduces the series to one number. The start, where the error is zero by definition, and the
/// samples from `end` on are left out. NaN if one of the values is; for Fold::kMeanOfSome, only if
/// all are.
double Folded(std::span<const double> series, schema::Fold fold, std::size_t end);

/// The mean distance by which the values of `from` have to be moved to become those of `to`: the
/// Wasserstein distance W1 of two distributions of equal size. The values may be in any order.
double MeanMove(std::vector<double> from, std::vector<double> to);

/// All errors that `scene` requests, as the results store them. `standard` as above. `reference`
/// and `twin` are null for a closed form; the horizon is then the end and the floor 0.
protocol::RunErrors CollectErrors(const plan::Scene& scene, const protocol::Samples& run,
                                  const Standard* standard, const protocol::Samples* reference,
                                  const protocol::Samples* twin);

}  // namespace cdb::accuracy
