#include "library/objects/solid_pair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

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
  const bool meets = surface.compound->AnyPieceIn(
      {place + box.lower - room, place + box.upper + room}, [&](std::size_t triangle) {
        for (std::size_t piece = 0; piece < other.PieceCount(); ++piece)
          if (is_a ? PiecesOverlap(triangle, piece, offset)
                   : PiecesOverlap(piece, triangle, offset))
            return true;
        return false;
      });
  return meets || IsInCells(offset);
}

bool SolidPair::IsInCells(const Vector3d& offset) const {
  if (a_.IsSurface() == b_.IsSurface()) return false;
  return a_.IsSurface() ? AnyPieceIsInCells(a_, turn_a_, b_, turn_b_, offset)
                        : AnyPieceIsInCells(b_, turn_b_, a_, turn_a_, -offset);
}

bool AnyPieceIsInCells(const Solid& surface, const Eigen::Matrix3d& turn, const Solid& other,
                       const Eigen::Matrix3d& other_turn, const Vector3d& offset) {
  if (surface.compound->form().voxels == nullptr) return false;
  for (std::size_t piece = 0; piece < other.PieceCount(); ++piece) {
    // A point well inside the piece, so that it tells a face that the piece touches from outside.
    Vector3d sum = Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis)
      sum += other.PieceSupport(piece, Vector3d::Unit(axis)) +
             other.PieceSupport(piece, -Vector3d::Unit(axis));
    const Vector3d point = offset + other_turn * sum / 6;
    if (surface.compound->IsInCells(turn.transpose() * point)) return true;
  }
  return false;
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

namespace {

/// The nearest of several parts of a simplex.
struct Best {
  Simplex part;
  Vector3d nearest = Vector3d::Zero();
  double least = -1;  ///< squared

  void TakeIfNearer(const Simplex& candidate, const Vector3d& point) {
    const double squared = point.squaredNorm();
    if (least >= 0 && !(squared < least)) return;
    least = squared;
    nearest = point;
    part = candidate;
  }
};

Vector3d NearestOnSegment(Simplex& simplex) {
  const Vector3d a = simplex.points[0], b = simplex.points[1];
  const Vector3d ab = b - a;
  const double t = -a.dot(ab);
  const double length = ab.squaredNorm();
  if (t <= 0 || length == 0) {
    simplex = {{a}, 1};
    return a;
  }
  if (t >= length) {
    simplex = {{b}, 1};
    return b;
  }
  const Vector3d point = a + ab * (t / length);
  // Repeated, to remove rounding errors along the segment: a short vector needs its direction too.
  return point - ab * (point.dot(ab) / length);
}

/// The normal of a triangle, of length twice the area. From the two shorter edges, as the longer
/// ones of a needle would cancel.
Vector3d NormalOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, bc = c - b, ca = a - c;
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return bc.cross(ca);
  return bc2 >= ca2 ? ca.cross(ab) : ab.cross(bc);
}

Vector3d NearestOnTriangle(Simplex& simplex, double noise) {
  const Vector3d a = simplex.points[0], b = simplex.points[1], c = simplex.points[2];
  const Vector3d normal = NormalOf(a, b, c);
  const double area = normal.squaredNorm();
  const double longest =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  if (area > noise * noise * longest) {
    const Vector3d point = normal * (a.dot(normal) / area);
    const Vector3d pa = a - point, pb = b - point, pc = c - point;
    if (pa.cross(pb).dot(normal) > 0 && pb.cross(pc).dot(normal) > 0 &&
        pc.cross(pa).dot(normal) > 0)
      return point;
  }
  Best best;
  for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
    Simplex edge{{p, q}, 2};
    const Vector3d point = NearestOnSegment(edge);
    best.TakeIfNearer(edge, point);
  }
  simplex = best.part;
  return best.nearest;
}

Vector3d NearestOnTetrahedron(Simplex& simplex, double noise) {
  // All have the same orientation, as seen from the corner that each leaves out.
  static constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  const auto points = simplex.points;
  const Vector3d& d = points[3];
  const Vector3d first = NormalOf(points[0], points[1], points[2]);
  // One sign for all faces: the individual signs of a flat tetrahedron may contradict one another.
  const double volume = first.dot(d - points[0]);
  double largest = first.squaredNorm();
  std::array<double, 4> heights;
  for (int face = 0; face < 4; ++face) {
    const Vector3d& a = points[kFaces[face][0]];
    const Vector3d normal = NormalOf(a, points[kFaces[face][1]], points[kFaces[face][2]]);
    heights[face] = a.dot(normal);
    largest = std::max(largest, normal.squaredNorm());
  }
  const bool is_flat = volume * volume <= noise * noise * largest;
  Best best;
  for (int face = 0; face < 4; ++face) {
    // The origin is on the inner side of this face.
    if (!is_flat && heights[face] * volume > 0) continue;
    Simplex triangle{{points[kFaces[face][0]], points[kFaces[face][1]], points[kFaces[face][2]]},
                     3};
    const Vector3d point = NearestOnTriangle(triangle, noise);
    best.TakeIfNearer(triangle, point);
  }
  if (best.least >= 0) simplex = best.part;
  return best.nearest;
}

}  // namespace

Vector3d ReduceToNearest(Simplex& simplex, double noise) {
  switch (simplex.size) {
    case 1:
      return simplex.points[0];
    case 2:
      return NearestOnSegment(simplex);
    case 3:
      return NearestOnTriangle(simplex, noise);
    default:
      return NearestOnTetrahedron(simplex, noise);
  }
}

}  // namespace cdb::objects
