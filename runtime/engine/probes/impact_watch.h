// Compares impacts with those that the shapes, velocities and coefficients of the scene give:
// Bullet finds an impact up to a time step late, with the normal of that time.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/exact/impact.h"
#include "runtime/engine/probes/impact_bodies.h"

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
  ImpactWatch(const plan::Scene& scene, world::Engine& engine,
              const world::Coefficients& coefficients);

  struct Seen {
    double error;           ///< sum of the errors so far over the sum of true impulses; NaN if none
    std::int32_t unjudged;  ///< impacts so far that could not be judged
  };
  /// Call after each cycle, with the states at its start and end, and the meetings in it.
  Seen After(const BodyStates& before, const BodyStates& now, std::span<const Meeting> meetings);

 private:
  using Judged = ImpactBodies::Judged;
  struct Pair : ImpactPair {
    Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< on a
  };
  /// An impact that may take further cycles.
  struct Event {
    ImpactPair pair;
    std::vector<std::uint32_t> supports;  ///< user indices, after the pair
    std::vector<exact::ImpactContact> contacts;
    std::vector<exact::ImpactBody>
        first;  ///< the velocities that gravity and damping alone give a and b
    int cycles = 0;
    double error = 0, impulse = 0;  ///< kg m/s: of the cycle with the least ratio
    bool is_complete = false;       ///< after the last cycle: they no longer approach
    bool is_felt = true;            ///< there has been an impulse
    bool is_at_once = true;         ///< all points may touch at once
    /// If points may touch one after the other: what follows, by the direction of friction.
    std::vector<exact::ImpactCourse> courses;
    Judged judged = Judged::kWhole;
  };

  void ReadPairs();
  static const Pair* Find(const std::vector<Pair>& pairs, const ImpactPair& pair);
  bool TouchedBefore(const ImpactPair& pair) const;
  bool IsContinued(const ImpactPair& pair) const;
  std::optional<exact::Touch> FindTouch(const ImpactPair& pair, const BodyStates& before) const;
  void Begin(const Pair& pair, const BodyStates& before, const BodyStates& now);
  void BeginUnfelt(const Meeting& meeting, const BodyStates& before, const BodyStates& now);
  std::optional<Event> MakeEvent(const ImpactPair& pair, const exact::Touch& touch,
                                 const BodyStates& before, const BodyStates& now) const;
  bool AddSupport(Event& event, std::uint32_t object, std::uint32_t ground,
                  const BodyStates& before, const BodyStates& now) const;
  bool Continue(Event& event, const BodyStates& before, const BodyStates& now);
  bool Wait(Event& event, const BodyStates& before, const BodyStates& now);
  void Advance(Event& event, const BodyStates& now) const;
  std::vector<std::vector<exact::ImpactBody>> EndsOf(const Event& event,
                                                     const BodyStates& now) const;
  void Compare(Event& event, const BodyStates& now) const;
  void CompareDirection(const Pair& pair, const Eigen::Vector3d& normal);
  void CountMissed(const Event& event, const BodyStates& now);
  /// Calls `visit` with each free one of the pair and each other body that has an impulse on it,
  /// until it returns true; returns that.
  bool AnyThird(const ImpactPair& pair, auto visit) const;
  void Count(double error, double impulse);
  double Error() const;

  world::Engine& engine_;
  const ImpactBodies bodies_;
  std::vector<Pair> found_;                           ///< by manifold, sorted
  std::vector<Pair> pairs_;                           ///< with an impulse in this cycle; sorted
  std::array<std::vector<Pair>, 4> last_;             ///< in the last ones, the latest first
  std::vector<std::vector<std::uint32_t>> touching_;  ///< by object: bodies with an impulse on it
  std::vector<std::uint32_t> flights_;  ///< by object: cycles before this one without an impulse
  std::vector<Meeting> meetings_;       ///< without an impulse in the last cycle
  std::vector<Event> events_;
  double error_ = 0, impulse_ = 0, momentum_ = 0;  ///< kg m/s
  double missed_ = 0;                              ///< kg m/s: of the true impulses of the missed
  double graze_ = 0;  ///< kg m/s: the momentum of the approach of a missed one, less the impulse
  std::int32_t unjudged_ = 0;
};

}  // namespace cdb::probes
