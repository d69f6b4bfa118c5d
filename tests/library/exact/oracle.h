// Heights and membership of solids by their equations, written apart from library/objects, for
// checking the proofs of library/exact.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "dsl/text/check.h"
#include "library/objects/solid.h"

namespace cdb::tests {

/// The shapes that have equations here.
inline constexpr objects::Shape kOracleShapes[] = {
    objects::Shape::kEllipsoid,     objects::Shape::kCuboid,  objects::Shape::kCylinder,
    objects::Shape::kCone,          objects::Shape::kCapsule, objects::Shape::kTetrahedron,
    objects::Shape::kSuperellipsoid};

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
    case objects::Shape::kSuperellipsoid: {
      // The dual norm of that of its equation; with an exponent of 2, the greatest of both.
      const auto norm = [](double a, double b, double e) {
        const double p = 2 / (2 - e), most = std::max(a, b);
        if (std::isinf(p) || most == 0) return most;
        return most * std::pow(std::pow(a / most, p) + std::pow(b / most, p), 1 / p);
      };
      const Eigen::Vector3d s = half.cwiseProduct(u).cwiseAbs();
      return norm(norm(s.x(), s.z(), solid.exponents.y()), s.y(), solid.exponents.x());
    }
    default:  // a compound
      break;
  }
  double height = -INFINITY;
  const std::size_t corners =
      solid.IsSurface() ? 3 : solid.compound->form().pieces[piece].vertices.size();
  for (std::size_t i = 0; i < corners; ++i)
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
    case objects::Shape::kSuperellipsoid: {
      const Eigen::Vector3d s = scaled.cwiseAbs();
      const double most = s.maxCoeff(), e1 = solid.exponents.x(), e2 = solid.exponents.y();
      if (most == 0) break;
      const double around =
          std::pow(std::pow(s.x() / most, 2 / e2) + std::pow(s.z() / most, 2 / e2), e2 / 2);
      outside = most * std::pow(std::pow(around, 2 / e1) + std::pow(s.y() / most, 2 / e1), e1 / 2);
      outside = (outside - 1) * least;
      break;
    }
    case objects::Shape::kCompound: {
      const auto corner = [&](std::size_t i) { return solid.compound->Corner(piece, i); };
      const std::vector<meshes::Triangle> faces = solid.IsSurface()
                                                      ? std::vector<meshes::Triangle>{{0, 1, 2}}
                                                      : solid.compound->form().pieces[piece].faces;
      for (const auto& [a, b, c] : faces) {
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
    default:  // not of kOracleShapes
      CDB_CHECK(false);
  }
  return std::max(0.0, outside);
}

struct OracleBody {
  const objects::Solid& solid;
  const objects::Pose& pose;
  std::size_t piece = 0;
};

/// The gap of two convex pieces along a unit vector from b to a; negative if they overlap along it.
inline double GapAlong(const OracleBody& a, const OracleBody& b, const Eigen::Vector3d& normal) {
  return normal.dot(a.pose.position - b.pose.position) -
         HeightOf(a.solid, a.piece, a.pose.orientation, -normal) -
         HeightOf(b.solid, b.piece, b.pose.orientation, normal);
}

struct OracleGap {
  double gap = INFINITY;  ///< m: the signed distance, or slightly less
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();
  std::size_t piece_a = 0, piece_b = 0;
};

/// Follows the gap uphill from `best`: J. A. Nelder, R. Mead, A simplex method for function
/// minimization, The Computer Journal 7 (1965), in the tangent plane, with restarts.
inline void FollowUphill(const OracleBody& a, const OracleBody& b, OracleGap& best) {
  for (const double width : {0.05, 0.02, 1e-3, 1e-5}) {
    const Eigen::Vector3d centre = best.normal, u = centre.unitOrthogonal(), v = centre.cross(u);
    using Vertex = std::pair<double, Eigen::Vector2d>;  // minus the gap, the place
    const auto at = [&](const Eigen::Vector2d& place) {
      const Eigen::Vector3d normal = (centre + place.x() * u + place.y() * v).normalized();
      const double gap = GapAlong(a, b, normal);
      if (gap > best.gap) std::tie(best.gap, best.normal) = std::pair(gap, normal);
      return Vertex{-gap, place};
    };
    std::array<Vertex, 3> simplex = {at({width, 0}), at({-width / 2, 0.8 * width}),
                                     at({-width / 2, -0.8 * width})};
    const auto by_value = [](const Vertex& one, const Vertex& other) {
      return one.first < other.first;
    };
    for (int step = 0; step < 150; ++step) {
      std::sort(simplex.begin(), simplex.end(), by_value);
      const Eigen::Vector2d middle = (simplex[0].second + simplex[1].second) / 2,
                            way = middle - simplex[2].second;
      if (way.norm() < 1e-10) break;
      Vertex next = at(middle + way);
      if (next.first < simplex[0].first) {
        next = std::min(next, at(middle + 2 * way), by_value);
      } else if (next.first >= simplex[1].first) {
        next = at(middle + (next.first < simplex[2].first ? 0.5 : -0.5) * way);
        if (next.first >= simplex[2].first)
          for (std::size_t i : {1u, 2u})
            simplex[i] = at((simplex[0].second + simplex[i].second) / 2);
      }
      simplex[2] = std::min(simplex[2], next, by_value);
    }
  }
}

/// The largest gap of two convex pieces over all directions: uphill from the best of a spiral over
/// the sphere, unless it is more than `most` there.
inline OracleGap LargestGap(const OracleBody& a, const OracleBody& b, double most) {
  constexpr int kDirections = 1000, kStarts = 12;
  std::vector<OracleGap> found;
  for (int i = 0; i < kDirections; ++i) {
    const double y = 1 - (2 * i + 1.0) / kDirections, across = std::sqrt(1 - y * y);
    const double turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Eigen::Vector3d normal(across * std::cos(turn), y, across * std::sin(turn));
    found.push_back({GapAlong(a, b, normal), normal, a.piece, b.piece});
  }
  const auto greater = [](const auto& one, const auto& other) { return one.gap > other.gap; };
  std::partial_sort(found.begin(), found.begin() + kStarts, found.end(), greater);
  found.resize(kStarts);
  if (found[0].gap > most) return found[0];
  for (OracleGap& start : found) FollowUphill(a, b, start);
  return *std::min_element(found.begin(), found.end(), greater);
}

inline Eigen::Vector3d CentreOf(const OracleBody& body) {
  if (body.solid.compound == nullptr) return body.pose.position;
  return body.pose.position + body.pose.orientation * body.solid.compound->PieceCentre(body.piece);
}

/// The signed distance of two solids: the least of any two of their pieces. Exact to about a
/// millionth of their size, and never more.
inline OracleGap SearchedGap(const objects::Solid& a, const objects::Pose& pose_a,
                             const objects::Solid& b, const objects::Pose& pose_b) {
  OracleGap least;
  for (std::size_t i = 0; i < a.PieceCount(); ++i)
    for (std::size_t j = 0; j < b.PieceCount(); ++j) {
      const OracleBody piece_a{a, pose_a, i}, piece_b{b, pose_b, j};
      const Eigen::Vector3d between = CentreOf(piece_a) - CentreOf(piece_b);
      if (between.norm() > 0 && GapAlong(piece_a, piece_b, between.normalized()) > least.gap)
        continue;
      const OracleGap gap = LargestGap(piece_a, piece_b, least.gap);
      if (gap.gap < least.gap) least = gap;
    }
  return least;
}

}  // namespace cdb::tests
