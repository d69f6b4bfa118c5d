// The part of a line inside a convex solid, in closed form, in single or double precision.
//
// A line is the points from + t along, of which `along` need not be a unit vector. Solids are in
// their own axes, with the centre of mass at the origin and half extents `half`, as
// library/objects/solid.h has them. The discriminant of a round surface is computed at the point of
// the line nearest to the middle, as the textbook form loses the digits of a body that is small and
// far away (Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection",
// Ray Tracing Gems, 2019). Threads: any.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "library/objects/shapes/super_norm.h"

namespace cdb::queries {

template <typename Real>
using Vec = Eigen::Matrix<Real, 3, 1>;

/// {t : enter <= t <= leave}; none if enter > leave.
template <typename Real>
struct Chord {
  static constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
  Real enter = -kInfinity, leave = kInfinity;
  /// Of the surface at `enter`, outwards; not of unit length.
  Vec<Real> normal = Vec<Real>::Zero();

  static Chord None() { return {kInfinity, -kInfinity, Vec<Real>::Zero()}; }
  bool IsNone() const { return !(enter <= leave); }

  /// Cuts it by the half space {x : normal . x <= offset}.
  void Cut(const Vec<Real>& from, const Vec<Real>& along, const Vec<Real>& of_normal, Real offset) {
    const Real distance = offset - of_normal.dot(from), speed = of_normal.dot(along);
    if (speed == 0) {
      if (distance < 0) *this = None();
      return;
    }
    const Real t = distance / speed;
    if (speed < 0) {
      if (t > enter) enter = t, normal = of_normal;
    } else {
      leave = std::min(leave, t);
    }
  }
};

/// Of the ball of radius 1 about the origin; its normal at `enter` is not set.
template <typename Real>
Chord<Real> BallChord(const Vec<Real>& from, const Vec<Real>& along) {
  const Real square = along.squaredNorm();
  if (!(square > 0)) return from.squaredNorm() <= 1 ? Chord<Real>() : Chord<Real>::None();
  const Real middle = -from.dot(along) / square;
  const Real inside = 1 - (from + middle * along).squaredNorm();
  if (!(inside >= 0)) return Chord<Real>::None();
  const Real half = std::sqrt(inside / square);
  return {middle - half, middle + half, Vec<Real>::Zero()};
}

template <typename Real>
Chord<Real> EllipsoidChord(const Vec<Real>& half, const Vec<Real>& from, const Vec<Real>& along) {
  const Vec<Real> start = from.cwiseQuotient(half), step = along.cwiseQuotient(half);
  Chord<Real> chord = BallChord(start, step);
  if (!chord.IsNone()) chord.normal = (start + chord.enter * step).cwiseQuotient(half);
  return chord;
}

template <typename Real>
Chord<Real> CuboidChord(const Vec<Real>& half, const Vec<Real>& from, const Vec<Real>& along) {
  Chord<Real> chord;
  for (int axis = 0; axis < 3; ++axis)
    for (const Real sign : {Real(-1), Real(1)})
      chord.Cut(from, along, sign * Vec<Real>::Unit(axis), half[axis]);
  return chord;
}

template <typename Real>
Chord<Real> CylinderChord(const Vec<Real>& half, const Vec<Real>& from, const Vec<Real>& along) {
  const Vec<Real> start(from.x() / half.x(), 0, from.z() / half.z()),
      step(along.x() / half.x(), 0, along.z() / half.z());
  Chord<Real> chord = BallChord(start, step);
  if (chord.IsNone()) return chord;
  if (std::isfinite(chord.enter)) {
    const Vec<Real> at = start + chord.enter * step;
    chord.normal = Vec<Real>(at.x() / half.x(), 0, at.z() / half.z());
  }
  for (const Real sign : {Real(-1), Real(1)})
    chord.Cut(from, along, Vec<Real>(0, sign, 0), half.y());
  return chord;
}

/// Its tip is 3/2 of half.y() above the centre of mass, its base 1/2 below.
template <typename Real>
Chord<Real> ConeChord(const Vec<Real>& half, const Vec<Real>& from, const Vec<Real>& along) {
  // At a fraction `left` of the height below the tip, the section has radius `left`.
  const Real height = 2 * half.y();
  const Real left = Real(0.75) - from.y() / height, change = -along.y() / height;
  const Vec<Real> start(from.x() / half.x(), 0, from.z() / half.z()),
      step(along.x() / half.x(), 0, along.z() / half.z());
  // a t^2 + 2 b t + c <= 0.
  const Real a = step.squaredNorm() - change * change, b = start.dot(step) - left * change,
             c = start.squaredNorm() - left * left;
  Chord<Real> chord;
  if (a > 0) {
    const Real middle = -b / a;
    const Vec<Real> across = start + middle * step;
    const Real depth = left + middle * change;
    const Real inside = depth * depth - across.squaredNorm();
    if (!(inside >= 0) || depth < 0) return Chord<Real>::None();
    const Real root = std::sqrt(inside / a);
    chord = {middle - root, middle + root, Vec<Real>::Zero()};
  } else if (a < 0) {
    // Within both cones, the lower one and its mirror image above the tip: the part below counts.
    const Real root = std::sqrt(std::max(b * b - a * c, Real(0)));
    // Computed so that no digits cancel.
    const Real sum = -(b + std::copysign(root, b));
    const Real one = sum / a, other = sum != 0 ? c / sum : one;
    if (change > 0)
      chord.enter = std::max(one, other);
    else
      chord.leave = std::min(one, other);
  } else if (b != 0) {
    (b < 0 ? chord.enter : chord.leave) = -c / (2 * b);
  } else if (c > 0) {
    return Chord<Real>::None();
  }
  if (std::isfinite(chord.enter)) {
    const Vec<Real> at = start + chord.enter * step;
    const Real depth = left + chord.enter * change;
    chord.normal = Vec<Real>(at.x() / half.x(), depth / height, at.z() / half.z());
  }
  chord.Cut(from, along, Vec<Real>(0, -1, 0), half.y() / 2);
  // Above the tip there is only the mirror image.
  chord.Cut(from, along, Vec<Real>(0, 1, 0), Real(1.5) * half.y());
  return chord;
}

/// `straight`: half height of the straight part (shapes::Capsule).
template <typename Real>
Chord<Real> CapsuleChord(const Vec<Real>& half, Real straight, const Vec<Real>& from,
                         const Vec<Real>& along) {
  const Vec<Real> scale(half.x(), half.y() - straight, half.z());
  const Vec<Real> start = from.cwiseQuotient(scale), step = along.cwiseQuotient(scale);
  const Real end = straight / scale.y();
  // The union of three convex parts is convex, so that its chord reaches from the first to the
  // last.
  Chord<Real> side =
      BallChord(Vec<Real>(start.x(), 0, start.z()), Vec<Real>(step.x(), 0, step.z()));
  for (const Real sign : {Real(-1), Real(1)})
    if (!side.IsNone()) side.Cut(start, step, Vec<Real>(0, sign, 0), end);
  Chord<Real> chord = side;
  for (const Real sign : {Real(-1), Real(1)}) {
    const Chord<Real> cap = BallChord(Vec<Real>(start - Vec<Real>(0, sign * end, 0)), step);
    if (cap.IsNone()) continue;
    if (chord.IsNone()) {
      chord = cap;
      continue;
    }
    chord.enter = std::min(chord.enter, cap.enter);
    chord.leave = std::max(chord.leave, cap.leave);
  }
  if (chord.IsNone()) return chord;
  Vec<Real> at = start + chord.enter * step;
  at.y() -= std::clamp(at.y(), -end, end);
  chord.normal = at.cwiseQuotient(scale);
  return chord;
}

template <typename Real>
Chord<Real> TetrahedronChord(const Vec<Real>& half, const Vec<Real>& from, const Vec<Real>& along) {
  Chord<Real> chord;
  for (const Vec<Real>& normal :
       {Vec<Real>(1, 1, -1), Vec<Real>(1, -1, 1), Vec<Real>(-1, 1, 1), Vec<Real>(-1, -1, -1)})
    chord.Cut(from, along, normal.cwiseQuotient(half), Real(1));
  return chord;
}

/// By Newton's method from both sides: the norm of a superellipsoid is convex along the line, so
/// that the steps never pass an end of the chord.
template <typename Real>
Chord<Real> SuperellipsoidChord(const Vec<Real>& half, Real e1, Real e2, const Vec<Real>& from,
                                const Vec<Real>& along) {
  const Vec<Real> start = from.cwiseQuotient(half), step = along.cwiseQuotient(half);
  const auto norm = [&](const Vec<Real>& at) {
    return shapes::SuperNorm(at.x(), at.y(), at.z(), e1, e2);
  };
  // Of the box around it.
  Chord<Real> chord = CuboidChord(Vec<Real>(Vec<Real>::Ones()), start, step);
  if (chord.IsNone() || !std::isfinite(chord.enter)) {
    if (chord.IsNone() || !(norm(start) <= 1)) return Chord<Real>::None();
    return chord;
  }
  // The gradient of the norm is the point of the dual ball, whose exponents are 2 - e.
  const auto gradient = [&](const Vec<Real>& at) {
    const auto [x, y, z] = shapes::FarthestOfSuperNorm(at.x(), at.y(), at.z(), 2 - e1, 2 - e2);
    return Vec<Real>(x, y, z);
  };
  const auto approach = [&](Real t, Real sign) {
    constexpr int kMostSteps = 200;
    for (int i = 0; i < kMostSteps; ++i) {
      const Vec<Real> at = start + t * step;
      const Real over = norm(at) - 1;
      if (!(over > 0)) break;
      const Real slope = gradient(at).dot(step) * sign;
      if (!(slope < 0)) return Chord<Real>::kInfinity;
      const Real next = t - sign * over / slope;
      if (next == t) break;
      t = next;
    }
    return t;
  };
  const Real enter = approach(chord.enter, 1), leave = approach(chord.leave, -1);
  if (!std::isfinite(enter) || !std::isfinite(leave) || !(enter <= leave))
    return Chord<Real>::None();
  chord.enter = enter;
  chord.leave = leave;
  chord.normal = gradient(Vec<Real>(start + enter * step)).cwiseQuotient(half);
  return chord;
}

/// A triangle, seen from either side: enter and leave are the same. `margin` receives the least
/// barycentric coordinate. Source: Ericson, Real-Time Collision Detection, 2005, section 5.3.6.
template <typename Real>
Chord<Real> TriangleChord(const Vec<Real>& a, const Vec<Real>& b, const Vec<Real>& c,
                          const Vec<Real>& from, const Vec<Real>& along, Real* margin = nullptr) {
  const Vec<Real> ab = b - a, ac = c - a;
  const Vec<Real> normal = ab.cross(ac);
  const Real speed = -normal.dot(along);
  if (speed == 0) return Chord<Real>::None();
  const Vec<Real> to_start = from - a;
  const Vec<Real> side = to_start.cross(along);
  const Real v = ac.dot(side) / speed, w = -ab.dot(side) / speed;
  const Real least = std::min({v, w, 1 - v - w});
  if (margin != nullptr) *margin = least;
  if (!(least >= 0)) return Chord<Real>::None();
  const Real t = normal.dot(to_start) / speed;
  return {t, t, speed > 0 ? normal : Vec<Real>(-normal)};
}

}  // namespace cdb::queries
