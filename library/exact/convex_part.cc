#include "library/exact/convex_part.h"

namespace cdb::exact {
namespace {

/// The least radius of curvature of a solid without edges; 0 for one with edges or corners.
double LeastRadiusOfCurvature(const objects::Solid& solid) {
  Eigen::Vector3d half = solid.HalfExtents();
  if (solid.shape == objects::Shape::kCapsule)
    half.y() -= solid.StraightHalf();
  else if (solid.shape != objects::Shape::kEllipsoid)
    return 0;
  if (half.maxCoeff() == half.minCoeff()) return half.x();
  return half.minCoeff() / half.maxCoeff() * half.minCoeff();
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
