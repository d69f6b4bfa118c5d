// Random solids of every kind, for the tests of distances and layouts.
#pragma once

#include <memory>

#include "library/distributions/stream.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/primitives.h"
#include "library/objects/solid.h"

namespace cdb::tests {

/// A torus, approximated by a polyhedron: 4 wide and 1 high, with a hole 2 wide along y. Made once,
/// because assessing its hulls takes time.
inline objects::Solid Torus() {
  static const objects::Solid torus = [] {
    const meshes::Mesh mesh = meshes::TorusMesh(1.5, 0.5, 32, meshes::kTorusCorners);
    const auto form =
        std::make_shared<const objects::ConvexDecomposition>(objects::MakeDecomposition(
            "ring", mesh, meshes::MassPropertiesOf(mesh), meshes::TorusHulls(1.5, 0.5, 8)));
    objects::Solid solid{objects::Shape::kCompound, {4, 1, 4}};
    solid.compound = std::make_shared<const objects::Compound>(form, solid.sides);
    return solid;
  }();
  return torus;
}

inline Eigen::Vector3d RandomDirection(distributions::Stream& stream) {
  const double x = stream.Normal(), y = stream.Normal();
  return Eigen::Vector3d(x, y, stream.Normal()).normalized();
}

/// A solid with sides between 1 and `most`, and exponents between 0.1 and 2.
inline objects::Solid RandomSolid(distributions::Stream& stream, objects::Shape shape,
                                  double most) {
  objects::Solid solid{shape};
  for (double& side : solid.sides) side = stream.LogUniform(1, most);
  if (shape == objects::Shape::kSuperellipsoid)
    for (double& exponent : solid.exponents) exponent = stream.LogUniform(0.1, 2);
  return solid;
}

/// The support point in a direction of the world.
inline Eigen::Vector3d WorldSupport(const objects::Solid& solid, const objects::Pose& pose,
                                    const Eigen::Vector3d& direction) {
  return pose.position + pose.orientation * solid.Support(pose.orientation.conjugate() * direction);
}

}  // namespace cdb::tests
