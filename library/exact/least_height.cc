#include "library/exact/least_height.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <utility>
#include <vector>

#include "library/objects/solid_pair.h"

namespace cdb::exact {
namespace {

using Eigen::Vector3d;

/// The errors of the height of a support point, as a fraction of the largest coordinate.
constexpr double kRounding = 4e-15;

/// heights[i][j] is the height of support point i along the direction of corner j.
using Heights = std::array<std::array<double, 3>, 3>;

/// Of the mean of the three points with these weights, along the corner where it is least.
double LeastOver(const Heights& heights, const Vector3d& weights) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < 3; ++j)
    least = std::min(least, weights[0] * heights[0][j] + weights[1] * heights[1][j] +
                                weights[2] * heights[2][j]);
  return least;
}

/// The weights for which LeastOver is highest, and this value: the solution of a matrix game. It is
/// attained at one point, at two where two corners are equally low, or at all three.
struct Mean {
  double height = -std::numeric_limits<double>::infinity();
  Vector3d weights;

  Mean(const Heights& heights) {
    const auto consider = [&](const Vector3d& candidate) {
      const double least = LeastOver(heights, candidate);
      if (least <= height) return;
      height = least;
      weights = candidate;
    };
    for (Eigen::Index i = 0; i < 3; ++i) consider(Vector3d::Unit(i));
    for (std::size_t out = 0; out < 3; ++out) {
      const std::size_t i = (out + 1) % 3, k = (out + 2) % 3;
      for (std::size_t j = 0; j < 3; ++j) {
        const std::size_t l = (j + 1) % 3;
        const double first = heights[i][j] - heights[i][l], second = heights[k][j] - heights[k][l];
        if (first * second >= 0) continue;
        Vector3d mixed = Vector3d::Zero();
        mixed[static_cast<Eigen::Index>(i)] = second / (second - first);
        mixed[static_cast<Eigen::Index>(k)] = first / (first - second);
        consider(mixed);
      }
    }
    // All three: orthogonal to the differences of the columns.
    Vector3d first, second;
    for (std::size_t i = 0; i < 3; ++i) {
      first[static_cast<Eigen::Index>(i)] = heights[i][0] - heights[i][1];
      second[static_cast<Eigen::Index>(i)] = heights[i][1] - heights[i][2];
    }
    const Vector3d mixed = first.cross(second), scaled = mixed / mixed.sum();
    if (scaled.minCoeff() >= 0) consider(scaled);
  }
};

class Search {
 public:
  Search(const SupportFunction& support, const HeightGoal& goal)
      : support_(support), goal_(goal), rounding_(kRounding * goal.scale) {
    best_.upper = std::numeric_limits<double>::infinity();
  }

  LeastHeight Run() {
    ApproachOrigin();
    if (!IsDone(floor_)) goal_.by_polytope ? ExpandPolytope() : BranchAndBound();
    best_.height = best_.upper;
    best_.upper += rounding_;
    best_.lower -= rounding_;
    return best_;
  }

 private:
  struct Sample {
    Vector3d direction, point;
  };
  struct Cell {
    double lower;  ///< of the heights along the directions in it
    std::array<std::uint32_t, 3> corners;
    bool operator<(const Cell& other) const { return lower > other.lower; }
  };
  static constexpr std::size_t kMaxSamples = 40'000;

  bool Counts(const Vector3d& direction) const {
    return direction.dot(goal_.avoided) <= goal_.largest_cosine;
  }

  /// The support point along a unit vector.
  Difference Try(const Vector3d& direction) {
    const Difference found = support_(direction);
    const double height = found.Value().dot(direction);
    if (height < best_.upper && Counts(direction)) {
      best_.upper = height;
      best_.direction = direction;
    }
    return found;
  }

  bool IsDone(double lower) {
    best_.lower = std::min(lower, best_.upper);
    return best_.upper - best_.lower <= goal_.tolerance || best_.upper < -goal_.enough;
  }

  /// GJK: the point of the set nearest to the origin. No height is below minus its distance.
  void ApproachOrigin() {
    std::array<Difference, 4> kept;
    objects::Simplex& simplex = simplex_;
    floor_ = -std::numeric_limits<double>::infinity();
    Vector3d towards = goal_.guess;
    constexpr int kMaxSteps = 256;
    for (int step = 0; step < kMaxSteps; ++step) {
      const Difference found = Try(towards);
      const Vector3d value = found.Value();
      for (int i = 0; i < simplex.size; ++i)
        if (kept[static_cast<std::size_t>(i)].Value() == value) return;
      if (IsDone(floor_)) return;
      kept[static_cast<std::size_t>(simplex.size)] = found;
      simplex.points[static_cast<std::size_t>(simplex.size++)] = value;
      const objects::Simplex before = simplex;
      const Vector3d nearest =
          objects::ReduceToNearest(simplex, std::numeric_limits<double>::epsilon() * goal_.scale);
      // The points that are left, in their new order.
      const std::array<Difference, 4> all = kept;
      for (int i = 0; i < simplex.size; ++i)
        for (int j = 0; j < before.size; ++j)
          if (before.points[static_cast<std::size_t>(j)] ==
              simplex.points[static_cast<std::size_t>(i)])
            kept[static_cast<std::size_t>(i)] = all[static_cast<std::size_t>(j)];
      const double distance = nearest.norm();
      if (-distance <= floor_) return;
      floor_ = -distance;
      if (!goal_.by_polytope) TakeNearest(simplex, kept, nearest);
      if (distance <= rounding_ || simplex.size == 4) return;
      towards = -nearest / distance;
    }
  }

  /// The point of the simplex at `nearest`, on both bodies.
  void TakeNearest(const objects::Simplex& simplex, const std::array<Difference, 4>& kept,
                   const Vector3d& nearest) {
    Eigen::Matrix4d points = Eigen::Matrix4d::Zero();
    for (int i = 0; i < simplex.size; ++i)
      points.col(i) << simplex.points[static_cast<std::size_t>(i)] - nearest, goal_.scale;
    const Eigen::Vector4d target(0, 0, 0, goal_.scale);
    Eigen::VectorXd weights =
        points.leftCols(simplex.size).colPivHouseholderQr().solve(target).cwiseMax(0);
    weights /= weights.sum();
    best_.nearest = {Vector3d::Zero(), Vector3d::Zero()};
    for (int i = 0; i < simplex.size; ++i) {
      best_.nearest.on_a += weights[i] * kept[static_cast<std::size_t>(i)].on_a;
      best_.nearest.on_b += weights[i] * kept[static_cast<std::size_t>(i)].on_b;
    }
  }

  std::uint32_t AddSample(const Vector3d& direction) {
    samples_.push_back({direction, Try(direction).Value()});
    return static_cast<std::uint32_t>(samples_.size() - 1);
  }

  /// Of the tolerance: a point less above a face counts as in its plane, and no face is narrower.
  static constexpr double kSeen = 0.01;

  struct Face {
    std::array<Vector3d, 3> corners;
    Vector3d normal;  ///< unit, outwards
    double height;    ///< of the face's plane
  };

  /// A flat one has no normal: returns false.
  bool AddFace(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d normal = (b - a).cross(c - a);
    const double area = normal.norm();
    const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
    if (!(area > rounding_ * longest)) return false;
    faces_.push_back({{a, b, c}, normal / area, normal.dot(a) / area});
    return true;
  }

  /// Adds points to the simplex around the origin until it is a tetrahedron, and takes its faces.
  /// Returns false if the set is flat.
  bool BeginPolytope() {
    auto& points = simplex_.points;
    if (simplex_.size < 2) return false;
    const auto add = [&](const Vector3d& way) {
      for (const double sign : {1.0, -1.0}) {
        const Vector3d point = Try(sign * way).Value();
        if (std::abs(way.dot(point - points[0])) <= 1e3 * rounding_) continue;
        points[static_cast<std::size_t>(simplex_.size++)] = point;
        return true;
      }
      return false;
    };
    if (simplex_.size == 2) {
      const Vector3d across = (points[1] - points[0]).unitOrthogonal();
      if (!add(across) && !add(across.cross(points[1] - points[0]).normalized())) return false;
    }
    const Vector3d normal = (points[1] - points[0]).cross(points[2] - points[0]);
    if (!(normal.norm() > 0)) return false;
    if (simplex_.size == 3 && !add(normal.normalized())) return false;
    if (normal.dot(points[3] - points[0]) > 0) std::swap(points[1], points[2]);
    const auto& [a, b, c, d] = points;
    return AddFace(a, b, c) && AddFace(a, d, b) && AddFace(b, d, c) && AddFace(c, d, a);
  }

  /// Of a closed convex polytope with so many corners, by Euler's formula; more: it has folded.
  static constexpr std::size_t MostFaces(int corners) {
    return 2 * static_cast<std::size_t>(corners) - 4;
  }

  /// EPA.
  void ExpandPolytope() {
    if (!BeginPolytope()) return;
    constexpr int kMostExpansions = 200;
    for (int i = 0; i < kMostExpansions && !faces_.empty(); ++i) {
      const Face lowest = *std::ranges::min_element(faces_, {}, &Face::height);
      const Vector3d point = Try(lowest.normal).Value();
      if (IsDone(lowest.height) ||
          !(lowest.normal.dot(point) > lowest.height + kSeen * goal_.tolerance) ||
          !AddCorner(point) || faces_.size() > MostFaces(i + 5))
        return;
    }
  }

  /// Replaces the faces that the point sees. Returns false if a new one is flat.
  bool AddCorner(const Vector3d& point) {
    std::vector<std::pair<Vector3d, Vector3d>> rim;
    std::erase_if(faces_, [&](const Face& face) {
      if (!(face.normal.dot(point) > face.height + kSeen * goal_.tolerance)) return false;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3d &from = face.corners[k], &to = face.corners[(k + 1) % 3];
        const auto back = std::ranges::find(rim, std::pair(to, from));
        if (back == rim.end())
          rim.emplace_back(from, to);
        else
          rim.erase(back);
      }
      return true;
    });
    return std::ranges::all_of(
        rim, [&](const auto& edge) { return AddFace(edge.first, edge.second, point); });
  }

  void BranchAndBound() {
    std::array<std::uint32_t, 6> axes;
    for (int axis = 0; axis < 3; ++axis) {
      axes[static_cast<std::size_t>(axis)] = AddSample(Vector3d::Unit(axis));
      axes[static_cast<std::size_t>(axis + 3)] = AddSample(-Vector3d::Unit(axis));
    }
    for (std::size_t octant = 0; octant < 8; ++octant)
      AddCell({axes[octant & 1 ? 3 : 0], axes[octant & 2 ? 4 : 1], axes[octant & 4 ? 5 : 2]});
    while (!cells_.empty()) {
      const Cell cell = cells_.top();
      if (IsDone(std::max(cell.lower, floor_)) || samples_.size() > kMaxSamples) return;
      cells_.pop();
      Divide(cell);
    }
    IsDone(best_.upper);
  }

  /// In two, across its longest edge.
  void Divide(const Cell& cell) {
    std::size_t longest = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (Edge(cell, i) > Edge(cell, longest)) longest = i;
    const auto [top, left, right] = std::array{
        cell.corners[longest], cell.corners[(longest + 1) % 3], cell.corners[(longest + 2) % 3]};
    const std::uint32_t middle =
        AddSample((samples_[left].direction + samples_[right].direction).normalized());
    AddCell({top, left, middle});
    AddCell({top, middle, right});
  }

  /// The squared length of the edge opposite a corner.
  double Edge(const Cell& cell, std::size_t corner) const {
    return (Corner(cell, (corner + 1) % 3).direction - Corner(cell, (corner + 2) % 3).direction)
        .squaredNorm();
  }

  const Sample& Corner(const Cell& cell, std::size_t i) const { return samples_[cell.corners[i]]; }

  void AddCell(const std::array<std::uint32_t, 3>& corners) {
    Cell cell{0, corners};
    // A cap is convex: all directions of the cell are in it.
    if (std::ranges::none_of(corners,
                             [&](std::uint32_t i) { return Counts(samples_[i].direction); }))
      return;
    cell.lower = std::max(PlaneBound(cell), GameBound(cell));
    cells_.push(cell);
  }

  /// From the mean of the three support points that is highest along all corners: a direction in
  /// the cell is a mean v of those of the corners, divided by its length, which is at most 1 and at
  /// least sqrt(1 - L^2 / 3), L the longest edge.
  double GameBound(const Cell& cell) {
    Heights heights, reversed;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        heights[i][j] = Corner(cell, i).point.dot(Corner(cell, j).direction);
        reversed[j][i] = -heights[i][j];
      }
    const double height = Mean(heights).height;
    if (height < best_.upper) {
      // The direction along which the highest of the three points is lowest.
      const Vector3d weights = Mean(reversed).weights;
      Vector3d direction = Vector3d::Zero();
      for (std::size_t j = 0; j < 3; ++j)
        direction += weights[static_cast<Eigen::Index>(j)] * Corner(cell, j).direction;
      Try(direction.normalized());
    }
    if (height >= 0) return height;
    const double longest = std::max({Edge(cell, 0), Edge(cell, 1), Edge(cell, 2)});
    return height / std::sqrt(1 - longest / 3);
  }

  /// If the foot of the perpendicular from the origin to the plane of the three support points is
  /// inside their triangle, `room` from its edges, the height along a direction at an angle t from
  /// the perpendicular is at least distance cos t + room sin t: least at one end of the range of t.
  double PlaneBound(const Cell& cell) const {
    const Vector3d &a = Corner(cell, 0).point, &b = Corner(cell, 1).point,
                   &c = Corner(cell, 2).point;
    constexpr double kNone = -std::numeric_limits<double>::infinity();
    Vector3d normal = (b - a).cross(c - a);
    const double area = normal.norm();
    if (!(area > 0)) return kNone;
    normal /= area;
    // Inwards of each edge by the order of the corners: in a sliver, which two equal support points
    // give, the side of the third corner is rounding.
    const Vector3d about = normal;
    if (normal.dot(Corner(cell, 0).direction) < 0) normal = -normal;
    double distance = std::min({normal.dot(a), normal.dot(b), normal.dot(c)});
    if (!(distance >= 0)) return kNone;
    const Vector3d foot = distance * normal;
    double room = std::numeric_limits<double>::infinity();
    for (const auto& [from, to] : {std::tie(a, b), std::tie(b, c), std::tie(c, a)})
      room = std::min(room, about.cross(to - from).normalized().dot(foot - from));
    if (!(room >= 0)) return kNone;
    double cosine = 1;
    for (std::size_t i = 0; i < 3; ++i)
      cosine = std::min(cosine, normal.dot(Corner(cell, i).direction));
    if (cosine < 0) return kNone;
    return std::min(distance, distance * cosine + room * std::sqrt(1 - cosine * cosine));
  }

  const SupportFunction& support_;
  const HeightGoal& goal_;
  const double rounding_;
  double floor_ = 0;  ///< of all heights: minus the distance of a point of the set
  LeastHeight best_;
  objects::Simplex simplex_;  ///< around the origin, if it is inside
  std::vector<Face> faces_;   ///< of the polytope
  std::vector<Sample> samples_;
  std::priority_queue<Cell> cells_;
};

}  // namespace

LeastHeight FindLeastHeight(const SupportFunction& support, const HeightGoal& goal) {
  return Search(support, goal).Run();
}

}  // namespace cdb::exact
