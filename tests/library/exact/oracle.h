// Heights and membership of solids by their equations, written apart from library/objects, for
// checking the proofs of library/exact.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "library/objects/solid.h"

namespace cdb::tests {

/// The shapes that have equations here.
inline constexpr objects::Shape kOracleShapes[] = {
    objects::Shape::kEllipsoid, objects::Shape::kCuboid,  objects::Shape::kCylinder,
    objects::Shape::kCone,      objects::Shape::kCapsule, objects::Shape::kTetrahedron};

/// The height of the solid, or of a convex piece of it, along a unit vector, from its position.
inline double HeightOf(const objects::Solid& solid, std::size_t piece,
                       const Eigen::Quaterniond& turn, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d u = turn.conjugate() * direction, half = solid.sides / 2;
  const double across = std::hypot(half.x() * u.x(), half.z() * u.z());
  switch (solid.shape) {
    case objects::Shape::kEllipsoid:
      return half.cwiseProduct(u).norm();
    case objects::Shape::kCuboid:
      return half.dot(u.cwiseAbs());
    case objects::Shape::kCylinder:
      return half.y() * std::fabs(u.y()) + across;
    case objects::Shape::kCone:
      return std::max(1.5 * half.y() * u.y(), -0.5 * half.y() * u.y() + across);
    case objects::Shape::kCapsule: {
      const double cap = std::min(half.y(), std::sqrt(half.x() * half.z()));
      return (half.y() - cap) * std::fabs(u.y()) + std::hypot(across, cap * u.y());
    }
    case objects::Shape::kTetrahedron: {
      const Eigen::Vector3d s = half.cwiseProduct(u);
      return std::max({s.x() + s.y() + s.z(), s.x() - s.y() - s.z(), s.y() - s.x() - s.z(),
                       s.z() - s.x() - s.y()});
    }
    case objects::Shape::kCompound:
      break;
  }
  double height = -INFINITY;
  for (std::size_t i = 0; i < solid.compound->form().pieces[piece].vertices.size(); ++i)
    height = std::max(height, u.dot(solid.compound->Corner(piece, i)));
  return height;
}

/// How far outside a convex piece a point is, m: 0 inside. Along the normals of its faces, or, for
/// curved solids, of the length by which it would have to grow along its shortest half axis.
inline double OutsideOf(const objects::Solid& solid, std::size_t piece, const objects::Pose& pose,
                        const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = pose.orientation.conjugate() * (point - pose.position),
                        half = solid.sides / 2, scaled = p.cwiseQuotient(half);
  const double across = std::hypot(scaled.x(), scaled.z()), least = half.minCoeff();
  double outside = 0;
  switch (solid.shape) {
    case objects::Shape::kEllipsoid:
      outside = (scaled.norm() - 1) * least;
      break;
    case objects::Shape::kCuboid:
      outside = (p.cwiseAbs() - half).maxCoeff();
      break;
    case objects::Shape::kCylinder:
      outside = std::max(std::fabs(p.y()) - half.y(), (across - 1) * least);
      break;
    case objects::Shape::kCone:
      outside = std::max(-0.5 * half.y() - p.y(), (across - (0.75 - 0.5 * scaled.y())) * least);
      break;
    case objects::Shape::kCapsule: {
      const double cap = std::min(half.y(), std::sqrt(half.x() * half.z()));
      const double above = std::max(0.0, std::fabs(p.y()) - (half.y() - cap));
      outside = (std::hypot(across, above / cap) - 1) * std::min(least, cap);
      break;
    }
    case objects::Shape::kTetrahedron:
      outside =
          std::max({-scaled.x() - scaled.y() - scaled.z(), -scaled.x() + scaled.y() + scaled.z(),
                    scaled.x() - scaled.y() + scaled.z(), scaled.x() + scaled.y() - scaled.z()});
      outside = (outside - 1) * least;
      break;
    case objects::Shape::kCompound: {
      const auto corner = [&](std::size_t i) { return solid.compound->Corner(piece, i); };
      for (const auto& [a, b, c] : solid.compound->form().pieces[piece].faces) {
        const Eigen::Vector3d along = corner(b) - corner(a);
        Eigen::Vector3d normal = along.cross(corner(c) - corner(a));
        if (!(normal.norm() > 1e-12 * solid.sides.squaredNorm())) continue;
        normal.normalize();
        const double height = normal.dot(p - corner(a));
        outside = std::max(outside, solid.IsSurface() ? std::fabs(height) : height);
        if (!solid.IsSurface()) continue;
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
          const Eigen::Vector3d outwards = (corner(to) - corner(from)).cross(normal).normalized();
          outside = std::max(outside, outwards.dot(p - corner(from)));
        }
      }
      break;
    }
  }
  return std::max(0.0, outside);
}

}  // namespace cdb::tests
