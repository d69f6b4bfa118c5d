#include "library/exact/signed_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "library/exact/least_height.h"
#include "library/objects/solid_pair.h"

namespace cdb::exact {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using objects::Pose;
using objects::Solid;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Of the smaller size, but not below what rounding permits for the larger one.
constexpr double kTolerance = 1e-11, kRounding = 2e-15;
/// The angle up to which two normals count as one, rad.
constexpr double kSameWay = 1e-3;
/// Parts whose overlap is this much shallower than the deepest are no rivals.
constexpr double kRival = 0.9;

bool IsSameWay(const Vector3d& a, const Vector3d& b) {
  return a.dot(b) > 0 && a.cross(b).norm() < kSameWay;
}

/// Two bodies, with the first at the origin.
class Bodies {
 public:
  Bodies(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b)
      : a_(a),
        b_(b),
        turn_a_(pose_a.orientation.normalized().toRotationMatrix()),
        turn_b_(pose_b.orientation.normalized().toRotationMatrix()),
        origin_(pose_a.position),
        offset_(pose_b.position - pose_a.position) {
    const double size_a = a.OuterRadius(), size_b = b.OuterRadius();
    scale_ = offset_.norm() + size_a + size_b;
    tolerance_ = std::max(kTolerance * std::min(size_a, size_b), kRounding * scale_);
  }

  SignedDistance Distance(double reach) const {
    std::vector<SignedDistance> parts;
    SignedDistance least{reach, kInfinity};
    ForPieces(reach, least, [&](std::size_t piece_a, std::size_t piece_b) {
      const double farthest = least.upper > 0 ? least.upper : kRival * least.upper;
      SignedDistance part = OfPieces(piece_a, piece_b, std::min(reach, farthest));
      const double lower = std::min(least.lower, part.lower);
      if (part.upper < least.upper) least = part;
      least.lower = lower;
      if (part.upper < 0) parts.push_back(std::move(part));
    });
    for (const SignedDistance& part : parts)
      if (part.upper <= kRival * least.upper && !IsSameWay(part.normal, least.normal))
        least.rival = std::min(least.rival, part.upper);
    least.is_inside = !(least.upper < 0) && IsInCells();
    return least;
  }

  /// The shortest translation at an angle of at least `angle` from the normal: its direction, from
  /// a to b, and its length.
  LeastHeight LeastAwayFrom(const SignedDistance& distance, double angle) const {
    const ConvexPart a = PartA(distance.piece_a), b = PartB(distance.piece_b);
    HeightGoal goal;
    goal.scale = scale_;
    goal.tolerance = std::max(tolerance_, 1e-4 * distance.Depth());
    goal.avoided = -distance.normal;
    goal.largest_cosine = std::cos(angle);
    LeastHeight found = FindLeastHeight(Differences(a, b), goal);
    found.lower += a.radius() + b.radius();
    found.upper += a.radius() + b.radius();
    return found;
  }

  /// True if a translation along some direction between the normal and that of `other` is longer
  /// than both, so that they are two ways out rather than one.
  bool AreTwoWays(const SignedDistance& distance, const LeastHeight& other) const {
    const ConvexPart a = PartA(distance.piece_a), b = PartB(distance.piece_b);
    const SupportFunction support = Differences(a, b);
    const double ridge = (1 + 1e-6) * other.upper - a.radius() - b.radius();
    constexpr int kSteps = 64;
    for (int step = 1; step < kSteps; ++step) {
      const double part = static_cast<double>(step) / kSteps;
      const Vector3d between = (part * other.direction - (1 - part) * distance.normal).normalized();
      if (support(between).Value().dot(between) > ridge) return true;
    }
    return false;
  }

  /// True if the translation is one of overlapping cores: otherwise there is no other that is
  /// locally the shortest.
  bool CoresOverlap(const SignedDistance& distance) const {
    return distance.Depth() > PartA(distance.piece_a).radius() + PartB(distance.piece_b).radius();
  }

 private:
  ConvexPart PartA(std::size_t piece) const { return {a_, piece, turn_a_, Vector3d::Zero()}; }
  ConvexPart PartB(std::size_t piece) const { return {b_, piece, turn_b_, offset_}; }

  static SupportFunction Differences(const ConvexPart& a, const ConvexPart& b) {
    return [&a, &b](const Vector3d& direction) -> Difference {
      return {a.CoreSupport(direction), b.CoreSupport(-direction)};
    };
  }

  SignedDistance OfPieces(std::size_t piece_a, std::size_t piece_b, double reach) const {
    const ConvexPart a = PartA(piece_a), b = PartB(piece_b);
    const double radii = a.radius() + b.radius();
    HeightGoal goal;
    goal.scale = scale_;
    goal.tolerance = tolerance_;
    goal.enough = reach + radii;
    const LeastHeight found = FindLeastHeight(Differences(a, b), goal);
    // The search looks from a to b.
    SignedDistance result{-found.upper - radii, -found.lower - radii, -found.direction};
    result.gap = -found.height - radii;
    result.piece_a = piece_a;
    result.piece_b = piece_b;
    const Vector3d between = found.nearest.Value();
    const double apart = between.norm();
    const Vector3d way = apart > 0 ? Vector3d(between / apart) : result.normal;
    // Of the way between the cores, the part that is in the balls: all of it if they overlap.
    const double covered = radii > 0 ? std::min(1.0, apart / radii) : 0;
    result.on_a = origin_ + found.nearest.on_a - covered * a.radius() * way;
    result.on_b = origin_ + found.nearest.on_b + covered * b.radius() * way;
    return result;
  }

  /// Calls `visit` for pairs of pieces until no other could be closer than `least`, which it
  /// updates, or than `reach`.
  template <typename Visit>
  void ForPieces(double reach, const SignedDistance& least, Visit visit) const {
    if (a_.IsSurface() && b_.IsSurface()) return;
    if (!a_.IsSurface() && !b_.IsSurface()) {
      for (std::size_t i = 0; i < a_.PieceCount(); ++i)
        for (std::size_t j = 0; j < b_.PieceCount(); ++j) visit(i, j);
      return;
    }
    const bool is_a = a_.IsSurface();
    const Solid &surface = is_a ? a_ : b_, &other = is_a ? b_ : a_;
    const Matrix3d &turn = is_a ? turn_a_ : turn_b_, &other_turn = is_a ? turn_b_ : turn_a_;
    const auto with = [&](std::size_t triangle) {
      for (std::size_t piece = 0; piece < other.PieceCount(); ++piece)
        is_a ? visit(triangle, piece) : visit(piece, triangle);
      return false;
    };
    if (std::isinf(reach)) with(0);
    const Vector3d place = turn.transpose() * (is_a ? offset_ : Vector3d(-offset_));
    const objects::Box box =
        objects::Bounds(other, Eigen::Quaterniond(Matrix3d(turn.transpose() * other_turn)));
    const Vector3d room =
        Vector3d::Constant(std::max(0.0, std::min(reach, least.upper)) + 1e-12 * scale_);
    surface.compound->AnyPieceIn({place + box.lower - room, place + box.upper + room}, with);
  }

  /// Where no triangle is met, one point of a part stands for all of it.
  bool IsInCells() const {
    if (a_.IsSurface() == b_.IsSurface()) return false;
    const bool is_a = a_.IsSurface();
    return objects::AnyPieceIsInCells(is_a ? a_ : b_, is_a ? turn_a_ : turn_b_, is_a ? b_ : a_,
                                      is_a ? turn_b_ : turn_a_,
                                      is_a ? offset_ : Vector3d(-offset_));
  }

  const Solid &a_, &b_;
  const Matrix3d turn_a_, turn_b_;
  const Vector3d origin_, offset_;
  double scale_, tolerance_;
};

}  // namespace

SignedDistance DistanceOf(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b,
                          double reach) {
  return Bodies(a, pose_a, b, pose_b).Distance(reach);
}

SignedDistance DistanceOf(const Solid& a, const Pose& pose_a, const HalfSpace& b) {
  const Eigen::Quaterniond turn = pose_a.orientation.normalized();
  const Vector3d deepest = turn * a.Support(turn.conjugate() * -b.normal);
  const double distance = b.normal.dot(deepest) + (b.normal.dot(pose_a.position) - b.offset);
  const double rounding =
      kRounding * (a.OuterRadius() + pose_a.position.norm() + std::fabs(b.offset));
  SignedDistance result{distance - rounding, distance + rounding, b.normal};
  result.gap = distance;
  result.on_a = pose_a.position + deepest;
  result.on_b = result.on_a - std::max(0.0, distance) * b.normal;
  return result;
}

bool HasOneNormal(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b,
                  const SignedDistance& distance, double fraction) {
  const double depth = distance.Depth(), longest = (1 + fraction) * depth;
  if (-distance.rival * (1 + fraction) >= depth) return false;
  const Bodies bodies(a, pose_a, b, pose_b);
  if (!bodies.CoresOverlap(distance)) return true;
  // Wider and wider around the normal, until everything farther away is longer, or a different way.
  constexpr double kQuarterTurn = 1.5;
  for (double angle = kSameWay; angle < kQuarterTurn; angle *= 2) {
    const LeastHeight other = bodies.LeastAwayFrom(distance, angle);
    if (other.lower > longest) return true;
    const double cosine = -distance.normal.dot(other.direction);
    if (cosine < std::cos(kQuarterTurn) || bodies.AreTwoWays(distance, other)) return false;
  }
  return false;
}

namespace {

double LeastRadiusOfCurvature(const objects::Solid& solid) {
  if (solid.shape == objects::Shape::kCompound) return 0;
  return objects::Visit(solid, [&](auto form) {
    if constexpr (requires { form.LeastRadiusOfCurvature(solid.sides); })
      return form.LeastRadiusOfCurvature(solid.sides);
    return 0.0;
  });
}

}  // namespace

ConvexPart::ConvexPart(const objects::Solid& solid, std::size_t piece, const Eigen::Matrix3d& turn,
                       const Eigen::Vector3d& position)
    : solid_(solid),
      piece_(piece),
      turn_(turn),
      position_(position),
      radius_(LeastRadiusOfCurvature(solid)) {}

}  // namespace cdb::exact
