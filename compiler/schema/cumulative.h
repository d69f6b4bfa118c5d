// Cumulative distribution functions.
#pragma once

#include "compiler/schema/value.h"

namespace cdb::schema {

/// The fraction of draws that are at most x, for numbers; for any( ) and empirical( ), by weight.
/// Limits (`in 2 .. 8`) are not applied. Within 1e-12 of the true value.
double CumulativeAt(const Distribution& distribution, double x);

/// The fraction of draws in [low, high].
double ChanceWithin(const Distribution& distribution, double low, double high);

/// An interval that contains all but a few draws: the ends of a bounded distribution; for others,
/// the points beyond which draws are as rare as beyond three deviations of a normal distribution.
/// Limits are applied.
Limits UsualRange(const Distribution& distribution);

/// The regularised incomplete gamma function P(a, x), a > 0, x >= 0: by its series below a + 1, by
/// its continued fraction above. Numerical Recipes, 3rd ed., section 6.2.
double IncompleteGamma(double a, double x);

}  // namespace cdb::schema
