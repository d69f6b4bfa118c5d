// Vectors and rotations in double, for the narrow phase.
#pragma once

#include <cmath>

#include "library/detectors/detector.h"

namespace cdb::narrow {

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double Dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double SquaredNorm(const Vec3& a) { return Dot(a, a); }
inline double Norm(const Vec3& a) { return std::sqrt(Dot(a, a)); }

/// A unit vector across `a`, which is not zero.
inline Vec3 UnitAcross(const Vec3& a) {
  const Vec3 across = std::abs(a.x) < std::abs(a.z) ? Vec3{0, a.z, -a.y} : Vec3{-a.y, a.x, 0};
  return 1 / Norm(across) * across;
}

/// The unit vector along `a`, or y if that is too short to have a direction.
inline Vec3 Normalized(const Vec3& a) {
  const double length = Norm(a);
  return length > 1e-150 ? 1 / length * a : Vec3{0, 1, 0};
}

/// A rotation, by its columns.
struct Rotation {
  Vec3 x, y, z;
};
inline Vec3 operator*(const Rotation& r, const Vec3& v) {
  return v.x * r.x + v.y * r.y + v.z * r.z;
}
/// The product of the transposed rotation.
inline Vec3 Inverse(const Rotation& r, const Vec3& v) {
  return {Dot(r.x, v), Dot(r.y, v), Dot(r.z, v)};
}
inline Rotation AxesOf(const Pose& pose) { return {pose.x, pose.y, pose.z}; }

}  // namespace cdb::narrow
