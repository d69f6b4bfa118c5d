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
/// In least sides: depths, and their accuracy in general and where a direction matters.
constexpr double kShallow = 0.1, kDeep = 0.25, kWhole = 1, kTolerance = 0.05, kFine = 1e-4;
/// Of motion, in least sides: how closely the pose is found at which two solids touch.
constexpr double kTouch = 0.01;
/// The least relative motion between two poses, in least sides: less than from shallow to deep.
constexpr double kLeastStep = 0.1;
/// Of poses in a cycle: a long rod may slide within another for all of it.
constexpr int kMostPoses = 1000;
/// Of distances, in least sides: beyond it, rounding errors reach a thousandth of a side.
constexpr double kFarthest = 1e12;
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
  double safe = kInfinity;  ///< in cycles: until then no part can be deep
  bool is_known = true;     ///< to the accuracy above
};

/// m: of the points of a solid from an axis through its centre of mass, at most.
double TurnRadius(const Solid& solid, const Quaterniond& orientation, const Vector3d& axis) {
  if (solid.compound) return solid.OuterRadius();
  const Vector3d along = (orientation.conjugate() * axis).cwiseAbs();
  Vector3d far = solid.HalfExtents();
  far.y() += std::abs(solid.BoxCentre());
  const Vector3d most(along.y() * far.z() + along.z() * far.y(),
                      along.z() * far.x() + along.x() * far.z(),
                      along.x() * far.y() + along.y() * far.x());
  return std::min(most.norm(), solid.OuterRadius());
}

/// m, along the axis: no point comes farther by the turn, which keeps its distance from the axis.
Vector3d TurnOf(const Solid& solid, const Motion& motion) {
  const double angle = motion.turn.norm();
  if (!(angle > 0) || solid.IsBall()) return Vector3d::Zero();
  return TurnRadius(solid, motion.from.orientation, motion.turn / angle) * motion.turn;
}

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
        offset_(motion_a.from.position - motion_b.from.position),
        turn_a_(TurnOf(a, motion_a)),
        turn_b_(TurnOf(b, motion_b)) {}

  /// m: of the thinner solid.
  double side() const { return side_; }
  /// m: no point of one moves more relative to a point of the other in the cycle.
  double Most() const { return way_.norm() + turn_a_.norm() + turn_b_.norm(); }

  /// m: the largest length in the cycle.
  double Scale() const { return offset_.norm() + radius_a_ + radius_b_ + Most(); }

  /// Whether balls around the solids stay apart.
  bool PassAfar() const { return NearestOffset().norm() > radius_a_ + radius_b_; }

  /// Whether the plane along the motion and across the way between the centres, where that is
  /// shortest, shows that they do not overlap by more than `depth` (m) in the cycle.
  bool StayApart(double depth) const {
    const Vector3d across = NearestOffset();
    const double distance = across.norm();
    if (!(distance > 0)) return false;
    const Vector3d normal = across / distance;
    const auto farthest = [](const Solid& solid, const Vector3d& turn, const Quaterniond& pose,
                             const Vector3d& way) {
      return way.dot(pose * solid.Support(pose.conjugate() * way)) + turn.cross(way).norm();
    };
    const double room = std::min(normal.dot(offset_), normal.dot(offset_ + way_)) + depth;
    if (room < a_.InnerRadius() + b_.InnerRadius()) return false;
    return room > farthest(a_, turn_a_, motion_a_.from.orientation, -normal) +
                      farthest(b_, turn_b_, motion_b_.from.orientation, normal);
  }

  /// `last`: at the last pose. Parts that cannot touch in the rest of the cycle are left out.
  Closest At(double part, const Closest& last) const {
    return At(part, last, (1 - part) * Most(), kTolerance * side_);
  }
  /// The same to the finer accuracy, and whatever their distance.
  Closest FineAt(double part, const Closest& last) const {
    return At(part, last, kInfinity, kFine * side_);
  }
  /// Between a part of the cycle at which they are apart and one at which they overlap: in which
  /// direction they separate where they touch.
  Heading HeadingBetween(double apart, double overlapping, Closest last) const {
    last = FineAt(apart, last);
    while (std::abs(overlapping - apart) * Most() > kTouch * side_) {
      const double middle = (apart + overlapping) / 2;
      const Closest closest = FineAt(middle, last);
      (closest.gap < 0 ? overlapping : apart) = middle;
      if (closest.gap >= 0) last = closest;
    }
    const Pose pose_a = motion_a_.At(apart), pose_b = motion_b_.At(apart);
    const Vector3d offset = pose_a.position - pose_b.position;
    const auto from = [&](const Pose& pose) -> Heading::Seen {
      const Quaterniond turn = pose.orientation.conjugate();
      return {turn * last.normal, turn * offset};
    };
    return {from(pose_a), from(pose_b)};
  }

 private:
  Closest At(double part, const Closest& last, double reach, double tolerance) const {
    const Pose pose_a = motion_a_.At(part), pose_b = motion_b_.At(part);
    const Matrix3d turn_a = pose_a.orientation.toRotationMatrix();
    const Matrix3d turn_b = pose_b.orientation.toRotationMatrix();
    const Vector3d offset = pose_b.position - pose_a.position;
    Closest closest;
    const auto visit = [&](const Pieces& pieces, bool is_last) {
      const double enough = Enough(closest, reach);
      const auto [way, around] = BallsOf(turn_a, pieces.a, offset, turn_b, pieces.b);
      const double distance = way.norm();
      if (distance - around > enough) {
        closest.gap = std::min(closest.gap, reach);
        return;
      }
      const ConvexPart part_a(a_, pieces.a, turn_a, Vector3d::Zero()),
          part_b(b_, pieces.b, turn_b, offset);
      HeightGoal goal;
      goal.scale = offset.norm() + radius_a_ + radius_b_;
      goal.tolerance = tolerance;
      if (is_last)
        goal.guess = -last.normal;
      else if (distance > 0)
        goal.guess = way / distance;
      AddPieces(part_a, part_b, goal, enough, pieces, closest);
    };
    visit(last.pieces, part > 0);
    for (std::size_t i = 0; i < a_.PieceCount(); ++i)
      for (std::size_t j = 0; j < b_.PieceCount(); ++j)
        if (i != last.pieces.a || j != last.pieces.b) visit({i, j}, false);
    return closest;
  }

  /// m: between the centres, in the cycle.
  Vector3d NearestOffset() const {
    const double square = way_.squaredNorm();
    const double part = square > 0 ? std::clamp(-offset_.dot(way_) / square, 0.0, 1.0) : 0;
    return offset_ + part * way_;
  }

  /// The way between the centres of balls around two pieces, m, and the sum of their radii.
  std::pair<Vector3d, double> BallsOf(const Matrix3d& turn_a, std::size_t i, const Vector3d& offset,
                                      const Matrix3d& turn_b, std::size_t j) const {
    const auto ball = [](const Solid& solid, std::size_t piece) -> std::pair<Vector3d, double> {
      if (!solid.compound) return {Vector3d::Zero(), solid.OuterRadius()};
      const auto& half = solid.compound->form().pieces[piece].half;
      return {solid.compound->PieceCentre(piece),
              half.cwiseProduct(solid.compound->sides()).norm()};
    };
    const auto [centre_a, around_a] = ball(a_, i);
    const auto [centre_b, around_b] = ball(b_, j);
    return {offset + turn_b * centre_b - turn_a * centre_a, around_a + around_b};
  }

  /// m per cycle: how fast points can come across a plane with this normal.
  double RateAlong(const Vector3d& normal) const {
    return -way_.dot(normal) + turn_a_.cross(normal).norm() + turn_b_.cross(normal).norm();
  }

  /// m: parts that are farther apart change nothing.
  double Enough(const Closest& closest, double reach) const {
    const double shallow = kShallow * side_;
    if (closest.gap < -shallow) return closest.gap;
    return std::min(reach, std::max(closest.gap, closest.safe * Most() - kDeep * side_));
  }

  void AddPieces(const ConvexPart& a, const ConvexPart& b, HeightGoal goal, double enough,
                 const Pieces& pieces, Closest& closest) const {
    const double radii = a.radius() + b.radius();
    goal.enough = enough + radii;
    goal.by_polytope = true;
    const LeastHeight found = FindLeastHeight(
        [&](const Vector3d& direction) -> Difference {
          return {a.CoreSupport(direction), b.CoreSupport(-direction)};
        },
        goal);
    const double gap = -found.height - radii;
    const Vector3d normal = -found.direction;
    closest.is_known = closest.is_known && (gap >= std::min(enough, -kShallow * side_) ||
                                            found.upper - found.lower <= 2 * goal.tolerance);
    // The plane between them stays: how fast they can come across it.
    const double rate = RateAlong(normal);
    if (rate > 0) closest.safe = std::min(closest.safe, (gap + kDeep * side_) / rate);
    if (gap < closest.gap) {
      closest.gap = gap;
      closest.normal = normal;
      closest.pieces = pieces;
    }
  }

  const Solid &a_, &b_;
  const Motion &motion_a_, &motion_b_;
  const double radius_a_, radius_b_, side_;
  const Vector3d way_, offset_;     ///< m: of a, relative to b
  const Vector3d turn_a_, turn_b_;  ///< m: turns times radii
};

}  // namespace

Pose Motion::At(double part) const {
  const double angle = turn.norm();
  if (!(angle > 0)) return {from.position + part * way, from.orientation};
  const Quaterniond turned(Eigen::AngleAxisd(part * angle, turn / angle));
  return {from.position + part * way, (turned * from.orientation).normalized()};
}

bool MayMeet(const Solid& a, const Motion& motion_a, const Solid& b, const Motion& motion_b) {
  const PairMotion pair(a, motion_a, b, motion_b);
  return !pair.PassAfar() && !pair.StayApart(0);
}

Passing Passage::Follow(const Solid& a, const Motion& motion_a, const Solid& b,
                        const Motion& motion_b) {
  const PairMotion pair(a, motion_a, b, motion_b);
  const double most = pair.Most(), side = pair.side();
  const bool is_slow = most < kLeastMotion * side;
  if (overlaps_ && most < slack_) {
    slack_ -= most;
    return Passing::kNone;
  }
  if (!overlaps_ && is_slow) return Passing::kNone;
  if (!(pair.Scale() < kFarthest * side)) {
    overlaps_ = false;
    return Passing::kUnknown;
  }
  if (!overlaps_ && (pair.PassAfar() || pair.StayApart(kDeep * side))) return Passing::kNone;
  spans_cycles_ = overlaps_;
  bool is_known = true;
  int poses = 0;
  Closest closest;
  for (double part = 0, last = 0;;) {
    closest = pair.At(part, closest);
    // Where it may be over, or may not have begun.
    if (-closest.gap < kTolerance * side && (overlaps_ || closest.gap < 0))
      closest.gap = pair.FineAt(part, closest).gap;
    is_known = is_known && closest.is_known;
    const double below = -closest.gap - kShallow * side;
    if (overlaps_ && (closest.gap >= 0 || (is_slow && below < 0))) {
      overlaps_ = false;
      if (deepest_ > kDeep * side &&
          HasPassed(pair.HeadingBetween(part, last, closest), side, !a.compound && !b.compound))
        return Passing::kPassed;
    } else if (closest.gap < 0 && (overlaps_ || !is_slow)) {
      if (!overlaps_) {
        overlaps_ = true;
        spans_cycles_ = part == 0;
        deepest_ = 0;
        entry_ = pair.HeadingBetween(last, part, closest);
      }
      deepest_ = std::max(deepest_, -closest.gap);
    }
    slack_ = std::max(0.0, below);
    if (!(part < 1)) break;
    if (++poses == kMostPoses) {
      is_known = overlaps_ = false;
      break;
    }
    last = part;
    // To where it ends, or, if it is shallow or has not begun, may be deep.
    const bool is_deep = overlaps_ && (below > 0 || deepest_ > kDeep * side);
    part = std::min(
        1.0, part + std::max(is_deep ? slack_ / most : closest.safe, kLeastStep * side / most));
  }
  return is_known ? Passing::kNone : Passing::kUnknown;
}

bool Passage::HasPassed(const Heading& exit, double side, bool is_convex) const {
  double cosine = 0, advance = 0;
  for (const auto seen : {&Heading::from_a, &Heading::from_b}) {
    const Heading::Seen &in = entry_.*seen, &out = exit.*seen;
    cosine += in.normal.dot(out.normal) / 2;
    advance += in.normal.dot(in.offset - out.offset) / 2;
  }
  return cosine < kReversed || (!is_convex && advance > kWhole * side) ||
         (deepest_ >= kWhole * side && !spans_cycles_);
}

}  // namespace cdb::exact
