// Facts about a scene and its groups of objects from which the lints compute their numbers.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/trace.h"
#include "compiler/lints/lints.h"
#include "compiler/plan/plan.h"

namespace cdb::lints {

// Bounds of the values that a scene draws, without drawing them.

struct Bounds {
  double least = 0, most = 0;
};

/// Bounds of a number: of a distribution its usual range (compiler/schema/cumulative.h), of any( )
/// its numbers. A lower bound of a distribution is at least a thousandth of `most`: few draws are
/// smaller. For same( ) and density( ), those of their value. {0, 0} if the value is a word or a
/// formula.
Bounds PositiveBounds(const schema::Value& value);

/// Bounds of a setting that may be a formula: the extremes of its values with each setting in it at
/// its smallest or its largest value, which `bounds_of` gives by name. {0, 0} if it names too many
/// settings.
Bounds PositiveBounds(const schema::Value& value,
                      const std::function<Bounds(std::string_view)>& bounds_of);

/// The largest absolute value of each component of a vector, or of a schedule in the course of a
/// run.
Eigen::Vector3d LargestComponents(const schema::Value& value);

/// True if the value is drawn or set by a schedule, not a constant.
bool IsDrawnOrScheduled(const schema::Value& value);

/// The objects of one group, by the bounds of their drawn values. SI units.
struct GroupFacts {
  const plan::GroupSettings* settings = nullptr;
  std::size_t index = 0;  ///< into Scene::groups
  double quantity = 0;
  Eigen::Vector3d least_sides, most_sides;
  double least_side = 0, longest_side = 0;  ///< of any object
  double elongation = 1;                    ///< longest over shortest side of one object
  bool moves = false;                       ///< if pushed: it is neither fixed nor kinematic
  bool is_kinematic = false;                ///< or some of them may be
  bool is_surface = false;                  ///< or some of them may be
  Bounds mass;
  Eigen::Vector3d velocity;  ///< largest components
  double speed = 0, spin = 0;
  Eigen::Vector3d position;  ///< largest coordinates at the start
  /// The centres of the objects at the start; empty if `location` does not list them.
  std::vector<Eigen::Vector3d> places;
  std::optional<analysis::PoseFacts> path;  ///< of a kinematic object
  bool may_touch = false;  ///< an object may touch anything in the course of the run
  bool adjoins = false;    ///< some of its fixed boxes stand side by side with others
  double stacked = 1;      ///< number of objects on top of one another
  double tower = 1;        ///< height, in objects, of a stack that is equally unstable
  double load = 1;         ///< mass of the end of a chain divided by that of the others
  bool chained = false, springs = false;  ///< by links
  bool linked = false;                    ///< by links or joints: the objects do not move freely
  double tumble = 0;                      ///< rad/s: the spin of its tree (FindTrees)
  double driven_spin = 0;                 ///< rad/s, by a motor (FindLoads)
  double joined_load = 0;     ///< mass that joints hold beyond an object, over its own (FindLoads)
  bool is_load_open = false;  ///< that load depends on what it stands on
  double overlap = 0;         ///< m, between neighbours at the start
  double gap = 0;             ///< m, the initial fall of the objects of a stack
};

/// Bounds of a drawn number of a group, also if a formula or a density gives it (PositiveBounds).
Bounds BoundsOf(const plan::GroupSettings& settings, std::string_view name);

/// Settings of the world, and the groups that have objects. SI units.
struct SceneFacts {
  const plan::WorldSettings* world = nullptr;
  double timestep = 0, iterations = 0, cycles = 0;
  bool rests = false;  ///< the scene is expected to stay at rest
  double side = 0;     ///< of the world's cube
  Eigen::Vector3d acceleration;
  double g = 0;  ///< the magnitude of `acceleration`
  /// The constant acceleration, signed; nullopt if it is drawn or on a schedule.
  std::optional<Eigen::Vector3d> pull;
  bool has_walls = false, has_box_walls = false;
  bool has_ground = false;                 ///< walls, fixed or kinematic objects
  bool only_contacts_take_energy = false;  ///< analysis::Question::kLosses is checked
  bool are_gains_judged = false;           ///< analysis::AreGainsJudged
  bool is_single = false;
  double epsilon = 0;  ///< of the precision
  double count = 0;    ///< objects in all groups
  double moving = 0;   ///< number of objects that move if pushed
  std::vector<GroupFacts> groups;
  std::optional<analysis::Collisions> collisions;  ///< of the scene

  double Time() const { return timestep * cycles; }
  /// True if gravity presses the objects against a support.
  bool HasWeight(const GroupFacts& objects) const {
    return g > 0 && has_ground && objects.may_touch;
  }

  /// Upper bounds: of the height that objects fall between walls, of that along y, of the speed
  /// gained by the fall, of the speed, and of its largest component.
  double FallHeight(const GroupFacts& objects) const;
  double HeightAboveFloor(const GroupFacts& objects) const;
  double FallSpeed(const GroupFacts& objects) const;
  double FastestSpeed(const GroupFacts& objects) const;
  double FastestComponent(const GroupFacts& objects) const;
};

/// `scene` must outlive the facts. `read`: as for LintScene.
SceneFacts FactsOf(const plan::Scene& scene, const FactReaders& read = {});

// Facts about several groups: touching.cc.

/// Listed objects that stand on each other are a stack, whatever their groups.
void FindTowers(SceneFacts& scene);
/// Sets GroupFacts::may_touch.
void FindContacts(SceneFacts& scene);
/// Sets GroupFacts::adjoins.
void FindAdjoining(SceneFacts& scene);

/// Sets GroupFacts::tumble, in reduced coordinates: the mean spin, weighted by mass, of the groups
/// that joints hold together, if neither the world nor anything fixed holds them and one of the
/// joints turns. joint_lints.cc.
void FindTrees(const plan::Scene& scene, SceneFacts& facts);

/// Sets the facts of joints between groups: GroupFacts::driven_spin, and, in maximal coordinates,
/// joined_load and is_load_open. joint_lints.cc.
void FindLoads(const plan::Scene& scene, SceneFacts& facts);

/// The position at which `location at(…)` places the group's object.
std::optional<Eigen::Vector3d> FixedPositionOf(const GroupFacts& objects);
/// The constant value of a vector; nullopt if it is drawn or on a schedule.
std::optional<Eigen::Vector3d> ConstantOf(const schema::Value& value);
/// True if all objects of the group are spheres with equal sides.
bool IsBall(const GroupFacts& objects);
/// True if the switch is on, or drawn.
bool MayBeOn(const GroupFacts& objects, schema::GroupParameter name);

// The formulae of the lints: one function each, for the objects of one group.

/// A number that predicts a problem; the members are those of LintNumber.
struct Estimate {
  double value = 0;
  double threshold = 1;
  double remedy = 0;
  bool open = false;
};

/// `objects` belong to `scene` and move; nullopt if the lint does not apply to them.
using Formula = std::optional<Estimate>(const SceneFacts& scene, const GroupFacts& objects);

// Loads: stacking_lints.cc.
Formula TallStack;
Formula LeaningStack;
Formula MassRatio;
Formula NarrowFoot;
Formula Overlap;
Formula ShortRun;
Formula Creep;

// Chains: chain_lints.cc.
Formula HeavyEnd;
Formula LongChain;
Formula SwingingJoint;
Formula TumblingTree;
Formula StiffSpring;

// Soft bodies, in a scene that has nothing else that moves: soft_lints.cc.
std::optional<LintNumber> StiffSoftSpring(const plan::Scene& scene,
                                          const analysis::ReadModel& read);

// Contacts: contact_lints.cc.
Formula LongStep;
Formula ThinWall;
Formula FastHit;
Formula SoftContact;
Formula ThinShape;
Formula InternalEdges;
Formula ForeseenBounce;
Formula LossyBounce;
Formula RollingGain;
Formula SlidingBox;

// Kinematic objects: kinematic_lints.cc.
Formula Crush;

// Motion in flight: motion_lints.cc.
Formula FastSpin;
Formula SpinDrift;
Formula HugeBox;
Formula EarlySleep;

// Rounding: motion_lints.cc.
Formula CoarsePlace;
Formula LostMotion;
Formula LostFall;
Formula HeavyMass;

/// Just below the value at which warnings begin: the target of remedies.
inline double Harmless(double threshold) { return threshold * LintNumber::kDoubtful * 0.999; }

/// The factor by which a number is too large.
inline double Excess(double value, double threshold) { return value / Harmless(threshold); }

/// The time step that makes a number harmless if the number is proportional to the step, or to its
/// square.
double ShorterStep(const SceneFacts& scene, double value, double threshold);
double ShorterStepSquared(const SceneFacts& scene, double value, double threshold);

}  // namespace cdb::lints
