// The norm whose unit ball is a superellipsoid, and its farthest points, in any precision.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cdb::shapes {

/// (|u|^(2/e) + |v|^(2/e))^(e/2), without overflow.
template <typename Real>
Real SuperNorm(Real u, Real v, Real e) {
  const Real most = std::max(std::abs(u), std::abs(v)), least = std::min(std::abs(u), std::abs(v));
  if (!(most > 0)) return 0;
  return most * std::pow(1 + std::pow(least / most, 2 / e), e / 2);
}

/// The point with a SuperNorm of 1 that is farthest along (u, v), both at least 0. Any of them if
/// there are several.
template <typename Real>
std::pair<Real, Real> FarthestOfSuperNorm(Real u, Real v, Real e) {
  const Real most = std::max(u, v), least = std::min(u, v);
  // Of the lesser one, relative to the greater: with an exponent of 2 only corners are farthest.
  const Real part = most > 0 && e < 2 ? std::pow(least / most, e / (2 - e)) : Real(0);
  const Real scale = 1 / std::pow(1 + std::pow(part, 2 / e), e / 2);
  return u >= v ? std::pair(scale, part * scale) : std::pair(part * scale, scale);
}

/// With y along the axis.
template <typename Real>
Real SuperNorm(Real x, Real y, Real z, Real e1, Real e2) {
  return SuperNorm(SuperNorm(x, z, e2), y, e1);
}

/// The point with a norm of 1 that is farthest along (x, y, z).
template <typename Real>
std::array<Real, 3> FarthestOfSuperNorm(Real x, Real y, Real z, Real e1, Real e2) {
  const Real size_x = std::abs(x), size_z = std::abs(z);
  const auto [along_x, along_z] = FarthestOfSuperNorm(size_x, size_z, e2);
  const auto [across, along_y] =
      FarthestOfSuperNorm(size_x * along_x + size_z * along_z, std::abs(y), e1);
  return {std::copysign(across * along_x, x), std::copysign(along_y, y),
          std::copysign(across * along_z, z)};
}

}  // namespace cdb::shapes
