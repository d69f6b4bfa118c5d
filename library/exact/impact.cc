#include "library/exact/impact.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

namespace cdb::exact {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using objects::Pose;
using objects::Solid;

/// Of the lesser least side.
constexpr double kTouches = 1e-4;
constexpr int kMostSteps = 100;
/// rad.
constexpr double kMostTurn = 0.1;
constexpr double kFar = std::numeric_limits<double>::infinity();

SignedDistance DistanceOfBalls(const Solid& a, const Vector3d& at_a, const Solid& b,
                               const Vector3d& at_b) {
  const Vector3d way = at_a - at_b;
  const double distance = way.norm(), radius_a = a.sides.x() / 2, radius_b = b.sides.x() / 2;
  SignedDistance result;
  if (distance > 0) result.normal = way / distance;
  result.gap = result.lower = result.upper = distance - radius_a - radius_b;
  result.on_a = at_a - radius_a * result.normal;
  result.on_b = at_b + radius_b * result.normal;
  return result;
}

SignedDistance DistanceAt(const Solid& a, const Motion& motion, const Collider& b, double part) {
  const Pose pose_a = motion.At(part);
  if (b.solid == nullptr) return DistanceOf(a, pose_a, b.plane);
  const Pose pose_b = b.motion.At(part);
  if (a.IsBall() && b.solid->IsBall())
    return DistanceOfBalls(a, pose_a.position, *b.solid, pose_b.position);
  return DistanceOf(a, pose_a, *b.solid, pose_b);
}

/// m per cycle.
Vector3d Rate(const Motion& motion, double part, const Vector3d& point) {
  return motion.way + motion.turn.cross(point - motion.from.position - part * motion.way);
}

}  // namespace

std::optional<Touch> FindTouch(const Solid& a, const Motion& motion, const Collider& b, double from,
                               double to) {
  const double side = 2 * (b.solid ? std::min(a.LeastHalfExtent(), b.solid->LeastHalfExtent())
                                   : a.LeastHalfExtent());
  const double tolerance = kTouches * side;
  double part = from, apart = from;
  for (int step = 0; step < kMostSteps; ++step) {
    const SignedDistance distance = DistanceAt(a, motion, b, part);
    if (distance.gap < -tolerance) {
      if (step == 0) return std::nullopt;
      part = (apart + part) / 2;  // turns may overshoot
      continue;
    }
    if (distance.gap <= tolerance)
      return Touch{part, distance.normal, (distance.on_a + distance.on_b) / 2};
    apart = part;
    Vector3d rate = Rate(motion, part, distance.on_a);
    if (b.solid != nullptr) rate -= Rate(b.motion, part, distance.on_b);
    const double approach = -rate.dot(distance.normal);
    const double turn = motion.turn.norm() + b.motion.turn.norm();
    if (!(approach > 0 || turn > 0)) return std::nullopt;
    // Where they turn, rates last only so long.
    const double room = approach > 0 ? (distance.gap - tolerance / 2) / approach : kFar;
    part += turn > 0 ? std::min(room, kMostTurn / turn) : room;
    if (part > to) return std::nullopt;
  }
  return std::nullopt;
}

namespace {

constexpr int kDirections = 12;
/// Of the least half extent: lines are as thick, so that all regions are polygons.
constexpr double kThickness = 1e-3;
/// Of the least half extent: corners that are closer are one.
constexpr double kSameCorner = 0.01;

using Polygon = std::vector<Vector2d>;

/// The coordinates in a plane, relative to a point.
struct Plane {
  Vector3d origin, x, y;
  Vector2d In(const Vector3d& point) const {
    return {(point - origin).dot(x), (point - origin).dot(y)};
  }
  Vector3d Out(const Vector2d& point) const { return origin + point.x() * x + point.y() * y; }
};

/// Their convex hull, counterclockwise (Andrew's monotone chain).
Polygon Hull(Polygon points) {
  std::ranges::sort(points, [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  Polygon hull;
  for (int side = 0; side < 2; ++side, std::ranges::reverse(points)) {
    const std::size_t first = hull.size();
    for (const Vector2d& point : points) {
      const auto turns_right = [&] {
        const Vector2d from = hull[hull.size() - 2], along = hull.back() - from, to = point - from;
        return along.x() * to.y() - along.y() * to.x() <= 0;
      };
      while (hull.size() > first + 1 && turns_right()) hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
  }
  return hull;
}

/// The point of a solid farthest along a direction that is tilted from `outward`, both in its axes.
/// Of what is round only the core counts, as it touches in one point or line however it turns.
Vector3d CorePoint(const Solid& solid, const Vector3d& outward, double tilt,
                   const Vector3d& direction) {
  const double across = std::hypot(outward.x(), outward.z());
  if (solid.shape == objects::Shape::kCylinder && solid.sides.x() == solid.sides.z() &&
      across > tilt) {
    const Vector3d radius =
        solid.sides.x() / 2 * Vector3d(outward.x(), 0, outward.z()).normalized();
    return radius + std::copysign(solid.sides.y() / 2, direction.y()) * Vector3d::UnitY();
  }
  const double radius = ConvexPart(solid, 0, Matrix3d::Identity(), Vector3d::Zero()).radius();
  return solid.Support(direction) - radius * direction.normalized();
}

/// Counterclockwise: support points along directions around, each a little farther.
Polygon FaceOf(const Solid& solid, const Pose& pose, const Vector3d& outward, double tilt,
               double thickness, const Plane& plane) {
  Polygon face;
  const Eigen::Quaterniond back = pose.orientation.conjugate();
  for (int i = 0; i < kDirections; ++i) {
    // Not along the axes, where faces have their edges.
    const double angle = 2 * std::numbers::pi * (i + 0.37) / kDirections;
    const Vector2d way(std::cos(angle), std::sin(angle));
    const Vector3d direction = outward + tilt * (way.x() * plane.x + way.y() * plane.y);
    const Vector3d corner =
        pose.position + pose.orientation * CorePoint(solid, back * outward, tilt, back * direction);
    face.push_back(plane.In(corner) + thickness * way);
  }
  return Hull(std::move(face));
}

/// The part of a polygon in a convex one, both counterclockwise (Sutherland and Hodgman).
Polygon Clip(Polygon polygon, const Polygon& by) {
  for (std::size_t i = 0; i < by.size() && !polygon.empty(); ++i) {
    const Vector2d from = by[i], along = by[(i + 1) % by.size()] - from;
    const auto inside = [&](const Vector2d& point) {
      return along.x() * (point.y() - from.y()) - along.y() * (point.x() - from.x());
    };
    Polygon kept;
    for (std::size_t j = 0; j < polygon.size(); ++j) {
      const Vector2d &here = polygon[j], &next = polygon[(j + 1) % polygon.size()];
      const double at_here = inside(here), at_next = inside(next);
      if (at_here >= 0) kept.push_back(here);
      if ((at_here < 0) != (at_next < 0))
        kept.push_back(here + at_here / (at_here - at_next) * (next - here));
    }
    polygon = std::move(kept);
  }
  return polygon;
}

}  // namespace

std::vector<Vector3d> ContactRegion(const Solid& a, const Pose& pose_a, const Solid* b,
                                    const Pose& pose_b, const Touch& touch, double tilt) {
  const Vector3d x = touch.normal.unitOrthogonal();
  const Plane plane{touch.point, x, touch.normal.cross(x)};
  const double least =
      b ? std::min(a.LeastHalfExtent(), b->LeastHalfExtent()) : a.LeastHalfExtent();
  Polygon region = FaceOf(a, pose_a, -touch.normal, tilt, kThickness * least, plane);
  if (b != nullptr)
    region =
        Clip(std::move(region), FaceOf(*b, pose_b, touch.normal, tilt, kThickness * least, plane));
  std::vector<Vector3d> corners;
  for (const Vector2d& point : region) {
    const Vector3d corner = plane.Out(point);
    if (std::ranges::none_of(corners, [&](const Vector3d& other) {
          return (other - corner).norm() < kSameCorner * least;
        }))
      corners.push_back(corner);
  }
  return corners;
}

namespace {

constexpr int kMostRounds = 400;
/// rad: the accuracy of the direction of friction.
constexpr double kSameSlip = 1e-6;
/// rad: where the secant method takes its second angle.
constexpr double kNearby = 1e-3;
constexpr int kMostSecants = 12;
/// The cosine from which on friction is nearly against the motion.
constexpr double kNearlyAgainst = 0.9;
/// Of the largest impulse: changes below it end the iterations.
constexpr double kSettled = 1e-7;

Matrix3d Cross(const Vector3d& v) {
  Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

/// The change of velocity of a point by an impulse there.
Matrix3d Yield(const ImpactBody& body, const Vector3d& point) {
  const Matrix3d arm = Cross(point - body.centre);
  return body.inverse_mass * Matrix3d::Identity() - arm * body.inverse_inertia * arm;
}

void Push(ImpactBody& body, const Vector3d& point, const Vector3d& impulse) {
  body.velocity += body.inverse_mass * impulse;
  body.spin += body.inverse_inertia * (point - body.centre).cross(impulse);
}

/// The impulse of one contact that moves its point at `free` without it, with friction along a unit
/// vector.
Vector3d ImpulseAlong(const Vector3d& slip, const ImpactContact& contact, const Matrix3d& yield,
                      const Vector3d& free) {
  const Vector3d& n = contact.normal;
  if (free.dot(n) >= contact.rebound) return Vector3d::Zero();
  Eigen::Matrix<double, 3, 2> axes;
  axes << n, slip;
  const Eigen::Matrix2d inner = axes.transpose() * yield * axes;
  const Vector2d sticks =
      inner.inverse() * Vector2d(contact.rebound - free.dot(n), -free.dot(slip));
  if (sticks.x() > 0 && std::abs(sticks.y()) <= contact.friction * sticks.x()) return axes * sticks;
  const Vector3d unit = n + std::copysign(contact.friction, sticks.y()) * slip;
  const double gain = n.dot(yield * unit);
  return gain > 0 ? Vector3d((contact.rebound - free.dot(n)) / gain * unit) : Vector3d::Zero();
}

/// The impulse of a contact with friction in any direction, found anew for each motion of its point
/// that the other contacts leave.
class SlidingContact {
 public:
  SlidingContact(const ImpactContact& contact, const Matrix3d& yield)
      : contact_(contact),
        inverse_(yield.inverse()),
        axes_(Axes(contact.normal)),
        along_(axes_.transpose() * yield * axes_) {}

  /// `free`: the motion of the point without this contact.
  Vector3d ImpulseFor(const Vector3d& free) {
    const Vector3d& n = contact_.normal;
    if (free.dot(n) >= contact_.rebound) return Vector3d::Zero();
    const Vector3d sticks = axes_.transpose() * (inverse_ * (contact_.rebound * n - free));
    if (sticks.x() > 0 && sticks.tail<2>().norm() <= contact_.friction * sticks.x())
      return axes_ * sticks;
    free_ = axes_.transpose() * free;
    if (contact_.friction == 0) return axes_ * At(way_).impulse;
    if (!Refine()) Search(sticks.tail<2>());
    return axes_ * At(way_).impulse;
  }

 private:
  struct Slide {
    double cosine = -2;  ///< of the angle between friction and what it opposes: -2 if it is none
    double sine = 0;     ///< of the same
    Vector3d impulse = Vector3d::Zero();  ///< in axes_
  };

  /// The normal, and two across it.
  static Matrix3d Axes(const Vector3d& n) {
    Matrix3d axes;
    axes.col(0) = n;
    axes.col(1) = n.unitOrthogonal();
    axes.col(2) = n.cross(Vector3d(axes.col(1)));
    return axes;
  }

  static Vector2d Across(const Vector2d& way) { return {-way.y(), way.x()}; }

  /// With friction along a unit vector across the normal.
  Slide At(const Vector2d& way) const {
    const Vector3d unit(1, contact_.friction * way.x(), contact_.friction * way.y());
    const double gain = along_.row(0).dot(unit);
    if (!(gain > 0)) return {};
    Slide slide{1, 0, (contact_.rebound - free_.x()) / gain * unit};
    const Vector2d left = (free_ + along_ * slide.impulse).tail<2>();
    const double speed = left.norm();
    if (speed > 0) {
      slide.cosine = -way.dot(left) / speed;
      slide.sine = -Across(way).dot(left) / speed;
    }
    return slide;
  }

  /// From the direction of last time, by the secant method; false if that does not lead to one.
  bool Refine() {
    const Vector2d from = way_, across = Across(way_);
    const auto turned = [&](double tangent) {
      return Vector2d((from + tangent * across).normalized());
    };
    double before = kNearby, here = 0;
    Slide at_before = At(turned(before)), at_here = At(from);
    for (int step = 0; step < kMostSecants; ++step) {
      if (at_here.cosine < kNearlyAgainst || at_before.sine == at_here.sine) return false;
      const double next = here - at_here.sine * (here - before) / (at_here.sine - at_before.sine);
      way_ = turned(next);
      if (std::abs(next - here) <= kSameSlip) return true;
      before = std::exchange(here, next);
      at_before = std::exchange(at_here, At(way_));
    }
    return false;
  }

  /// From that in which it would stick.
  void Search(const Vector2d& sticks) {
    way_ = sticks.normalized();
    double cosine = At(way_).cosine;
    const auto seek = [&](double turn) {
      const Vector2d way = Eigen::Rotation2Dd(turn) * way_;
      const double found = At(way).cosine;
      if (found <= cosine) return false;
      way_ = way;
      cosine = found;
      return true;
    };
    for (double step = std::numbers::pi / 8; step > kSameSlip; step /= 2) {
      while (seek(step)) {
      }
      while (seek(-step)) {
      }
    }
  }

  const ImpactContact& contact_;
  Matrix3d inverse_, axes_;
  Matrix3d along_;                    ///< the yield in axes_
  Vector3d free_ = Vector3d::Zero();  ///< in axes_
  Vector2d way_ = Vector2d::UnitX();  ///< of friction, last time: a unit vector
};

}  // namespace

Vector3d VelocityAt(const ImpactBody& body, const Vector3d& point) {
  return body.velocity + body.spin.cross(point - body.centre);
}

void SolveImpact(std::span<ImpactBody> bodies, std::span<const ImpactContact> contacts, Slip slip) {
  struct Row {
    Matrix3d yield;
    SlidingContact sliding;
    Vector3d first;  ///< unit: the direction of sliding
    Vector3d impulse = Vector3d::Zero();
  };
  std::vector<Row> rows;
  for (const ImpactContact& contact : contacts) {
    const Matrix3d yield =
        Yield(bodies[contact.a], contact.point) + Yield(bodies[contact.b], contact.point);
    const Vector3d motion =
        VelocityAt(bodies[contact.a], contact.point) - VelocityAt(bodies[contact.b], contact.point);
    const Vector3d across = motion - motion.dot(contact.normal) * contact.normal;
    rows.push_back({yield, SlidingContact(contact, yield),
                    across.norm() > 0 ? across.normalized() : contact.normal.unitOrthogonal()});
  }
  for (int round = 0; round < kMostRounds; ++round) {
    double largest = 0, change = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const ImpactContact& contact = contacts[i];
      ImpactBody &a = bodies[contact.a], &b = bodies[contact.b];
      Row& row = rows[i];
      const Vector3d free =
          VelocityAt(a, contact.point) - VelocityAt(b, contact.point) - row.yield * row.impulse;
      const Vector3d impulse = slip == Slip::kFirst
                                   ? ImpulseAlong(row.first, contact, row.yield, free)
                                   : row.sliding.ImpulseFor(free);
      const Vector3d added = impulse - row.impulse;
      Push(a, contact.point, added);
      Push(b, contact.point, -added);
      row.impulse = impulse;
      largest = std::max(largest, impulse.norm());
      change = std::max(change, added.norm());
    }
    if (change <= kSettled * largest) break;
  }
}

namespace {

/// In least sides: they touch if they are no farther apart.
constexpr double kTouching = 1e-3;
/// In steps: points that follow within this time touch at once.
constexpr double kSameStep = 1;

}  // namespace

ImpactBody ImpactCourse::StateOf(const Body& body) {
  ImpactBody state;
  state.centre = body.pose.position;
  state.velocity = body.velocity;
  state.spin = body.spin;
  if (!(body.mass > 0)) return state;
  state.inverse_mass = 1 / body.mass;
  const Matrix3d turn = body.pose.orientation.toRotationMatrix();
  state.inverse_inertia = turn * body.inertia.cwiseInverse().asDiagonal() * turn.transpose();
  return state;
}

void ImpactCourse::Advance(double duration, int steps) {
  for (int i = 0; i < steps; ++i) {
    Meet(duration / steps);
    Move(a_, duration / steps);
    Move(b_, duration / steps);
  }
}

void ImpactCourse::Meet(double step) {
  const double least = b_.solid ? std::min(a_.solid->LeastHalfExtent(), b_.solid->LeastHalfExtent())
                                : a_.solid->LeastHalfExtent();
  const SignedDistance distance =
      DistanceAt(*a_.solid, {a_.pose}, {b_.solid, {b_.pose}, rules_.plane}, 0);
  if (distance.gap > 2 * kTouching * least) return;
  ImpactBody bodies[] = {a(), b()};
  const auto approach = [&](const Vector3d& point) {
    return -(VelocityAt(bodies[0], point) - VelocityAt(bodies[1], point)).dot(distance.normal);
  };
  const Touch touch{0, distance.normal, (distance.on_a + distance.on_b) / 2};
  const double tilt = kTouching + kSameStep * std::max(0.0, approach(touch.point)) * step / least;
  std::vector<Vector3d> points = ContactRegion(*a_.solid, a_.pose, b_.solid, b_.pose, touch, tilt);
  if (points.empty()) points = {touch.point};
  std::vector<ImpactContact> contacts;
  for (const Vector3d& point : points)
    contacts.push_back({0, 1, touch.normal, point, rules_.friction,
                        rules_.restitution * std::max(0.0, approach(point))});
  SolveImpact(bodies, contacts, rules_.slip);
  for (Body* body : {&a_, &b_}) {
    body->velocity = bodies[body == &a_ ? 0 : 1].velocity;
    body->spin = bodies[body == &a_ ? 0 : 1].spin;
  }
}

/// Free flight keeps the angular momentum.
void ImpactCourse::Move(Body& body, double step) const {
  const Motion motion{body.pose, step * body.velocity, step * body.spin};
  if (body.mass > 0) {
    const Eigen::Quaterniond before = body.pose.orientation, after = motion.At(1).orientation;
    const Vector3d momentum = before * body.inertia.cwiseProduct(before.conjugate() * body.spin);
    body.spin = after * (after.conjugate() * momentum).cwiseQuotient(body.inertia);
    body.velocity += step * rules_.acceleration;
  }
  body.pose = motion.At(1);
}

}  // namespace cdb::exact
