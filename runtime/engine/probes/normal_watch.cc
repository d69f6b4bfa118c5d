#include "runtime/engine/probes/normal_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "library/exact/legal_normals.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

// Found by measurement.
/// Sine of the angle to the nearest legal normal from which on a normal is false.
constexpr double kFalseAngle = 0.02;
/// Of an object's momentum: a tenth of the energy of its motion, as in the verdict of lost energy.
constexpr double kDeflects = 0.05;
/// Of an object's least side: the fall that gives it the least momentum that counts.
constexpr double kScaleFall = 0.01;
/// A contact point lies on the triangles within this part of the surface's longest side and twice
/// the depth, of which no more counts than this part of the object's least side.
constexpr double kOnSurface = 1e-5, kMostDepth = 0.1;
/// Around a contact with a solid, other solids are looked for within this part of its least side,
/// or this many times the precision of its place.
constexpr double kBeside = 1e-3, kLeastBeside = 50;
/// Bullet rounds edges by its collision margin: a contact with one lies within this many margins.
constexpr double kRounding = 2;
/// rad: directions that differ by less have the same face or edge.
constexpr double kLevel = 1e-3;
constexpr int kAzimuths = 16;

bool IsSolidGround(const layouts::ObjectState& state) {
  return state.IsFixed() && !state.is_kinematic && !state.solid.IsSurface();
}

/// m: Bullet computes contact points in the world, in its own precision.
double PrecisionAt(const layouts::ObjectState& state) {
  return 8 * static_cast<double>(SIMD_EPSILON) *
         (state.pose.position.norm() + state.solid.OuterRadius());
}

/// The point nearest to `point` of those of a piece that are farthest along `normal`, within
/// kLevel, in world axes.
Vector3d NearestOfSupport(const layouts::ObjectState& state, std::size_t piece,
                          const Vector3d& point, const Vector3d& normal) {
  const Eigen::Quaterniond& turn = state.pose.orientation;
  const Vector3d target = turn.conjugate() * (point - state.pose.position),
                 up = turn.conjugate() * normal, across = up.unitOrthogonal();
  std::vector<Vector3d> corners;
  for (int i = 0; i < kAzimuths; ++i)
    corners.push_back(state.solid.PieceSupport(
        piece, up + kLevel * (Eigen::AngleAxisd(2 * M_PI * i / kAzimuths, up) * across)));
  // By conditional gradients (Frank and Wolfe 1956); on an edge, the second step is exact.
  Vector3d nearest = corners[0];
  for (int i = 0; i < 4 * kAzimuths; ++i) {
    const Vector3d& next = *std::ranges::max_element(
        corners, {}, [&](const Vector3d& corner) { return corner.dot(target - nearest); });
    const double length = (next - nearest).squaredNorm();
    if (length == 0) break;
    nearest +=
        std::clamp((target - nearest).dot(next - nearest) / length, 0.0, 1.0) * (next - nearest);
  }
  return state.pose.position + turn * nearest;
}

/// The box of a piece of a solid in the world.
Eigen::AlignedBox3d BoxOf(const layouts::ObjectState& state, std::size_t piece) {
  const Eigen::Matrix3d turn = state.pose.orientation.toRotationMatrix();
  Eigen::AlignedBox3d box;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d direction = sign * turn.row(axis).transpose();
      box.extend(state.pose.position + turn * state.solid.PieceSupport(piece, direction));
    }
  return box;
}

}  // namespace

NormalWatch::NormalWatch(world::Engine& engine) : engine_(engine) {
  const double pull = engine.acceleration().norm();
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const layouts::ObjectState& object : engine.initial_state().objects) {
    if (IsSolidGround(object))
      for (std::size_t piece = 0; piece < object.solid.PieceCount(); ++piece) {
        pieces_.push_back({objects_.size(), piece});
        boxes.push_back(BoxOf(object, piece));
      }
    has_surfaces_ = has_surfaces_ || object.solid.IsSurface();
    const double side = 2 * object.solid.LeastHalfExtent();
    // Without gravity, that of moving by a tenth of its side per second.
    const double least = std::max(std::sqrt(2 * pull * kScaleFall * side), 0.1 * side);
    objects_.push_back({object.IsFixed() ? 0 : object.mass, least, Vector3d::Zero(), false});
  }
  if (boxes.size() > 1) tree_.emplace(std::move(boxes));
}

NormalWatch::Seen NormalWatch::After(const BodyStates& before, const BodyStates& now) {
  Seen seen = {};
  if (!has_surfaces_ && !tree_) return seen;
  for (std::size_t i = 0; i < objects_.size(); ++i)
    objects_[i].speed = std::max({objects_[i].speed, world::ToEigen(before[i].velocity).norm(),
                                  world::ToEigen(now[i].velocity).norm()});
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world()))
    Check(manifold, now, seen);
  for (Moving& object : objects_) {
    const double most = kDeflects * object.mass * object.speed;
    object.is_deflected = object.is_deflected || object.impulse.norm() > most;
    seen.deflected += object.is_deflected;
  }
  return seen;
}

void NormalWatch::Check(const btPersistentManifold& manifold, const BodyStates& now, Seen& seen) {
  const auto index = [](const btCollisionObject* body) {
    return static_cast<std::size_t>(body->getUserIndex());
  };
  const std::size_t a = index(manifold.getBody0()), b = index(manifold.getBody1());
  if (a >= objects_.size() || b >= objects_.size()) return;  // a wall
  const auto& state = engine_.initial_state().objects;
  const auto is_ground = [&](std::size_t object) {
    return state[object].solid.IsSurface() || (tree_ && IsSolidGround(state[object]));
  };
  const bool is_first = is_ground(a);
  if (!is_first && !is_ground(b)) return;
  const std::size_t ground = is_first ? a : b, other = is_first ? b : a;
  // The contacts of objects that sleep keep their last impulse.
  if (objects_[other].mass == 0 || now[other].is_asleep) return;
  const double most_depth = kMostDepth * 2 * state[other].solid.LeastHalfExtent();
  for (int j = 0; j < manifold.getNumContacts(); ++j) {
    const btManifoldPoint& point = manifold.getContactPoint(j);
    if (!world::HasImpulse(manifold, point)) continue;
    const double impulse = static_cast<double>(point.m_appliedImpulse);
    const Vector3d normal =
        ((is_first ? -1.0 : 1.0) * world::ToEigen(point.m_normalWorldOnB)).normalized();
    const double depth =
        2 * std::min(std::abs(static_cast<double>(point.getDistance())), most_depth);
    const auto legal =
        state[ground].solid.IsSurface()
            ? LegalOnSurface(ground,
                             world::ToEigen(is_first ? point.m_localPointA : point.m_localPointB),
                             normal, depth)
            : LegalOnSolid(
                  ground,
                  world::ToEigen(is_first ? point.getPositionWorldOnA()
                                          : point.getPositionWorldOnB()),
                  normal, point.getDistance() < 0 ? depth : 0,
                  static_cast<double>((is_first ? manifold.getBody0() : manifold.getBody1())
                                          ->getCollisionShape()
                                          ->getMargin()));
    if (!legal) continue;
    const Vector3d across = normal - std::max(0.0, normal.dot(*legal)) * *legal;
    if (across.norm() <= kFalseAngle) continue;
    ++seen.false_normals;
    seen.false_impulse += impulse * across.norm();
    objects_[other].impulse += impulse * across;
  }
}

std::optional<Vector3d> NormalWatch::LegalOnSurface(std::size_t surface, const Vector3d& place,
                                                    const Vector3d& normal, double depth) const {
  const layouts::ObjectState& state = engine_.initial_state().objects[surface];
  const objects::Compound& triangles = *state.solid.compound;
  const Eigen::Quaterniond& turn = state.pose.orientation;
  const double reach = kOnSurface * triangles.sides().maxCoeff() + PrecisionAt(state) + depth;
  auto legal = exact::NearestLegalNormal(triangles, place, turn.conjugate() * normal, reach);
  if (legal) *legal = turn * *legal;
  return legal;
}

std::optional<Vector3d> NormalWatch::LegalOnSolid(std::size_t object, const Vector3d& point,
                                                  const Vector3d& normal, double depth,
                                                  double margin) const {
  const layouts::ObjectState& state = engine_.initial_state().objects[object];
  const double precision = PrecisionAt(state);
  const double radius =
      std::max(kBeside * 2 * state.solid.LeastHalfExtent(), kLeastBeside * precision);
  const double reach = radius + depth;
  // The piece that has the contact, and those around it.
  const Vector3d half = Vector3d::Constant(kRounding * margin + reach + 4 * radius);
  std::vector<FixedPiece> others;
  std::optional<FixedPiece> own;
  double least = std::numeric_limits<double>::infinity();
  tree_->AnyOf({point - half, point + half}, [&](std::size_t index) {
    const FixedPiece& piece = pieces_[index];
    if (piece.object == object) {
      const Vector3d in_body = state.pose.orientation.conjugate() * normal;
      const double beyond = std::abs(in_body.dot(state.solid.PieceSupport(piece.piece, in_body)) -
                                     normal.dot(point - state.pose.position));
      if (beyond < least) {
        least = beyond;
        if (own) others.push_back(*own);
        own = piece;
        return false;
      }
    }
    others.push_back(piece);
    return false;
  });
  if (!own) return std::nullopt;
  if (others.empty()) return normal;
  const double rounding = kRounding * margin + reach;
  Vector3d contact = point;
  if (least > reach)
    if (const Vector3d edge = NearestOfSupport(state, own->piece, point, normal);
        (edge - point).norm() <= rounding)
      contact = edge;
  return exact::NearestLegalNormal(
      [&](const Vector3d& place) { return Contains(*own, place); },
      [&](const Vector3d& place) {
        return std::ranges::any_of(others,
                                   [&](const FixedPiece& piece) { return Contains(piece, place); });
      },
      contact, normal, reach, radius);
}

bool NormalWatch::Contains(const FixedPiece& piece, const Vector3d& point) const {
  const layouts::ObjectState& state = engine_.initial_state().objects[piece.object];
  return state.solid.PieceContains(
      piece.piece, state.pose.orientation.conjugate() * (point - state.pose.position));
}

}  // namespace cdb::probes
