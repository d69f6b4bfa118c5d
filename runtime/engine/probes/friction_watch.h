// Finds objects that slide on a flat face otherwise than friction lets them: Bullet may support a
// box on a plane at one corner at a time, so that it rocks, turns, and is braked too much or too
// little.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/probes/body_states.h"
#include "runtime/engine/world/coefficients.h"

namespace cdb::probes {

// What pushes each object in a cycle.

/// rad: normals that differ by less are the same.
inline constexpr double kSameNormal = 0.05;

struct Support {
  const btCollisionObject* ground = nullptr;  ///< null: nothing pushes the object
  btVector3 normal;                           ///< unit, of one contact, towards the object
  bool is_single = true;                      ///< all contacts are with `ground`, and along it
};

/// By the impulses of Bullet's contacts. The engine must outlive it. Not thread-safe.
class Supports {
 public:
  explicit Supports(world::Engine& engine);

  /// Whether the scene has walls or fixed objects that are not kinematic. Without them, there are
  /// no supports.
  bool has_ground() const { return has_ground_; }
  /// Call after each cycle.
  void Find();
  const Support& Of(std::size_t object) const { return supports_[object]; }

 private:
  world::Engine& engine_;
  bool has_ground_ = false;
  std::vector<Support> supports_;  ///< by object
};

/// Judged are objects that lie flat on one fixed body, a wall or an object, and touch nothing else:
/// a face is within 0.05 rad of the ground, and reaches around the centre of mass by a tenth of the
/// least half extent. The ground pushes along its normal n, wherever it does, and friction, mu of
/// the scene times that, acts against the velocity. So
///
/// - the spin about n does not grow, but for mu times what the rocking changes: the forces that
/// turn
///   the object about its direction of motion are those whose friction turns it about n. That
///   excuses mu times the rocking with which it came to lie flat, and mu times the tilt since then;
/// - the velocity along the ground changes by mu times the change of that along n, or to 0.
///
/// All of it from velocities and the scene's coefficients, not from Bullet's contacts, which only
/// tell what touches. Not judged: objects with links, on surfaces and kinematic objects, and the
/// second law while an object spins. The engine must outlive it. Not thread-safe.
class FrictionWatch {
 public:
  /// `coefficients` must outlive it.
  FrictionWatch(world::Engine& engine, const world::Coefficients& coefficients);

  struct Seen {
    double false_turn;      ///< rad: the largest angle turned so far against the first law
    std::int32_t twisted;   ///< objects so far with an angle above kTwisted
    double friction_error;  ///< largest deviation from the second law so far, relative to the
                            ///< change of velocity that it demands; NaN if nothing slid
  };
  /// Call after each cycle, with the states at its start and end.
  Seen After(const BodyStates& before, const BodyStates& now, const Supports& supports);

 private:
  struct Moving {
    double damping = 1;     ///< factor of the velocity in a cycle
    double least_due = 0;   ///< m/s: from this change on, a deviation counts
    bool is_judged = true;  ///< it can move, and has no links
    // While it lies flat, since then.
    bool is_flat = false;
    Eigen::Vector3d normal;                    ///< of the ground, unit
    double friction = 0;                       ///< mu
    double least_spin = 0, first_rocking = 0;  ///< rad/s: about the normal; across it at the start
    Eigen::Vector3d first_normal;              ///< in the body's axes
    double turns = 0;                          ///< rad, signed: by a spin that is not allowed
    double excused = 0;                        ///< rad: as much of this as the present tilt excuses
    // Since the first cycle.
    double turned = 0;                                ///< rad, signed: before it lay flat
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< m/s
    double due = 0;                                   ///< m/s
    bool is_twisted = false;
    /// rad, signed: while it lies flat.
    double FalseTurn() const;
    // The last face that was looked for, by the normal in the body's axes.
    Eigen::Vector3d face_normal = Eigen::Vector3d::Zero();
    bool has_face = false;
  };

  void Judge(std::size_t object, const BodyState& before, const BodyState& now,
             const Support& support);
  bool LiesFlat(std::size_t object, const Eigen::Quaterniond& turn);

  world::Engine& engine_;
  const world::Coefficients& coefficients_;
  std::vector<Moving> objects_;  ///< by object
};

// Finds objects that roll faster or slower than they can: Bullet may push a cylinder that rolls at
// points behind its axis, so that it speeds up.

/// Judged are balls, and cylinders and capsules on their round side, on one wall or fixed cuboid,
/// which touch nothing else. The ground pushes towards the axis, and friction acts where they
/// touch, a radius r away. So neither changes the angular momentum about the line of contact,
/// m (r v + k^2 w), with the velocity v along the ground, the rolling w and the radius of gyration
/// k: it changes by gravity alone, whether the object rolls or slips, and whatever the friction.
/// From velocities; Bullet's contacts only tell what touches. Not judged: objects with damping,
/// rolling friction or links. The engine must outlive it. Not thread-safe.
class RollWatch {
 public:
  explicit RollWatch(world::Engine& engine);

  /// Call after each cycle, with the states at its start and end: the deviation of the
  /// speed at which an object rolls or will roll, by its angular momentum, relative to its largest
  /// speed so far, at least 0.5 sqrt(g S) with its least side S. NaN if nothing was judged.
  double After(const BodyStates& before, const BodyStates& now, const Supports& supports);

 private:
  struct Round {
    bool is_judged = false;
    bool is_ball = false;
    double radius = 0;       ///< m
    double gyration = 0;     ///< m^2: k^2
    double least_speed = 0;  ///< m/s
    // While it rolls.
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< m/s, of its speed
    double fastest = 0;                               ///< m/s
    bool has_rolled = false;
  };
  void Judge(Round& round, const BodyState& before, const BodyState& now, const Support& support);

  world::Engine& engine_;
  const Eigen::Vector3d pull_;  ///< m/s: velocity that gravity gives in a cycle
  std::vector<Round> objects_;  ///< by object
};

}  // namespace cdb::probes
