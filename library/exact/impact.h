// Impacts of rigid bodies by their shapes, velocities and coefficients: where two solids touch, in
// which points, and the velocities that follow. In double, without any physics engine.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "library/exact/passage.h"
#include "library/exact/signed_distance.h"
#include "library/objects/solid.h"

namespace cdb::exact {

/// One of the two: a solid with its motion, or a half space, which does not move.
struct Collider {
  const objects::Solid* solid = nullptr;  ///< null: a half space
  Motion motion;
  HalfSpace plane = {Eigen::Vector3d::UnitY(), 0};
};

struct Touch {
  double part = 0;         ///< of the cycle: 0 at the pose `from` of its motion
  Eigen::Vector3d normal;  ///< unit, from b to a
  Eigen::Vector3d point;   ///< m
};

/// The first touch of two solids, neither a surface, between two parts of a cycle, which may lie
/// before and after it: where their distance is less than a ten-thousandth of the lesser least
/// side. None if they overlap by more at the first, or do not touch. Threads: any. Source: Newton's
/// method on the distance, which along a straight path does not overshoot.
std::optional<Touch> FindTouch(const objects::Solid& a, const Motion& motion, const Collider& b,
                               double from, double to);

/// The corners (m) of the region in which two convex solids would touch if they could turn by
/// `tilt` (rad): one for curved surfaces and corners, two for lines, more for faces; empty if none
/// is found. `touch`: in this point, at these poses. Curved faces are polygons of 12 corners.
/// Threads: any.
std::vector<Eigen::Vector3d> ContactRegion(const objects::Solid& a, const objects::Pose& pose_a,
                                           const objects::Solid* b, const objects::Pose& pose_b,
                                           const Touch& touch, double tilt);

struct ImpactBody {
  double inverse_mass = 0;                                    ///< 1/kg; 0: nothing moves it
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  ///< 1/(kg m^2), in world axes
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();           ///< m, of mass
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();         ///< m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();             ///< rad/s
};

struct ImpactContact {
  std::size_t a = 0, b = 0;  ///< bodies
  Eigen::Vector3d normal;    ///< unit, from b to a
  Eigen::Vector3d point;     ///< m
  double friction = 0;       ///< coefficient
  double rebound = 0;        ///< m/s: the least speed of separation
};

/// The velocity of a point of a body, m/s.
Eigen::Vector3d VelocityAt(const ImpactBody& body, const Eigen::Vector3d& point);

/// The direction of friction in an impact. The two differ only where the yield of the bodies turns
/// the sliding, as at the corner of a box; rigid bodies have neither exactly.
enum class Slip {
  kLeft,   ///< against the motion that is left; it stops all sliding if the coefficient is enough
  kFirst,  ///< along that before the impact only
};

/// Gives the bodies the velocities after impacts in all contacts at once: each separates at its
/// rebound or faster, with Coulomb's friction. Threads: any. Source: J. J. Moreau, Unilateral
/// contact and dry friction in finite freedom dynamics, 1988, with Newton's restitution; solved by
/// Gauss-Seidel iterations over the contacts.
void SolveImpact(std::span<ImpactBody> bodies, std::span<const ImpactContact> contacts, Slip slip);

/// Two bodies from the moment on at which they touch, alone, with a constant acceleration: whatever
/// impacts follow, in steps of a fraction of a cycle. For bodies that land nearly flat, whose
/// corners touch one after the other. Not thread-safe.
class ImpactCourse {
 public:
  struct Body {
    const objects::Solid* solid = nullptr;  ///< convex; null: a half space. Must outlive the course
    objects::Pose pose;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), spin = Eigen::Vector3d::Zero();
    double mass = 0;                                    ///< kg; 0: nothing moves it
    Eigen::Vector3d inertia = Eigen::Vector3d::Zero();  ///< kg m^2, principal
  };
  struct Rules {
    double friction, restitution;
    Eigen::Vector3d acceleration;  ///< m/s^2
    Slip slip;
    HalfSpace plane;  ///< of b, if it has no solid
  };
  ImpactCourse(const Body& a, const Body& b, const Rules& rules) : a_(a), b_(b), rules_(rules) {}

  /// Accuracy: the next impact may be late by a step.
  void Advance(double duration, int steps);
  /// As at present.
  ImpactBody a() const { return StateOf(a_); }
  ImpactBody b() const { return StateOf(b_); }

 private:
  static ImpactBody StateOf(const Body& body);
  void Meet(double step);
  void Move(Body& body, double step) const;

  Body a_, b_;
  Rules rules_;
};

}  // namespace cdb::exact
