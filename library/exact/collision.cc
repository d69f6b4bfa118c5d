#include "library/exact/collision.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "library/exact/incidence.h"
#include "library/exact/polynomial_roots.h"

namespace cdb::exact {
namespace {

// Moving points, in exact arithmetic.

/// The coordinates of four points as polynomials in time.
class Paths {
 public:
  explicit Paths(const MovingPoints& points) {
    for (std::size_t i = 0; i < paths_.size(); ++i)
      for (int k = 0; k < kAxes; ++k)
        paths_[i][static_cast<std::size_t>(k)] =
            Polynomial::Linear(Dyadic(points.from[i][k]), Dyadic(points.to[i][k]));
  }

  Polynomial Difference(int i, int j, int k) const { return At(j, k) - At(i, k); }
  Polynomial Cross(int i, int j, int l, int m, int k) const {
    const int next = (k + 1) % kAxes, after = (k + 2) % kAxes;
    return Difference(i, j, next) * Difference(l, m, after) -
           Difference(i, j, after) * Difference(l, m, next);
  }
  /// Six times the signed volume between the four.
  Polynomial Volume() const {
    Polynomial volume;
    for (int k = 0; k < kAxes; ++k) volume = volume + Difference(0, 1, k) * Cross(0, 2, 0, 3, k);
    return volume;
  }

 private:
  const Polynomial& At(int point, int k) const {
    return paths_[static_cast<std::size_t>(point)][static_cast<std::size_t>(k)];
  }

  std::array<std::array<Polynomial, 3>, 4> paths_;
};

class SignsAtTime {
 public:
  SignsAtTime(const Paths& paths, Time& time) : paths_(paths), time_(time) {}

  int Difference(int i, int j, int k) { return time_.SignOf(paths_.Difference(i, j, k)); }
  int Cross(int i, int j, int l, int m, int k) { return time_.SignOf(paths_.Cross(i, j, l, m, k)); }

 private:
  const Paths& paths_;
  Time& time_;
};

struct Edge {
  int from, to;
};

void Append(const Polynomial& polynomial, std::vector<Time>& times) {
  for (Time& time : RootsOf(polynomial)) times.push_back(std::move(time));
}

/// Appends times among which is that at which a point first meets an edge, if it is after 0.
void AppendMeetings(const Paths& paths, int point, const Edge& edge, std::vector<Time>& times) {
  for (int k = 0; k < kAxes; ++k) {
    const Polynomial cross = paths.Cross(edge.from, edge.to, edge.from, point, k);
    if (!cross.IsZero()) return Append(cross, times);
  }
  // It moves on the line of the edge: it comes in at an end.
  for (const int end : {edge.from, edge.to})
    for (int k = 0; k < kAxes; ++k) {
      const Polynomial way = paths.Difference(end, point, k);
      if (way.IsZero()) continue;
      Append(way, times);
      break;
    }
}

/// A point and an edge. If the four remain in one plane, the first meeting after time 0 is one of
/// such a pair.
struct Part {
  int point;
  Edge edge;
};

/// `meet`: whether the two meet, by their signs at a time at which the four are in one plane.
bool Decide(const MovingPoints& points, std::span<const Part> parts, const auto& meet) {
  const Paths paths(points);
  const Polynomial volume = paths.Volume();
  std::vector<Time> times;
  if (Time start = Time::Start(); start.SignOf(volume) == 0) times.push_back(start);
  if (!volume.IsZero())
    Append(volume, times);
  else
    for (const Part& part : parts) AppendMeetings(paths, part.point, part.edge, times);
  return std::ranges::any_of(times, [&](Time& time) {
    SignsAtTime signs(paths, time);
    return meet(signs);
  });
}

constexpr Part kPartsOfFace[] = {{0, {1, 2}}, {0, {2, 3}}, {0, {3, 1}}};
constexpr Part kPartsOfEdges[] = {{0, {2, 3}}, {1, {2, 3}}, {2, {0, 1}}, {3, {0, 1}}};

// Points at rest.

/// More than what underflow takes from a sum of products.
constexpr double kUnderflow = 1e-300;

/// The sign of a value whose error is at most `error`; none if it could be another one.
std::optional<int> SignOf(double value, double error) {
  if (value > error) return 1;
  if (-value > error) return -1;
  return std::nullopt;
}

/// The signs of six points, in double where that is certain.
class SignsAtRest {
 public:
  explicit SignsAtRest(const std::array<const Eigen::Vector3d*, 6>& points) : points_(points) {}

  int Difference(int i, int j, int k) const {
    const double from = At(i)[k], to = At(j)[k];
    return (to > from) - (to < from);
  }

  int Cross(int i, int j, int l, int m, int k) const {
    const int next = (k + 1) % kAxes, after = (k + 2) % kAxes;
    const double first = (At(j)[next] - At(i)[next]) * (At(m)[after] - At(l)[after]);
    const double second = (At(j)[after] - At(i)[after]) * (At(m)[next] - At(l)[next]);
    constexpr double kError = 0x1p-50;
    if (const auto sign =
            SignOf(first - second, kError * (std::abs(first) + std::abs(second)) + kUnderflow))
      return *sign;
    return (Way(i, j, next) * Way(l, m, after) - Way(i, j, after) * Way(l, m, next)).Sign();
  }

  /// Of the volume between four points.
  int Volume(int i, int j, int l, int m) const {
    const Eigen::Vector3d a = At(j) - At(i), b = At(l) - At(i), c = At(m) - At(i);
    double volume = 0, size = 0;
    for (int k = 0; k < kAxes; ++k) {
      const int next = (k + 1) % kAxes, after = (k + 2) % kAxes;
      const double first = b[next] * c[after], second = b[after] * c[next];
      volume += a[k] * (first - second);
      size += std::abs(a[k]) * (std::abs(first) + std::abs(second) + kUnderflow);
    }
    constexpr double kError = 0x1p-49;
    if (size > 0x1p53 * kUnderflow)
      if (const auto sign = SignOf(volume, kError * size)) return *sign;
    Dyadic sum;
    for (int k = 0; k < kAxes; ++k) {
      const int next = (k + 1) % kAxes, after = (k + 2) % kAxes;
      sum = sum + Way(i, j, k) *
                      (Way(i, l, next) * Way(i, m, after) - Way(i, l, after) * Way(i, m, next));
    }
    return sum.Sign();
  }

 private:
  const Eigen::Vector3d& At(int i) const { return *points_[static_cast<std::size_t>(i)]; }
  Dyadic Way(int i, int j, int k) const { return Dyadic(At(j)[k]) - Dyadic(At(i)[k]); }

  std::array<const Eigen::Vector3d*, 6> points_;
};

bool SegmentMeetsTriangle(SignsAtRest& signs, int from, int to, int a, int b, int c) {
  const int side_from = signs.Volume(a, b, c, from), side_to = signs.Volume(a, b, c, to);
  if (side_from * side_to > 0) return false;
  if (side_from == 0 && side_to == 0) {
    // The segment lies in its plane, or the triangle has none.
    const auto meets = [&](int start, int end) {
      return signs.Volume(from, to, start, end) == 0 && SegmentsMeet(signs, from, to, start, end);
    };
    return PointInTriangle(signs, from, a, b, c) || PointInTriangle(signs, to, a, b, c) ||
           meets(a, b) || meets(b, c) || meets(c, a);
  }
  // It crosses the plane in one point.
  const int ab = signs.Volume(from, to, a, b), bc = signs.Volume(from, to, b, c),
            ca = signs.Volume(from, to, c, a);
  return std::min({ab, bc, ca}) >= 0 || std::max({ab, bc, ca}) <= 0;
}

}  // namespace

bool DecideVertexFace(const MovingPoints& points) {
  return Decide(points, kPartsOfFace,
                [](SignsAtTime& signs) { return PointInTriangle(signs, 0, 1, 2, 3); });
}

bool DecideEdges(const MovingPoints& points) {
  return Decide(points, kPartsOfEdges,
                [](SignsAtTime& signs) { return SegmentsMeet(signs, 0, 1, 2, 3); });
}

bool VertexMeetsFace(const MovingPoints& points) {
  const std::optional<bool> filtered = FilterVertexFace(points);
  return filtered ? *filtered : DecideVertexFace(points);
}

bool EdgesMeet(const MovingPoints& points) {
  const std::optional<bool> filtered = FilterEdges(points);
  return filtered ? *filtered : DecideEdges(points);
}

bool TrianglesMeet(const std::array<Eigen::Vector3d, 3>& a,
                   const std::array<Eigen::Vector3d, 3>& b) {
  SignsAtRest signs({&a[0], &a[1], &a[2], &b[0], &b[1], &b[2]});
  const auto is_beside = [&](int first, int second) {
    const int side = signs.Volume(first, first + 1, first + 2, second);
    return side != 0 && side == signs.Volume(first, first + 1, first + 2, second + 1) &&
           side == signs.Volume(first, first + 1, first + 2, second + 2);
  };
  if (is_beside(0, 3) || is_beside(3, 0)) return false;
  // The region that they share ends at an edge of one of them.
  for (int i = 0; i < kAxes; ++i) {
    const int next = (i + 1) % kAxes;
    if (SegmentMeetsTriangle(signs, i, next, 3, 4, 5) ||
        SegmentMeetsTriangle(signs, 3 + i, 3 + next, 0, 1, 2))
      return true;
  }
  return false;
}

}  // namespace cdb::exact
