#include "library/exact/convex_part.h"

namespace cdb::exact {
namespace {

double LeastRadiusOfCurvature(const objects::Solid& solid) {
  if (solid.shape == objects::Shape::kCompound) return 0;
  return objects::Visit(solid.shape, [&](auto form) {
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
