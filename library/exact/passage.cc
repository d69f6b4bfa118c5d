#include "library/exact/passage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "library/exact/least_height.h"
#include "library/exact/signed_distance.h"

namespace cdb::exact {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using objects::Pose;
using objects::Solid;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// In least sides: depths, and their accuracy.
constexpr double kShallow = 0.1, kDeep = 0.25, kWhole = 1, kTolerance = 0.05;
/// The least relative motion between two poses, in least sides: less than from shallow to deep.
constexpr double kLeastStep = 0.1;
/// Of poses in a cycle: a long rod may slide within another for all of it.
constexpr int kMostPoses = 1000;
/// Cosine; a right angle but for inaccurate normals.
constexpr double kReversed = -0.1;

struct Pieces {
  std::size_t a = 0, b = 0;
};

/// The part of a pair of solids that overlaps most.
struct Closest {
  double gap = kInfinity;               ///< m; negative: the depth
  Vector3d normal = Vector3d::UnitY();  ///< unit, from b to a
  Pieces pieces;
  double safe = kInfinity;  ///< in cycles: until then no part can be deeper than shallow
};

/// The relative motion of two solids in a cycle.
class PairMotion {
 public:
  PairMotion(const Solid& a, const Motion& motion_a, const Solid& b, const Motion& motion_b)
      : a_(a),
        b_(b),
        motion_a_(motion_a),
        motion_b_(motion_b),
        radius_a_(a.OuterRadius()),
        radius_b_(b.OuterRadius()),
        side_(2 * std::min(a.LeastHalfExtent(), b.LeastHalfExtent())),
        way_(motion_a.way - motion_b.way),
        turn_a_(a.IsBall() ? Vector3d::Zero() : Vector3d(radius_a_ * motion_a.turn)),
        turn_b_(b.IsBall() ? Vector3d::Zero() : Vector3d(radius_b_ * motion_b.turn)) {}

  /// m: of the thinner solid.
  double side() const { return side_; }
  /// m: no point of one moves more relative to a point of the other in the cycle.
  double Most() const { return way_.norm() + turn_a_.norm() + turn_b_.norm(); }

  /// Of the ends of the cycle: whether balls around the solids stay apart.
  bool PassAfar() const {
    const Vector3d offset = motion_a_.from.position - motion_b_.from.position;
    const double square = way_.squaredNorm();
    const double part = square > 0 ? std::clamp(-offset.dot(way_) / square, 0.0, 1.0) : 0;
    return (offset + part * way_).norm() > radius_a_ + radius_b_;
  }

  /// m: how far the solids at the start of the cycle, and therefore in all of it, are from a
  /// shallow overlap, if they lie on two sides of a plane with this normal.
  double SlackAlong(const Vector3d& normal) const {
    const auto farthest = [](const Solid& solid, const Quaterniond& turn, const Vector3d& way) {
      return way.dot(turn * solid.Support(turn.conjugate() * way));
    };
    const double gap = normal.dot(motion_a_.from.position - motion_b_.from.position) -
                       farthest(a_, motion_a_.from.orientation, -normal) -
                       farthest(b_, motion_b_.from.orientation, normal);
    return gap + kShallow * side_ - std::max(0.0, RateAlong(normal));
  }

  /// `guess`: the parts that were closest at the last pose.
  Closest At(double part, const Pose& pose_a, const Pose& pose_b, const Pieces& guess) const {
    const Matrix3d turn_a = pose_a.orientation.toRotationMatrix();
    const Matrix3d turn_b = pose_b.orientation.toRotationMatrix();
    const Vector3d offset = pose_b.position - pose_a.position;
    const double reach = (1 - part) * Most();
    Closest closest;
    const auto visit = [&](const Pieces& pieces) {
      const double enough = Enough(closest, reach);
      if (BallGap(turn_a, pieces.a, offset, turn_b, pieces.b) > enough) {
        closest.gap = std::min(closest.gap, reach);
        return;
      }
      const ConvexPart part_a(a_, pieces.a, turn_a, Vector3d::Zero()),
          part_b(b_, pieces.b, turn_b, offset);
      AddPieces(part_a, part_b, offset.norm() + radius_a_ + radius_b_, enough, pieces, closest);
    };
    visit(guess);
    for (std::size_t i = 0; i < a_.PieceCount(); ++i)
      for (std::size_t j = 0; j < b_.PieceCount(); ++j)
        if (i != guess.a || j != guess.b) visit({i, j});
    return closest;
  }

 private:
  /// m: between balls around two pieces.
  double BallGap(const Matrix3d& turn_a, std::size_t i, const Vector3d& offset,
                 const Matrix3d& turn_b, std::size_t j) const {
    const auto ball = [](const Solid& solid, std::size_t piece) -> std::pair<Vector3d, double> {
      if (!solid.compound) return {Vector3d::Zero(), solid.OuterRadius()};
      const auto& half = solid.compound->form().pieces[piece].half;
      return {solid.compound->PieceCentre(piece),
              half.cwiseProduct(solid.compound->sides()).norm()};
    };
    const auto [centre_a, around_a] = ball(a_, i);
    const auto [centre_b, around_b] = ball(b_, j);
    return (offset + turn_b * centre_b - turn_a * centre_a).norm() - around_a - around_b;
  }

  /// m per cycle: how fast points can come across a plane with this normal.
  double RateAlong(const Vector3d& normal) const {
    return -way_.dot(normal) + turn_a_.cross(normal).norm() + turn_b_.cross(normal).norm();
  }

  /// m: parts that are farther apart change nothing.
  double Enough(const Closest& closest, double reach) const {
    const double shallow = kShallow * side_;
    if (closest.gap < -shallow) return closest.gap;
    return std::min(reach, std::max(closest.gap, closest.safe * Most() - shallow));
  }

  void AddPieces(const ConvexPart& a, const ConvexPart& b, double scale, double enough,
                 const Pieces& pieces, Closest& closest) const {
    const double radii = a.radius() + b.radius();
    HeightGoal goal;
    goal.scale = scale;
    goal.tolerance = kTolerance * side_;
    goal.enough = enough + radii;
    goal.by_polytope = true;
    const LeastHeight found = FindLeastHeight(
        [&](const Vector3d& direction) -> Difference {
          return {a.CoreSupport(direction), b.CoreSupport(-direction)};
        },
        goal);
    const double gap = -found.height - radii;
    const Vector3d normal = -found.direction;
    // The plane between them stays: how fast they can come across it.
    const double rate =
        -way_.dot(normal) + turn_a_.cross(normal).norm() + turn_b_.cross(normal).norm();
    if (rate > 0) closest.safe = std::min(closest.safe, (gap + kShallow * side_) / rate);
    if (gap < closest.gap) {
      closest.gap = gap;
      closest.normal = normal;
      closest.pieces = pieces;
    }
  }

  const Solid &a_, &b_;
  const Motion &motion_a_, &motion_b_;
  const double radius_a_, radius_b_, side_;
  const Vector3d way_, turn_a_, turn_b_;  ///< turns times radii: m
};

}  // namespace

Pose Motion::At(double part) const {
  const double angle = turn.norm();
  if (!(angle > 0)) return {from.position + part * way, from.orientation};
  const Quaterniond turned(Eigen::AngleAxisd(part * angle, turn / angle));
  return {from.position + part * way, (turned * from.orientation).normalized()};
}

bool Passage::Follow(const Solid& a, const Motion& motion_a, const Solid& b,
                     const Motion& motion_b) {
  const PairMotion pair(a, motion_a, b, motion_b);
  const double most = pair.Most(), side = pair.side();
  if (most < slack_) {
    slack_ -= most;
    return false;
  }
  if (!overlaps_) {
    if (pair.PassAfar()) {
      slack_ = 0;
      return false;
    }
    slack_ = pair.SlackAlong(plane_);
    if (slack_ > 0) return false;
  }
  bool passed = false;
  int poses = 0;
  Pieces pieces;
  for (double part = 0;;) {
    const Pose pose_a = motion_a.At(part), pose_b = motion_b.At(part);
    const Closest closest = pair.At(part, pose_a, pose_b, pieces);
    pieces = closest.pieces;
    const double above = closest.gap + kShallow * side;
    double step = closest.safe;
    if (above < 0) {
      if (!overlaps_) Begin(closest.normal, pose_a.orientation, pose_b.orientation, part == 0);
      deepest_ = std::max(deepest_, -closest.gap);
      step = -above / most;
    } else if (overlaps_) {
      passed = passed || HasPassed(closest.normal, pose_a.orientation, pose_b.orientation, side);
      overlaps_ = false;
    }
    slack_ = std::abs(above);
    plane_ = closest.normal;
    if (!(part < 1)) break;
    part =
        ++poses < kMostPoses ? std::min(1.0, part + std::max(step, kLeastStep * side / most)) : 1.0;
  }
  spans_cycles_ = overlaps_;
  return passed;
}

void Passage::Begin(const Vector3d& normal, const Quaterniond& turn_a, const Quaterniond& turn_b,
                    bool is_at_start) {
  overlaps_ = true;
  spans_cycles_ = is_at_start;
  deepest_ = 0;
  entry_in_a_ = turn_a.conjugate() * normal;
  entry_in_b_ = turn_b.conjugate() * normal;
}

bool Passage::HasPassed(const Vector3d& normal, const Quaterniond& turn_a,
                        const Quaterniond& turn_b, double side) const {
  const double cosine = (entry_in_a_.dot(turn_a.conjugate() * normal) +
                         entry_in_b_.dot(turn_b.conjugate() * normal)) /
                        2;
  return (deepest_ > kDeep * side && cosine < kReversed) ||
         (deepest_ >= kWhole * side && !spans_cycles_);
}

}  // namespace cdb::exact
