// Checks whether bodies move according to their velocities. Bullet adds v dt to a position and g dt
// to a velocity in its own precision; for distant or fast bodies, the result can be too small, too
// large or unchanged. An object is frozen if rounding adds or removes more than a tenth of its
// motion.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// The engine must outlive it. Not thread-safe.
class MotionWatch {
 public:
  /// Influences on a body in a cycle, other than gravity.
  enum Touch : char {
    kFree,
    kHeld,    ///< changed its velocity: a contact, a link
    kPushed,  ///< also changed its position: an overlap
  };

  /// `is_driven`: velocities also follow a schedule, so that falls are not checked.
  MotionWatch(world::Engine& engine, bool is_driven);

  /// Call once before the first cycle: displacements are relative to the positions then.
  void Begin();

  /// The results for one cycle; NaN if nothing could be observed.
  struct Seen {
    /// Largest displacement of an object from its position at Begin, before rounding to Bullet's
    /// precision, over the least side of its thinnest convex piece.
    double displacement = 0;
    /// Number of objects for which it is more than a quarter.
    std::int32_t displaced = 0;
    /// Number of frozen objects: by displacement, outside 0.9 .. 1.1 of |v| dt, or by fall, less
    /// than 0.9 of g dt.
    std::int32_t frozen = 0;
    /// Largest displacement of an object added or removed by rounding since it was last pushed,
    /// over its least side.
    double lost_way = 0;
    /// 1 plus the excess of the sum of |dx| along an axis over that of |v| dt, divided by the
    /// latter along the object's fastest axis: the fraction of its motion that rounding adds or
    /// removes. Sums begin when the object was last pushed. Of all objects and axes, the value
    /// farthest from 1. Displacements below a hundredth of the object's least side are ignored:
    /// their loss changes no contact.
    double motion_ratio = std::numeric_limits<double>::quiet_NaN();
    /// Least sum of dv along g over sum of |g| dt since an object's last contact, from four cycles
    /// on. Damped objects are left out.
    double fall_ratio = std::numeric_limits<double>::quiet_NaN();
    /// Least angle turned over |w| dt in this cycle, of objects that turn by more than 0.05 rad.
    double turn_ratio = std::numeric_limits<double>::quiet_NaN();
    /// Rotational energy relative to that at Begin, of objects that have touched nothing since and
    /// have turned by a radian. Of those whose moments of inertia differ and whose spin is not
    /// damped, the value farthest from 1.
    double spin_ratio = std::numeric_limits<double>::quiet_NaN();
  };

  /// Call after each cycle. `touches`: by body, a Touch.
  Seen After(std::span<const char> touches);

 private:
  struct Track {
    Eigen::Vector3d start;  ///< as in the scene, not rounded
    btVector3 position;
    btMatrix3x3 basis;
    btVector3 velocity;
    double least_side;   ///< m, of the object as a whole
    double least_piece;  ///< m, of its thinnest convex piece
    bool is_damped, is_link;
    bool keeps_spin;              ///< because its moments of inertia are equal (a ball), or its
                                  ///< spin is damped, or a torque or force may act on it
    double inverse_mass;          ///< 1/kg
    Eigen::Vector3d inertia;      ///< principal, for 1 kg
    Eigen::Vector3d gone, to_go;  ///< m along each axis since the last push: actual and expected
    double gained, due;           ///< m/s along g since the last contact: actual and expected
    double missed;                ///< m: the displacement due to the difference of the two
    double spin_energy;           ///< J/kg, at Begin
    double turned;                ///< rad, since Begin
    bool was_touched;             ///< since Begin
  };

  /// The motion of a body in a cycle.
  struct Step {
    Eigen::Vector3d way, velocity;
    double speedup;  ///< m/s, along g
    double spin;     ///< rad/s
    bool is_swept;   ///< by ccd: it stops where it hits
  };

  void Forget(Track& track) const;
  void CompareSpin(const btRigidBody& body, double spin, Track& track, Seen& seen) const;
  Step StepOf(const btRigidBody& body, const Track& track) const;
  /// NaN if it turns too little.
  double TurnRatio(const btRigidBody& body, const Track& track, double spin) const;
  /// Return true if the object is frozen.
  bool CompareWay(const Step& step, Track& track, double& worst, Seen& seen) const;
  bool CompareFall(const Step& step, Track& track, Seen& seen) const;

  world::Engine& engine_;
  const bool is_driven_;
  std::vector<Track> tracks_;  ///< by object
};

}  // namespace cdb::probes
