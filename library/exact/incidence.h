// Whether a point is in a triangle, or two segments meet, by the signs of products and differences
// of coordinates alone: in whatever arithmetic these are computed, and at whatever time.
#pragma once

#include <concepts>

namespace cdb::exact {

/// The signs, of points named by their indices:
///   Difference(i, j, k): of coordinate k of j minus that of i;
///   Cross(i, j, l, m, k): of component k of (j - i) x (m - l).
template <class T>
concept Signs = requires(T& signs) {
  { signs.Difference(0, 1, 2) } -> std::same_as<int>;
  { signs.Cross(0, 1, 2, 3, 0) } -> std::same_as<int>;
};

inline constexpr int kAxes = 3;

template <Signs T>
bool PointInSegment(T& signs, int point, int from, int to) {
  for (int k = 0; k < kAxes; ++k)
    if (signs.Difference(from, point, k) * signs.Difference(to, point, k) > 0) return false;
  for (int k = 0; k < kAxes; ++k)
    if (signs.Cross(from, to, from, point, k) != 0) return false;
  return true;
}

/// The four must be in one plane. The triangle may be degenerate.
template <Signs T>
bool PointInTriangle(T& signs, int point, int a, int b, int c) {
  for (int k = 0; k < kAxes; ++k) {
    const int normal = signs.Cross(a, b, a, c, k);
    if (normal == 0) continue;
    return signs.Cross(a, b, a, point, k) * normal >= 0 &&
           signs.Cross(b, c, b, point, k) * normal >= 0 &&
           signs.Cross(c, a, c, point, k) * normal >= 0;
  }
  return PointInSegment(signs, point, a, b) || PointInSegment(signs, point, b, c) ||
         PointInSegment(signs, point, c, a);
}

/// The four must be in one plane. The segments may be points.
template <Signs T>
bool SegmentsMeet(T& signs, int a, int b, int c, int d) {
  for (int k = 0; k < kAxes; ++k) {
    if (signs.Cross(a, b, c, d, k) == 0) continue;
    return signs.Cross(a, b, a, c, k) * signs.Cross(a, b, a, d, k) <= 0 &&
           signs.Cross(c, d, c, a, k) * signs.Cross(c, d, c, b, k) <= 0;
  }
  return PointInSegment(signs, a, c, d) || PointInSegment(signs, b, c, d) ||
         PointInSegment(signs, c, a, b) || PointInSegment(signs, d, a, b);
}

}  // namespace cdb::exact
