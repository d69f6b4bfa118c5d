// Records the series of a scene between cycles. Nothing here runs inside a timed cycle, and only
// the requested series are computed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/engine/probes/body_states.h"
#include "runtime/engine/probes/contact_sides.h"
#include "runtime/engine/probes/energy_audit.h"
#include "runtime/engine/probes/friction_watch.h"
#include "runtime/engine/probes/impact_watch.h"
#include "runtime/engine/probes/motion_watch.h"
#include "runtime/engine/probes/normal_watch.h"
#include "runtime/engine/probes/pass_watch.h"
#include "runtime/engine/probes/press_watch.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/recording.h"

namespace cdb::probes {

// Finds objects that Bullet put to sleep although nothing holds them: in the air, or on a slope
// that is too steep for friction or down which they would roll.

/// An object is judged by its contacts in the cycle in which it falls asleep, or in the first one.
/// It is held if forces inside the friction cones balance its weight; if it still moved, torques
/// must be balanced too, unless rolling friction acts. A ball without rolling friction on walls,
/// boxes and balls is judged however slow it was, and may lie on no slope at all. Without gravity,
/// an object without contacts is held if it hardly moved. Objects held by a link are left out.
/// Static equilibrium is a non-negative least squares problem. The engine must outlive it. Not
/// thread-safe.
class SleepWatch {
 public:
  explicit SleepWatch(world::Engine& engine);

  /// Call after each cycle, with the states at its start and end. Returns the number of sleeping
  /// objects that nothing holds.
  std::int32_t After(const BodyStates& before, const BodyStates& now);

  using Wrench = Eigen::Matrix<double, 6, 1>;  ///< force, and torque over the least half extent
  /// The forces that contacts can exert on an object.
  struct Support {
    std::vector<Wrench> normals, cones;
    bool is_exact = true;  ///< the normals, as far as Bullet knows the shapes
  };

 private:
  void CollectSupports();
  double HalfOf(std::size_t object) const;
  bool IsHeld(std::size_t object, const BodyState& before, const Support& support) const;

  world::Engine& engine_;
  bool is_first_ = true;
  std::vector<char> unheld_;                 ///< by object
  std::map<std::size_t, Support> supports_;  ///< of objects that fell asleep in this cycle
};

// The checks for unsound states that need the state before and after a cycle.

/// The engine must outlive it. Not thread-safe.
class Soundness {
 public:
  /// `contact_sides` must outlive it.
  Soundness(const plan::Scene& scene, world::Engine& engine, const ContactSides& contact_sides);

  /// Call once before the first cycle, with its energies, J.
  void Begin(double kinetic, double energy);

  struct Seen {
    PassWatch::Seen passes;
    std::int32_t pressed, inverted, unheld;
    EnergyAudit::Seen energy;  ///< NaN if not judged (analysis::Question, AreGainsJudged)
    NormalWatch::Seen normals;
    FrictionWatch::Seen friction;
    double rolling_error;
    ImpactWatch::Seen impacts;
  };
  /// Call after each cycle, with the energies at its end, J.
  Seen After(double kinetic, double energy);

 private:
  world::Engine& engine_;
  BodyStates before_, now_;
  PassWatch passes_;
  PressWatch presses_;
  SleepWatch sleepers_;
  NormalWatch normals_;
  Supports supports_;
  const world::Coefficients coefficients_;
  FrictionWatch friction_;
  RollWatch rolling_;
  ImpactWatch impacts_;
  const bool are_losses_judged_;
  std::optional<EnergyAudit> audit_;
};

/// Engine and recording must outlive it. Not thread-safe.
class Probes {
 public:
  /// `contacts_fd` receives the ContactRecords of `record contacts`; otherwise it is not used.
  Probes(const plan::Scene& scene, world::Engine& engine, protocol::Recording& recording,
         int contacts_fd);

  /// Call once before the first recorded cycle: displacements are relative to the positions then.
  void Begin();
  /// Call after each recorded cycle. Throws std::system_error if a contact cannot be written.
  void Record(std::uint64_t cycle);

 private:
  void RecordManifolds(std::uint64_t cycle);
  void RecordStability(std::uint64_t cycle);
  void RecordEnergy(std::uint64_t cycle);
  void SetScales();
  void RecordPoses(std::uint64_t cycle);
  void RecordRepose(std::uint64_t cycle);
  void RecordBoxes(std::uint64_t cycle);
  void RecordFilters();
  std::size_t PlaceOfWall(const btRigidBody& wall) const;
  void RecordMotion(std::uint64_t cycle);
  void RecordJoints(std::uint64_t cycle);
  void RecordSoundness(std::uint64_t cycle);
  /// Call in every cycle, with the centre of mass.
  bool IsBeyondWall(std::size_t object, const Eigen::Vector3d& centre);
  bool IsTooLarge(const btRigidBody& body) const;

  world::Engine& engine_;
  protocol::Recording& recording_;
  protocol::RecordingHeader& header_;
  const std::uint64_t cycles_;
  const bool is_driven_, streams_contacts_, all_walls_, floor_, is_floor_box_;
  const int contacts_fd_;
  const unsigned standing_walls_;
  std::optional<MotionWatch> motion_watch_;  ///< for `record stability`, as is the next member
  std::optional<Soundness> soundness_;
  std::unique_ptr<world::MotorWatch> motor_watch_;  ///< null without motors
  std::vector<char> touches_;  ///< by body, including walls: has a contact in this cycle
  /// By object: how it came below the floor.
  enum class Below : char { kNot, kWentThrough, kFellOff };
  std::vector<Below> below_;
  std::optional<ContactSides> contact_sides_;  ///< for `record stability`
  std::vector<protocol::ContactRecord> contact_records_;
};

}  // namespace cdb::probes
