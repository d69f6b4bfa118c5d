// The filters of moving points, in double.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "library/exact/collision.h"

namespace cdb::exact {
namespace {

using Eigen::Vector3d;

/// Three vectors between points, each at the start and at the end of the step.
struct Vectors {
  Vector3d from[3], to[3];

  double Largest() const {
    double largest = 0;
    for (int i = 0; i < 3; ++i)
      largest = std::max({largest, from[i].cwiseAbs().maxCoeff(), to[i].cwiseAbs().maxCoeff()});
    return largest;
  }
};

/// Bernstein coefficients over an interval of time.
using Cubic = std::array<double, 4>;
using Quadratic = std::array<double, 3>;

/// One component of the cross products of the vectors 0 and 1, 1 and 2, 2 and 0, and their
/// determinant.
struct Piece {
  Cubic volume;
  std::array<Quadratic, 3> areas;
};

/// With M the largest coordinate of the vectors and u the rounding of a double, the error of a
/// coefficient of an area, at most 2 M^2, is at most 10 u M^2, and 4 u M^2 more for each halving,
/// which rounds two means; that of a sum of two areas, twice that and 4 u M^2. The error of a
/// coefficient of the volume, at most 6 M^3, is at most 64 u M^3, and 18 u M^3 more for each
/// halving. Over kMostHalvings, these are 104 u M^2 and 244 u M^3.
constexpr double kRoundingUnit = 0x1p-53;
constexpr double kErrorOfArea = 128 * kRoundingUnit;
constexpr double kErrorOfVolume = 512 * kRoundingUnit;
constexpr int kMostHalvings = 10;
/// Where most of the time is spent for nothing, because all is in one plane.
constexpr int kMostPieces = 48;
/// Beyond, products of three can be infinite or lose digits.
constexpr double kLeastVector = 1e-90, kMostVector = 1e90;

/// 1 or -1 if all coefficients certainly have this sign, otherwise 0.
template <std::size_t n>
int SignOf(const std::array<double, n>& coefficients, double error) {
  double least = coefficients[0], most = coefficients[0];
  for (std::size_t i = 1; i < n; ++i) {
    least = std::min(least, coefficients[i]);
    most = std::max(most, coefficients[i]);
  }
  return least > error ? 1 : most < -error ? -1 : 0;
}

/// De Casteljau's algorithm at the middle.
template <std::size_t n>
void Halve(const std::array<double, n>& whole, std::array<double, n>& first,
           std::array<double, n>& second) {
  second = whole;
  for (std::size_t step = 0; step < n; ++step) {
    first[step] = second[0];
    for (std::size_t i = 0; i + step + 1 < n; ++i) second[i] = 0.5 * (second[i] + second[i + 1]);
  }
}

template <std::size_t n>
std::array<double, n> operator+(std::array<double, n> a, const std::array<double, n>& b) {
  for (std::size_t i = 0; i < n; ++i) a[i] += b[i];
  return a;
}
template <std::size_t n>
std::array<double, n> operator-(std::array<double, n> a, const std::array<double, n>& b) {
  for (std::size_t i = 0; i < n; ++i) a[i] -= b[i];
  return a;
}

Cubic VolumeOf(const Vectors& v) {
  const Vector3d first = v.from[1].cross(v.from[2]), last = v.to[1].cross(v.to[2]),
                 mixed = v.from[1].cross(v.to[2]) + v.to[1].cross(v.from[2]);
  return {v.from[0].dot(first), (v.from[0].dot(mixed) + v.to[0].dot(first)) / 3,
          (v.from[0].dot(last) + v.to[0].dot(mixed)) / 3, v.to[0].dot(last)};
}

Quadratic AreaOf(const Vectors& v, int a, int b, int k) {
  const int next = (k + 1) % 3, after = (k + 2) % 3;
  const auto cross = [&](const Vector3d& x, const Vector3d& y) {
    return x[next] * y[after] - x[after] * y[next];
  };
  return {cross(v.from[a], v.from[b]),
          0.5 * (cross(v.from[a], v.to[b]) + cross(v.to[a], v.from[b])), cross(v.to[a], v.to[b])};
}

/// What is certain of the projection in a piece.
enum class Inside { kNo, kUnknown, kYes };

/// `inside`: of the areas of a piece, by their error. `normal`: of the plane, about.
std::optional<bool> Filter(const Vectors& vectors, const Vector3d& normal, const auto& inside) {
  const double largest = vectors.Largest();
  if (!(largest > kLeastVector && largest < kMostVector)) return std::nullopt;
  const double area_error = kErrorOfArea * largest * largest;
  const double volume_error = kErrorOfVolume * largest * largest * largest;
  std::array<Piece, kMostHalvings + 1> pieces;
  std::array<int, kMostHalvings + 1> halvings;
  pieces[0].volume = VolumeOf(vectors);
  if (SignOf(pieces[0].volume, volume_error) != 0) return false;
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  for (int i = 0; i < 3; ++i)
    pieces[0].areas[static_cast<std::size_t>(i)] = AreaOf(vectors, i, (i + 1) % 3, axis);
  halvings[0] = 0;
  bool is_certain = true;
  std::size_t count = 1;
  for (int visited = 0; count > 0; ++visited) {
    const Piece piece = pieces[--count];
    const int depth = halvings[count];
    if (SignOf(piece.volume, volume_error) != 0) continue;
    const Inside is_inside = inside(piece.areas, area_error);
    if (is_inside == Inside::kNo) continue;
    const double start = piece.volume.front(), end = piece.volume.back();
    if (is_inside == Inside::kYes && std::min(start, end) < -volume_error &&
        std::max(start, end) > volume_error)
      return true;
    if (depth == kMostHalvings || visited >= kMostPieces) {
      is_certain = false;
      continue;
    }
    Piece &first = pieces[count], &second = pieces[count + 1];
    Halve(piece.volume, second.volume, first.volume);
    for (std::size_t i = 0; i < piece.areas.size(); ++i)
      Halve(piece.areas[i], second.areas[i], first.areas[i]);
    halvings[count] = halvings[count + 1] = depth + 1;
    count += 2;
  }
  if (!is_certain) return std::nullopt;
  return false;
}

}  // namespace

std::optional<bool> FilterVertexFace(const MovingPoints& points) {
  Vectors to_corners;
  for (std::size_t i = 0; i < 3; ++i) {
    to_corners.from[i] = points.from[i + 1] - points.from[0];
    to_corners.to[i] = points.to[i + 1] - points.to[0];
  }
  const auto normal_of = [](const FourPoints& at) {
    return Vector3d((at[2] - at[1]).cross(at[3] - at[1]));
  };
  return Filter(to_corners, normal_of(points.from) + normal_of(points.to),
                [](const std::array<Quadratic, 3>& areas, double error) {
                  const int a = SignOf(areas[0], error), b = SignOf(areas[1], error),
                            c = SignOf(areas[2], error);
                  if (std::min({a, b, c}) < 0 && std::max({a, b, c}) > 0) return Inside::kNo;
                  return a != 0 && a == b && b == c ? Inside::kYes : Inside::kUnknown;
                });
}

std::optional<bool> FilterEdges(const MovingPoints& points) {
  // The edges, and the way from the start of the first to that of the second.
  Vectors vectors;
  const auto set = [](const FourPoints& at, Vector3d* to) {
    to[0] = at[1] - at[0];
    to[1] = at[3] - at[2];
    to[2] = at[2] - at[0];
  };
  set(points.from, vectors.from);
  set(points.to, vectors.to);
  return Filter(vectors,
                vectors.from[0].cross(vectors.from[1]) + vectors.to[0].cross(vectors.to[1]),
                [](const std::array<Quadratic, 3>& areas, double error) {
                  // Of the ends of one edge, seen from the other.
                  const auto& [both, second, first] = areas;
                  const int c = SignOf(first, error), d = SignOf(first - both, error),
                            a = SignOf(second, error), b = SignOf(second + both, error);
                  if (c * d > 0 || a * b > 0) return Inside::kNo;
                  return c * d < 0 && a * b < 0 ? Inside::kYes : Inside::kUnknown;
                });
}

}  // namespace cdb::exact
