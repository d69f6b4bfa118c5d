// The bodies of a scene as their impacts see them: by shapes, velocities and coefficients.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/exact/impact.h"
#include "runtime/engine/probes/body_states.h"
#include "runtime/engine/probes/pass_watch.h"
#include "runtime/engine/world/coefficients.h"

namespace cdb::probes {

/// Bodies by user index, the smaller first: an object, and an object or a wall.
struct ImpactPair {
  std::uint32_t a, b;
};

/// Poses and velocities are those of `states`; a part of a cycle counts from there. The engine and
/// the coefficients must outlive it. Not thread-safe with respect to the engine.
class ImpactBodies {
 public:
  ImpactBodies(const plan::Scene& scene, world::Engine& engine,
               const world::Coefficients& coefficients);

  enum class Judged : char {
    kNot,
    kCone,   ///< only the direction of the impulse
    kWhole,  ///< all velocities
  };
  Judged JudgedOf(const ImpactPair& pair) const;
  bool IsWall(std::uint32_t body) const { return body >= bodies_.size(); }
  bool IsFree(std::uint32_t body) const { return !IsWall(body) && bodies_[body].mass > 0; }
  bool IsLinked(const ImpactPair& pair) const;
  /// One of them is an ellipsoid: they touch in one point, whatever the other is.
  bool IsRound(const ImpactPair& pair) const;

  double Friction(const ImpactPair& pair) const { return coefficients_.Friction(pair.a, pair.b); }
  double Restitution(const ImpactPair& pair) const {
    return coefficients_.Restitution(pair.a, pair.b);
  }
  double timestep() const { return timestep_; }

  bool AreFinite(const ImpactPair& pair, const BodyStates& states) const;
  exact::Collider ColliderOf(std::uint32_t body, const BodyStates& states) const;
  exact::ImpactBody StateOf(std::uint32_t body, const BodyStates& states) const;
  /// At a part of the cycle.
  exact::ImpactCourse CourseOf(const ImpactPair& pair, double part, exact::Slip slip,
                               const BodyStates& states) const;
  /// A cycle later, without contacts; Bullet turns the spin as the body turns.
  exact::ImpactBody Pulled(std::uint32_t body, const exact::ImpactBody& state) const;

  /// kg m/s: sum over all objects, but for two of them on average.
  double Momentum(const BodyStates& states) const;
  /// Of the velocities of a pair.
  struct Change {
    double impulse;       ///< kg m/s
    double inverse_mass;  ///< 1/kg: reduced
  };
  /// `from`, `to`: states of the pair, which may be followed by others.
  Change ChangeOf(const ImpactPair& pair, std::span<const exact::ImpactBody> from,
                  std::span<const exact::ImpactBody> to, const BodyStates& states) const;

  double LeastSide(const ImpactPair& pair) const;      ///< m: of the smaller one
  double LeastApproach(const ImpactPair& pair) const;  ///< m/s: of an impact
  /// m/s: no point of one approaches the other faster.
  double MostApproach(const ImpactPair& pair, const BodyStates& states) const;
  /// m/s, where they touch: the bodies have moved there.
  double ApproachAt(const ImpactPair& pair, const exact::Touch& touch, const Eigen::Vector3d& point,
                    const BodyStates& states) const;
  exact::SignedDistance Distance(const ImpactPair& pair, const BodyStates& states) const;
  /// At a part of the cycle.
  bool Overlap(const ImpactPair& pair, double part, const BodyStates& states) const;
  /// Where they touch.
  struct Points {
    std::vector<Eigen::Vector3d> points;  ///< the first one alone, if the others cannot be at once
    bool are_at_once = true;              ///< all others touch at about the same time
    bool are_in_turn = false;             ///< or after it
  };
  Points PointsOf(const ImpactPair& pair, const exact::Touch& touch,
                  const BodyStates& states) const;
  /// Those of two that rest on each other.
  std::vector<Eigen::Vector3d> RestingPoints(const ImpactPair& pair, const exact::Touch& touch,
                                             const BodyStates& states) const;
  /// Whether they overlap no more than contacts at rest do, and part sooner across the touch.
  bool LeavesAnotherWay(const ImpactPair& pair, const exact::Touch& touch,
                        const BodyStates& states) const;
  /// The same from the touch, a part of the meeting, to its end.
  bool SlidesAcross(const Meeting& meeting, const exact::Touch& touch) const;

 private:
  struct Body {
    double mass;                   ///< kg; 0: nothing moves it
    Eigen::Vector3d inertia;       ///< kg m^2, principal
    double damping, spin_damping;  ///< factors in a cycle
    double least_side;             ///< m
    Judged judged;
  };

  const objects::Solid& SolidOf(std::uint32_t object) const {
    return engine_.initial_state().objects[object].solid;
  }
  bool IsShallowAcross(const ImpactPair& pair, const exact::Touch& touch,
                       const exact::SignedDistance& distance) const;

  world::Engine& engine_;
  const world::Coefficients& coefficients_;
  const double timestep_;
  std::vector<Body> bodies_;  ///< by object
};

}  // namespace cdb::probes
