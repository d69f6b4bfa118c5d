#include "library/objects/solid_pair.h"

#include <algorithm>
#include <limits>

#include "library/objects/simplex.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;

/// `support` gives the farthest point of b - a along a direction, `towards` is any point in the
/// middle of b - a, `size` the sum of the sizes of both solids. For kWhetherApart the distance is
/// only an upper bound.
template <typename Support, typename Goal>
Gap ConvexGap(const Support& support, const Vector3d& towards, double size, Goal goal) {
  const double scale = size + towards.norm();
  // A smaller gap is due to rounding.
  const double noise = 1e-14 * scale;
  // The rounding error of one operation. Bounds closer than this are equal.
  const double rounding = std::numeric_limits<double>::epsilon() * scale;
  Simplex simplex;
  simplex.points[simplex.size++] = support(-towards);
  bool is_apart = false;
  Gap best{std::numeric_limits<double>::infinity(), Vector3d::Zero()};
  constexpr int kMaxSteps = 256;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Vector3d nearest = ReduceToNearest(simplex, rounding);
    const double upper = nearest.norm();
    if (upper <= noise || simplex.size == 4) return {};
    const bool is_nearer = upper < best.distance;
    if (is_nearer) best = {upper, nearest / upper};
    const Vector3d point = support(-nearest);
    // Every point of b - a has at least this component along `nearest`: there is a plane between
    // them.
    const double lower = nearest.dot(point) / upper;
    is_apart = is_apart || lower > noise;
    if (is_apart && (goal == Goal::kWhetherApart || !is_nearer || upper - lower <= rounding)) break;
    const auto end = simplex.points.begin() + simplex.size;
    if (std::find(simplex.points.begin(), end, point) != end) break;
    simplex.points[simplex.size++] = point;
  }
  return is_apart ? best : Gap{};
}

}  // namespace

SolidPair::SolidPair(const Solid& a, const Eigen::Quaterniond& turn_a, const Solid& b,
                     const Eigen::Quaterniond& turn_b)
    : a_(a),
      b_(b),
      turn_a_(turn_a.toRotationMatrix()),
      turn_b_(turn_b.toRotationMatrix()),
      size_(a.sides.norm() + b.sides.norm()) {}

namespace {

auto HullOf(const Solid& solid) {
  return [&solid](const Vector3d& direction) { return solid.Support(direction); };
}

auto PieceOf(const Solid& solid, std::size_t piece) {
  return
      [&solid, piece](const Vector3d& direction) { return solid.PieceSupport(piece, direction); };
}

}  // namespace

template <typename PartOfA, typename PartOfB>
Gap SolidPair::GapOf(const PartOfA& part_a, const PartOfB& part_b, const Vector3d& offset,
                     Goal goal) const {
  const auto support = [&](const Vector3d& direction) -> Vector3d {
    return offset + turn_b_ * part_b(turn_b_.transpose() * direction) -
           turn_a_ * part_a(-(turn_a_.transpose() * direction));
  };
  return ConvexGap(support, offset, size_, goal);
}

bool SolidPair::SurfaceOverlaps(const Vector3d& offset) const {
  const bool is_a = a_.IsSurface();
  const Solid &surface = is_a ? a_ : b_, &other = is_a ? b_ : a_;
  const Eigen::Matrix3d &turn = is_a ? turn_a_ : turn_b_, &other_turn = is_a ? turn_b_ : turn_a_;
  const Vector3d place = turn.transpose() * (is_a ? offset : Vector3d(-offset));
  const Box box = Bounds(other, Eigen::Quaterniond(Eigen::Matrix3d(turn.transpose() * other_turn)));
  // Tolerance for the rounding of the rotation.
  const Vector3d room = Vector3d::Constant(1e-12 * size_);
  return surface.compound->AnyPieceIn(
      {place + box.lower - room, place + box.upper + room}, [&](std::size_t triangle) {
        for (std::size_t piece = 0; piece < other.PieceCount(); ++piece)
          if (is_a ? PiecesOverlap(triangle, piece, offset)
                   : PiecesOverlap(piece, triangle, offset))
            return true;
        return false;
      });
}

bool SolidPair::Overlap(const Vector3d& offset) const {
  // Neither of two surfaces has an inside that could contain the other.
  if (a_.IsSurface() && b_.IsSurface()) return false;
  if (a_.IsSurface() || b_.IsSurface()) return SurfaceOverlaps(offset);
  if (a_.PieceCount() == 1 && b_.PieceCount() == 1) return PiecesOverlap(0, 0, offset);
  const Gap hulls = GapOf(HullOf(a_), HullOf(b_), offset, Goal::kWhetherApart);
  if (hulls.distance > 0) return false;
  return AnyPieces([&](std::size_t piece_a, std::size_t piece_b) {
    return PiecesOverlap(piece_a, piece_b, offset);
  });
}

bool SolidPair::PiecesOverlap(std::size_t piece_a, std::size_t piece_b,
                              const Vector3d& offset) const {
  if (AreBalls()) {
    const double reach = (a_.sides.x() + b_.sides.x()) / 2;
    return offset.squaredNorm() <= reach * reach;
  }
  const Gap gap = GapOf(PieceOf(a_, piece_a), PieceOf(b_, piece_b), offset, Goal::kWhetherApart);
  return gap.distance == 0;
}

Gap SolidPair::PieceGap(std::size_t piece_a, std::size_t piece_b, const Vector3d& offset) const {
  if (AreBalls()) {
    const double between = offset.norm();
    const double gap = between - (a_.sides.x() + b_.sides.x()) / 2;
    if (!(gap > 0)) return {};
    return {gap, offset / between};
  }
  return GapOf(PieceOf(a_, piece_a), PieceOf(b_, piece_b), offset, Goal::kDistance);
}

}  // namespace cdb::objects
