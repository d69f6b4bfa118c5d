// Main effects and interactions of several parameters on a figure, from points that sample all of
// them at once.
//
// The logarithm of the figure is fitted by least squares with polynomials that are orthonormal over
// the ranges (Legendre): degrees 1 and 2 of each parameter, on the scale on which it was sampled,
// and the products of the first degrees of two. The shares of the variance are then sums of squares
// of coefficients (Sudret 2008, Global sensitivity analysis using polynomial chaos expansions,
// Reliability Engineering & System Safety 93), and the error of an effect is that of its
// coefficient by the residuals. With fewer than two points for each coefficient, products are left
// out first, then degree 2.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::effects {

/// Of one parameter, averaged over the others.
struct MainEffect {
  std::size_t parameter;  ///< index
  double log_ratio;       ///< of the figure at the end of the range to that at its start
  double error;           ///< standard error of log_ratio
  double share;           ///< of the variance of the logarithm
};
/// Of two parameters, beyond their main effects.
struct Interaction {
  std::size_t a, b;
  double share;
};
struct SampledEffects {
  std::vector<MainEffect> mains;          ///< the largest share first
  std::vector<Interaction> interactions;  ///< the largest share first; empty if left out
  bool has_interactions = false;
  double unexplained = 0;  ///< the share of neither
  std::size_t points = 0;
  double freedom = 0;  ///< degrees of freedom of the errors
};

/// `figures`: at each point, above 0, or NaN for a point that is left out. Nullopt with fewer than
/// two points for each parameter and one more, or if the figure does not vary. Threads: any.
std::optional<SampledEffects> FitEffects(std::span<const plan::Coordinates> parameters,
                                         std::span<const double> figures);

}  // namespace cdb::effects
