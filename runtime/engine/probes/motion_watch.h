// Checks whether bodies move as their velocities say. Bullet adds v dt to a position and g dt to a
// velocity in its own precision; for distant or fast bodies, the result can be too small, too large
// or unchanged. An object is frozen where rounding gives or takes more than a tenth of its motion.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "runtime/engine/world/engine.h"

namespace cdb::probes {

/// The engine must outlive it. Not for several threads.
class MotionWatch {
 public:
  /// What else than gravity acted on a body in a cycle.
  enum Touch : char {
    kFree,
    kHeld,    ///< changed its velocity: a contact, a link
    kPushed,  ///< moved it besides: an overlap
  };

  /// `is_driven`: velocities follow a schedule besides, so that falls are not looked at.
  MotionWatch(world::Engine& engine, bool is_driven);

  /// Call once before the first cycle: where the objects' ways begin.
  void Begin();

  /// What one cycle showed; NaN where there was nothing to see.
  struct Seen {
    /// Farthest way of an object from its place at Begin, before that was rounded to Bullet's
    /// precision, over the least side of its thinnest convex piece.
    double displacement = 0;
    /// Objects that are frozen: by their way, outside 0.9 .. 1.1 of |v| dt, or by their fall, less
    /// than 0.9 of g dt.
    std::int32_t frozen = 0;
    /// Largest way that rounding gave or took of an object since it was last pushed, over its least
    /// side.
    double lost_way = 0;
    /// 1 and what the sum of |dx| along an axis is more than that of |v| dt, over the latter along
    /// the object's fastest axis: how much of its way rounding gives or takes. Since the object was
    /// last pushed; of all objects and axes the one farthest from 1. Ways below a hundredth of the
    /// object's least side are not looked at: losses of them change no contact.
    double motion_ratio = std::numeric_limits<double>::quiet_NaN();
    /// Least sum of dv along g over sum of |g| dt since an object's last contact, from four cycles
    /// on. Not of objects that are damped.
    double fall_ratio = std::numeric_limits<double>::quiet_NaN();
    /// Least angle turned over |w| dt in this cycle, of objects that turn by more than 0.05 rad.
    double turn_ratio = std::numeric_limits<double>::quiet_NaN();
    /// Energy of turning over that at Begin, of objects that have touched nothing since and have
    /// turned by a radian; of those whose moments of inertia differ and whose spin is not damped,
    /// the one farthest from 1.
    double spin_ratio = std::numeric_limits<double>::quiet_NaN();
  };

  /// Call after each cycle. `touches`: by body, a Touch.
  Seen After(std::span<const char> touches);

 private:
  struct Track {
    Eigen::Vector3d start;  ///< as the scene has it, not rounded
    btVector3 position;
    btMatrix3x3 basis;
    btVector3 velocity;
    double least_side;   ///< m, of the object as a whole
    double least_piece;  ///< m, of its thinnest convex piece
    bool is_damped;
    bool keeps_spin;              ///< whatever its moments of inertia: a ball, or damped
    Eigen::Vector3d inertia;      ///< principal, for 1 kg
    Eigen::Vector3d gone, to_go;  ///< since the last contact, along each axis
    double gained, due;           ///< m/s, along g, since the last contact
    double missed;                ///< m: the way that the difference of the two makes
    double spin_energy;           ///< J/kg, at Begin
    double turned;                ///< rad, since Begin
    bool was_touched;             ///< since Begin
  };

  /// What a body did in a cycle.
  struct Step {
    Eigen::Vector3d way, velocity;
    double speedup;  ///< m/s, along g
    double spin;     ///< rad/s
    bool is_swept;   ///< by ccd: it stops where it hits
  };

  void Forget(Track& track) const;
  void CompareSpin(const btRigidBody& body, double spin, Track& track, Seen& seen) const;
  Step StepOf(const btRigidBody& body, const Track& track) const;
  /// NaN where it turns too little.
  double TurnRatio(const btRigidBody& body, const Track& track, double spin) const;
  /// Return whether the object is frozen.
  bool CompareWay(const Step& step, Track& track, double& worst, Seen& seen) const;
  bool CompareFall(const Step& step, Track& track, Seen& seen) const;

  world::Engine& engine_;
  const bool is_driven_;
  std::vector<Track> tracks_;  ///< by object
};

}  // namespace cdb::probes
