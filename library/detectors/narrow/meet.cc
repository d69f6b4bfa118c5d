// The place at which two pieces touch, from the normal and the gap: a point that is common to the
// features which face each other.
#include <algorithm>
#include <cmath>

#include "library/detectors/narrow/manifold.h"

namespace cdb::narrow {
namespace {

/// The points of a core that are farthest along a direction, to a tolerance: a point, a segment, a
/// polygon or a disc. In the frame of the couple.
class Farthest {
 public:
  /// `slack`: rad; what is tilted by less faces along the direction, which is unit and in the frame
  /// of the piece.
  Farthest(const Piece& piece, const Rotation& turn, const Vec3& place, const Vec3& direction,
           double slack)
      : piece_(piece), turn_(turn), place_(place) {
    if (IsCurved(piece.kind)) {
      FindOfCurved(direction, slack);
    } else {
      FindOfVertices(direction, slack);
    }
  }

  /// The nearest point of the feature.
  Vec3 Nearest(const Vec3& point) const {
    const Vec3 local = Inverse(turn_, point - place_);
    return turn_ * (is_disc_ ? NearestOfDisc(local) : NearestOfCorners(local)) + place_;
  }

 private:
  void Add(const Vec3& corner) { corners_[count_++] = corner; }

  void FindOfCurved(const Vec3& direction, double slack) {
    const Vec3 &half = piece_.half, farthest = FarthestOnCurved(piece_, direction);
    const double middle = piece_.centre.y;
    if (piece_.kind == Kind::kRound) {
      Add(farthest);
      if (piece_.straight > 0 && std::abs(direction.y) <= slack)
        Add({farthest.x, farthest.y - std::copysign(2 * piece_.straight, direction.y), farthest.z});
      return;
    }
    const Scaled rim = RimOf(piece_, direction);
    const bool is_cone = piece_.kind == Kind::kCone;
    is_disc_ = rim.length <= slack * std::max(half.x, half.z) && !(is_cone && direction.y > 0);
    if (is_disc_) return Add({0, middle + std::copysign(half.y, direction.y), 0});
    const Vec3 across = rim.Farthest(), low = {across.x, middle - half.y, across.z};
    const Vec3 high =
        is_cone ? Vec3{0, middle + half.y, 0} : Vec3{across.x, middle + half.y, across.z};
    const Vec3 along = high - low;
    if (std::abs(Dot(along, direction)) > slack * Norm(along)) return Add(farthest);
    Add(low);
    Add(high);
  }

  void FindOfVertices(const Vec3& direction, double slack) {
    if (!piece_.faces.empty())
      if (const FlatFace& face = FacingFace(piece_, direction);
          SquaredNorm(Cross(face.normal, direction)) <= slack * slack &&
          Dot(face.normal, direction) > 0) {
        face_ = &face;
        return Add(piece_.Vertex(piece_.corners[face.first]));
      }
    // Of those that are about as far, the two that are farthest from each other.
    const Vec3 first = piece_.Vertex(FarthestVertex(piece_, direction));
    const double extent = Dot(first, direction);
    const auto farthest_from = [&](const Vec3& from) {
      Vec3 best = from;
      for (std::uint32_t i = 0; i < piece_.count; ++i)
        if (const Vec3 vertex = piece_.Vertex(i);
            SquaredNorm(vertex - from) > SquaredNorm(best - from) &&
            extent - Dot(vertex, direction) <= slack * Norm(vertex - first))
          best = vertex;
      return best;
    };
    const Vec3 one = farthest_from(first), other = farthest_from(one);
    Add(one);
    if (SquaredNorm(other - one) > 0) Add(other);
  }

  static Vec3 NearestOnSegment(const Vec3& from, const Vec3& to, const Vec3& point) {
    const Vec3 along = to - from;
    return from + std::clamp(Dot(point - from, along) / SquaredNorm(along), 0.0, 1.0) * along;
  }

  Vec3 NearestOfCorners(const Vec3& point) const {
    if (face_ == nullptr)
      return count_ == 1 ? corners_[0] : NearestOnSegment(corners_[0], corners_[1], point);
    const auto corner = [&](std::uint32_t i) {
      return piece_.Vertex(piece_.corners[face_->first + (i == face_->count ? 0 : i)]);
    };
    const Vec3 flat = point + (face_->offset - Dot(face_->normal, point)) * face_->normal;
    bool is_inside = true;
    double least = kernels::kInfinity;
    Vec3 best = flat;
    for (std::uint32_t i = 0; i < face_->count; ++i) {
      const Vec3 from = corner(i), to = corner(i + 1);
      if (Dot(face_->normal, Cross(to - from, flat - from)) >= 0) continue;
      is_inside = false;
      const Vec3 on_side = NearestOnSegment(from, to, flat);
      if (const double square = SquaredNorm(on_side - flat); square < least)
        least = square, best = on_side;
    }
    return is_inside ? flat : best;
  }

  /// By Newton's method for the multiplier, from below. Source: Eberly, Distance from a point to an
  /// ellipse, 2013.
  Vec3 NearestOfDisc(const Vec3& point) const {
    const double a = piece_.half.x, b = piece_.half.z, square_a = a * a, square_b = b * b;
    double t = 0, x = point.x / a, z = point.z / b;
    if (x * x + z * z <= 1) return {point.x, corners_[0].y, point.z};
    for (int i = 0; i < 30; ++i) {
      const double from_a = square_a + t, from_b = square_b + t;
      x = a * point.x / from_a, z = b * point.z / from_b;
      const double over = x * x + z * z - 1;
      if (!(over > 1e-14)) break;
      t += over / (2 * (x * x / from_a + z * z / from_b));
    }
    return {a * x, corners_[0].y, b * z};
  }

  const Piece& piece_;
  const Rotation& turn_;
  const Vec3 place_;
  Vec3 corners_[2];
  std::size_t count_ = 0;
  const FlatFace* face_ = nullptr;
  bool is_disc_ = false;
};

/// Points of the two features that are about the nearest to each other if that of b is moved by
/// `shift`: alternating projections, from on_b.
void Approach(const Farthest& of_a, const Farthest& of_b, const Vec3& shift, double enough,
              Vec3& on_a, Vec3& on_b) {
  constexpr int kMostSteps = 60;
  for (int step = 0; step < kMostSteps; ++step) {
    const Vec3 next_a = of_a.Nearest(on_b + shift), next_b = of_b.Nearest(next_a - shift);
    const double moved = SquaredNorm(next_b - on_b);
    on_a = next_a;
    on_b = next_b;
    if (SquaredNorm(on_a - on_b - shift) <= enough * enough || moved <= 1e-4 * enough * enough)
      break;
  }
}

}  // namespace

void Meet(const Couple& couple, Separation& separation) {
  constexpr Rotation kNone = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Vec3 normal = separation.normal, shift = separation.gap * normal;
  const double enough = kSamePlace * std::min(couple.a.bound, couple.b.bound);
  const auto residual = [&](const Vec3& on_a, const Vec3& on_b) {
    return SquaredNorm(on_a - on_b - shift);
  };
  // Points of a piece that touch a plane which it does not cross are on its surface.
  const Vec3 of_b = Inverse(couple.turn, normal);
  const double under_a = Extent(couple.a, -normal) + Dot(normal, separation.on_a),
               under_b = Extent(couple.b, of_b) -
                         Dot(of_b, Inverse(couple.turn, separation.on_b - couple.place));
  double least = residual(separation.on_a, separation.on_b) + under_a * under_a + under_b * under_b;
  const Vec3 start = separation.on_b;
  for (const double slack : {1e-6, 1e-3, 1e-2}) {
    if (least <= enough * enough) break;
    const Farthest a(couple.a, kNone, {0, 0, 0}, -normal, slack),
        b(couple.b, couple.turn, couple.place, of_b, slack);
    Vec3 on_a = {}, on_b = start;
    Approach(a, b, shift, enough, on_a, on_b);
    if (const double square = residual(on_a, on_b); square < least) {
      least = square;
      separation.on_a = on_a;
      separation.on_b = on_b;
    }
  }
  // What is left is shared by both.
  const Vec3 middle = 0.5 * (separation.on_a + separation.on_b);
  separation.on_a = middle + 0.5 * shift;
  separation.on_b = middle - 0.5 * shift;
}

}  // namespace cdb::narrow
