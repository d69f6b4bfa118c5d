#include "runtime/engine/probes/contact_sides.h"

#include <algorithm>
#include <limits>

#include "runtime/engine/world/conversions.h"
#include "runtime/omissions/omissions.h"

namespace cdb::probes {

using Eigen::Vector3d;

namespace {

/// A point of contact is looked for in pieces that are larger by this fraction, because margins and
/// rounding place it beside their surfaces.
constexpr double kLarger = 0.1;

}  // namespace

double TouchedSide(const objects::Compound& compound, const Vector3d& point) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t piece = 0; piece < compound.form().PieceCount(); ++piece) {
    const double half = compound.PieceHalfExtent(piece);
    const Vector3d centre = compound.PieceCentre(piece);
    if (half < least && compound.PieceContains(piece, centre + (point - centre) / (1 + kLarger)))
      least = half;
  }
  return 2 * (std::isfinite(least) ? least : compound.least_half_extent());
}

ContactSides::ContactSides(const world::Engine& engine) : engine_(engine) {
  for (const layouts::ObjectState& object : engine.initial_state().objects)
    least_.push_back(2 * object.solid.LeastHalfExtent());
  least_.resize(least_.size() + omissions::kWallCount, std::numeric_limits<double>::infinity());
}

double ContactSides::At(const btPersistentManifold& manifold, const btManifoldPoint& point) const {
  const auto side = [&](const btCollisionObject& body, const btVector3& at) {
    const auto i = static_cast<std::size_t>(body.getUserIndex());
    if (i >= engine_.objects().size()) return least_[i];
    const objects::Solid& solid = engine_.initial_state().objects[i].solid;
    if (!solid.compound || solid.IsSurface()) return least_[i];
    return TouchedSide(*solid.compound, world::ToEigen(at));
  };
  // In the axes of the bodies, which have moved since.
  return std::min(side(*manifold.getBody0(), point.m_localPointA),
                  side(*manifold.getBody1(), point.m_localPointB));
}

}  // namespace cdb::probes
