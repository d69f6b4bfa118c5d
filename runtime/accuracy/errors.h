// Samples and what is true to errors: pure functions. The formulae are those of compiler/metrics.h
// and `cdb doc accuracy`.
#pragma once

#include <span>
#include <vector>

#include "compiler/schema/metrics.h"
#include "runtime/accuracy/standard.h"
#include "runtime/measure/samples.h"

namespace cdb::accuracy {

/// The reference is trusted until its perturbed run is this far from it: root of the mean square
/// over objects of the distance in sizes.
inline constexpr double kHorizonDistance = 0.1;

/// The first sample at which the two are that far apart, or not to be told; as many as there are
/// where they never are.
std::size_t HorizonOf(const measure::Samples& reference, const measure::Samples& perturbed);

/// One value a sample, NaN where there is none: where the standard says nothing of it, and, of what
/// only a step makes, at the start, and, of overlaps, where there is none. `standard` may be null
/// where no error of `errors` needs it. Result: [error][sample].
std::vector<std::vector<double>> ErrorSeries(std::span<const schema::ErrorInfo* const> errors,
                                             const measure::Samples& run, const Standard* standard);

/// The series as one number; the start, where all is true, is left out, and so is `end` and what
/// follows. NaN where one of the values is, but of Fold::kMeanOfSome only where all are.
double Folded(std::span<const double> series, schema::Fold fold, std::size_t end);

/// How far the values of `from` have to be moved, on average, to be those of `to`: W1 of two
/// distributions of as many values. In any order.
double MeanMove(std::vector<double> from, std::vector<double> to);

/// All errors that `scene` asks for, as results hold them. `standard` as above; `reference` and
/// `perturbed` are null with a closed form, and then the horizon is the end and the floor 0.
measure::RunErrors CollectErrors(const plan::Scene& scene, const measure::Samples& run,
                                 const Standard* standard, const measure::Samples* reference,
                                 const measure::Samples* perturbed);

}  // namespace cdb::accuracy
