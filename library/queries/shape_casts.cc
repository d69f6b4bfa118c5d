#include "library/queries/shape_casts.h"

#include <algorithm>

#include "library/objects/solid_pair.h"

namespace cdb::queries {
namespace {

using Eigen::Vector3d;
using objects::Gap;
using objects::SolidPair;

/// As a fraction of sizes and offset: a gap that counts as none.
constexpr double kExact = 1e-12;
/// More than a search takes, unless it grazes.
constexpr int kMostSteps = 200;

/// Calls `visit(piece)` for the pieces of the body whose boxes may come within `reach` of the box
/// of the way, until it returns true.
template <typename Visit>
void ForPieces(const Placed& from, const Vector3d& way, double reach, const objects::Solid& body,
               const objects::Pose& pose, Visit visit) {
  if (!body.IsSurface()) {
    for (std::size_t piece = 0; piece < body.PieceCount(); ++piece)
      if (visit(piece)) return;
    return;
  }
  const Eigen::Quaterniond back = pose.orientation.conjugate();
  const Vector3d begin = back * (from.position - pose.position);
  Eigen::AlignedBox3d box(begin);
  box.extend(begin + back * way);
  const Vector3d margin = Vector3d::Constant(from.solid.OuterRadius() + reach);
  body.compound->AnyPieceIn({box.min() - margin, box.max() + margin}, visit);
}

/// The height of the solid above the plane.
double HeightAbove(const exact::HalfSpace& body, const Placed& at) {
  return body.normal.dot(at.position + at.solid.Support(-body.normal)) - body.offset;
}

}  // namespace

std::optional<Touch> SweepTo(const Placed& from, const Vector3d& along, double length,
                             const objects::Solid& body, const objects::Pose& pose) {
  const SolidPair pair(body, pose.orientation, from.solid, Eigen::Quaterniond::Identity());
  const Vector3d start = from.position - pose.position;
  const double exact = kExact * (pair.size() + start.norm());
  std::optional<Touch> first;
  ForPieces(from, length * along, 0, body, pose, [&](std::size_t piece) {
    double at = 0;
    Vector3d normal = Vector3d::Zero();
    for (int step = 0; step < kMostSteps; ++step) {
      const Gap gap = pair.PieceGap(piece, 0, start + at * along);
      if (gap.distance > exact) normal = gap.direction;
      const double rate = -normal.dot(along);
      if (gap.distance <= exact || step + 1 == kMostSteps) {
        first = Touch{at, normal};
        break;
      }
      if (!(rate > 0)) break;
      at += gap.distance / rate;
      if (!(at <= (first ? first->distance : length))) break;
    }
    return first && first->distance == 0;
  });
  return first;
}

std::optional<Touch> SweepTo(const Placed& from, const Vector3d& along, double length,
                             const exact::HalfSpace& body) {
  const double height = HeightAbove(body, from), rate = -body.normal.dot(along);
  if (height <= 0) return Touch{0, Vector3d::Zero()};
  if (!(rate > 0) || height > length * rate) return std::nullopt;
  return Touch{height / rate, body.normal};
}

std::optional<Touch> DistanceTo(const Placed& at, double reach, const objects::Solid& body,
                                const objects::Pose& pose) {
  const SolidPair pair(body, pose.orientation, at.solid, Eigen::Quaterniond::Identity());
  const Vector3d offset = at.position - pose.position;
  std::optional<Touch> least;
  ForPieces(at, Vector3d::Zero(), reach, body, pose, [&](std::size_t piece) {
    if (reach == 0) {  // whether they overlap takes less time than how far they are apart
      if (pair.PiecesOverlap(piece, 0, offset)) least = Touch{0, Vector3d::Zero()};
      return least.has_value();
    }
    const Gap gap = pair.PieceGap(piece, 0, offset);
    if (gap.distance <= (least ? least->distance : reach))
      least = Touch{gap.distance, gap.direction};
    return gap.distance == 0;
  });
  return least;
}

std::optional<Touch> DistanceTo(const Placed& at, double reach, const exact::HalfSpace& body) {
  const double height = HeightAbove(body, at);
  if (height > reach) return std::nullopt;
  return Touch{std::max(height, 0.0), height > 0 ? body.normal : Vector3d(Vector3d::Zero())};
}

}  // namespace cdb::queries
