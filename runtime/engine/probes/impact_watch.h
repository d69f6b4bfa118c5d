// Compares impacts with those that the shapes, velocities and coefficients of the scene give:
// Bullet finds an impact up to a time step late, with the normal of that time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/exact/impact.h"
#include "runtime/engine/probes/body_states.h"
#include "runtime/engine/probes/pass_watch.h"

namespace cdb::probes {

/// An impact is the first impulse of a pair of bodies that approach faster than by a fall of 0.05
/// of the lesser least side, or of four cycles. The two are moved back along their velocities, or
/// forward, if Bullet foresaw the impact, to where they touch; the normal and the points there, and
/// the restitution and friction of the scene, give the velocities after it (exact::SolveImpact).
/// Bullet has up to twelve cycles to reach them.
///
/// The whole change of velocities is compared if the two touch no other body that is free to move;
/// fixed bodies that they touch take part. Otherwise, and where faces are so nearly parallel that
/// further points touch within the cycle, the impulse must lie in the cone of friction about the
/// true normal.
///
/// An impact is missed if two bodies touch along their paths and come apart again without any
/// impulse. Its error is the whole of the true impulse. As far as this is less than the momentum of
/// the approach, as if the two only graze each other, it is compared with that.
///
/// Errors are impulses: of the changes of all velocities, sqrt(sum m v^2 + I w^2) times the root of
/// the reduced mass. Not judged: surfaces and soft contacts; pairs that overlapped before, or that
/// touch only in passing. The engine must outlive it. Not thread-safe.
class ImpactWatch {
 public:
  ImpactWatch(const plan::Scene& scene, world::Engine& engine);

  struct Seen {
    double error;           ///< sum of the errors so far over the sum of true impulses; NaN if none
    std::int32_t unjudged;  ///< impacts so far that could not be judged
  };
  /// Call after each cycle, with the states at its start and end, and the meetings in it.
  Seen After(const BodyStates& before, const BodyStates& now, std::span<const Meeting> meetings);

 private:
  enum class Judged : char { kNot, kCone, kWhole };
  struct Body {
    double mass;                   ///< kg; 0: nothing moves it
    Eigen::Vector3d inertia;       ///< kg m^2, principal
    double damping, spin_damping;  ///< factors in a cycle
    double friction, restitution;
    double least_side;  ///< m
    Judged judged;
    bool is_linked;
  };
  /// Bodies by user index; the first is an object.
  struct Pair {
    std::uint32_t a, b;
    Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< on a
  };
  /// An impact that may take further cycles.
  struct Event {
    std::vector<std::uint32_t> bodies;  ///< user indices; the first two are the pair
    std::vector<exact::ImpactContact> contacts;
    exact::ImpactBody first[2];  ///< the velocities that gravity and damping alone give a and b
    int cycles = 0;
    double error = 0, impulse = 0;  ///< kg m/s: of the cycle with the least ratio
    bool is_complete = false;       ///< after the last cycle: they no longer approach
    bool is_felt = true;            ///< there has been an impulse
    /// If points touch one after the other: what follows, by the direction of friction.
    std::vector<exact::ImpactCourse> courses;
    Judged judged = Judged::kWhole;
  };

  /// Of the velocities of a pair.
  struct Change {
    double impulse;       ///< kg m/s
    double inverse_mass;  ///< 1/kg: reduced
  };

  void ReadPairs();
  static bool Contains(const std::vector<Pair>& pairs, const Pair& pair);
  bool IsContinued(const Pair& pair) const;
  void BeginUnfelt(const Meeting& meeting, const BodyStates& before, const BodyStates& now);
  bool Wait(Event& event, const BodyStates& before, const BodyStates& now);
  void CountMissed(const Event& event, const BodyStates& now);
  void Begin(const Pair& pair, const BodyStates& before, const BodyStates& now);
  bool Continue(Event& event, const BodyStates& before, const BodyStates& now);
  void AddCourses(Event& event, const exact::Touch& touch, const BodyStates& before) const;
  void Advance(Event& event, const BodyStates& now);
  std::vector<exact::ImpactBody> AfterImpact(const Event& event, exact::Slip slip,
                                             const BodyStates& now) const;
  std::vector<exact::ImpactBody> StartOf(const Event& event, const BodyStates& now) const;
  Change ChangeOf(const Event& event, std::span<const exact::ImpactBody> bodies,
                  std::span<const exact::ImpactBody> others, const BodyStates& now) const;
  void Compare(Event& event, const BodyStates& now);
  void CompareDirection(const Pair& pair, const Eigen::Vector3d& normal);
  Judged JudgedOf(const Pair& pair) const;
  void CompareWith(std::span<const exact::ImpactBody> bodies, Event& event, const BodyStates& now,
                   bool is_first);
  bool TouchesFreeThird(const Pair& pair) const;
  double ApproachAt(const Pair& pair, const exact::Touch& touch, const Eigen::Vector3d& point,
                    const BodyStates& before) const;
  std::optional<std::vector<Eigen::Vector3d>> PointsOf(const Pair& pair, const exact::Touch& touch,
                                                       const BodyStates& before) const;
  std::optional<Event> MakeEvent(const Pair& pair, const exact::Touch& touch,
                                 const BodyStates& before, const BodyStates& now);
  bool AddSupport(Event& event, std::uint32_t object, std::uint32_t ground,
                  const BodyStates& before, const BodyStates& now);
  void Count(double error, double impulse);
  double Error() const;

  bool IsWall(std::uint32_t body) const { return body >= bodies_.size(); }
  bool IsFree(std::uint32_t body) const { return !IsWall(body) && bodies_[body].mass > 0; }
  bool IsRound(const Pair& pair) const;
  exact::SignedDistance DistanceBefore(const Pair& pair, const BodyStates& before) const;
  bool LeavesAnotherWay(const Pair& pair, const exact::Touch& touch,
                        const BodyStates& before) const;
  bool IsShallowAcross(const Pair& pair, const exact::Touch& touch,
                       const exact::SignedDistance& distance) const;
  bool SlidesAcross(const Meeting& meeting, const exact::Touch& touch) const;
  double FrictionOf(std::uint32_t a, std::uint32_t b) const;
  double RestitutionOf(std::uint32_t a, std::uint32_t b) const;
  exact::Collider ColliderOf(std::uint32_t body, const BodyStates& states) const;
  exact::ImpactBody BodyOf(std::uint32_t body, const BodyStates& states) const;
  exact::ImpactBody Pulled(std::uint32_t body, const exact::ImpactBody& state) const;
  double LeastApproach(const Pair& pair) const;
  double LeastSide(const Pair& pair) const;

  world::Engine& engine_;
  const double wall_restitution_, wall_friction_, timestep_;
  std::vector<Body> bodies_;        ///< by object
  std::vector<Pair> pairs_, last_;  ///< with an impulse in this cycle and the last; sorted
  std::vector<std::vector<std::uint32_t>> touching_;  ///< by object: bodies with an impulse on it
  std::vector<Meeting> meetings_;                     ///< without an impulse in the last cycle
  std::vector<Event> events_;
  double error_ = 0, impulse_ = 0, momentum_ = 0;  ///< kg m/s
  double missed_ = 0, graze_ = 0;                  ///< kg m/s: graze: of one, the approach less the impulse
  std::int32_t unjudged_ = 0;
};

}  // namespace cdb::probes
