// Solids of every kind for the tests of distances and layouts.
#pragma once

#include <memory>

#include "library/distributions/stream.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/primitives.h"
#include "library/objects/solid.h"

namespace cdb::test {

inline constexpr library::Shape kConvexShapes[] = {
    library::Shape::kEllipsoid, library::Shape::kCuboid,  library::Shape::kCylinder,
    library::Shape::kCone,      library::Shape::kCapsule, library::Shape::kTetrahedron};

/// 4 wide and 1 high, with a hole 2 wide along y, but for its corners.
inline library::Solid Torus() {
  const library::Mesh mesh = library::TorusMesh(1.5, 0.5, 32, library::kTorusCorners);
  const auto form = std::make_shared<const library::Form>(library::MakeForm(
      "ring", mesh, library::MassPropertiesOf(mesh), library::TorusHulls(1.5, 0.5, 8)));
  library::Solid solid{library::Shape::kCompound, {4, 1, 4}};
  solid.compound = std::make_shared<const library::Compound>(form, solid.sides);
  return solid;
}

inline Eigen::Vector3d RandomDirection(library::Stream& stream) {
  const double x = stream.Normal(), y = stream.Normal();
  return Eigen::Vector3d(x, y, stream.Normal()).normalized();
}

/// Sides between 1 and `most`.
inline library::Solid RandomSolid(library::Stream& stream, library::Shape shape, double most) {
  library::Solid solid{shape};
  for (double& side : solid.sides) side = stream.LogUniform(1, most);
  return solid;
}

}  // namespace cdb::test
