// Distribution functions: what part of the draws is at most x.
#pragma once

#include "compiler/schema/value.h"

namespace cdb::schema {

/// Of numbers; of any( ) and empirical( ), by weight. Limits (`in 2 .. 8`) are not applied. Within
/// 1e-12 of the true value.
double CumulativeAt(const Distribution& distribution, double x);

/// The part of the draws in [low, high].
double ChanceWithin(const Distribution& distribution, double low, double high);

/// Numbers that all but a few draws lie between: the ends of what is bounded; of the others, those
/// that a draw is beyond as rarely as one of a normal distribution is beyond three deviations.
/// Limits are applied.
Limits UsualRange(const Distribution& distribution);

/// The regularised incomplete gamma function P(a, x), a > 0, x >= 0: by its series below a + 1, by
/// its continued fraction above. Numerical Recipes, 3rd ed., section 6.2.
double IncompleteGamma(double a, double x);

}  // namespace cdb::schema
