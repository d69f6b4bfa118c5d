// Facts about a scene and its groups of objects from which the lints compute their numbers.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/lints/bounds.h"
#include "compiler/plan/plan.h"

namespace cdb::lints {

/// The objects of one group, by the bounds of the values that they draw. SI units.
struct GroupFacts {
  const plan::GroupSettings* settings = nullptr;
  std::size_t index = 0;  ///< into Scene::groups
  double quantity = 0;
  Eigen::Vector3d least_sides, most_sides;
  double least_side = 0, longest_side = 0;  ///< of any object
  double elongation = 1;                    ///< of one object: its longest side over its shortest
  bool moves = false;                       ///< when it is pushed: not fixed, nor kinematic
  bool is_kinematic = false;                ///< or some of them may be
  bool is_surface = false;                  ///< or some of them may be
  Bounds mass;
  Eigen::Vector3d velocity;  ///< largest components
  double speed = 0, spin = 0;
  Eigen::Vector3d position;  ///< largest coordinates at the start
  double stacked = 1;        ///< objects on one another
  double tower = 1;          ///< height of the stack that is as unsteady, in objects
  double load = 1;           ///< mass of the end of a chain over that of the others
  bool linked = false, springs = false;
  double overlap = 0;  ///< m, of neighbours at the start
  double gap = 0;      ///< m, that the objects of a stack fall at first
};

/// Of a drawn number of a group, also where a formula or a density gives it (PositiveBounds).
Bounds BoundsOf(const plan::GroupSettings& settings, std::string_view name);

/// Settings of the world, and the groups that have objects. SI units.
struct SceneFacts {
  const plan::WorldSettings* world = nullptr;
  double timestep = 0, iterations = 0, cycles = 0;
  bool rests = false;  ///< the scene is expected to stay at rest
  double side = 0;     ///< of the world's cube
  Eigen::Vector3d acceleration;
  double g = 0;  ///< the magnitude of `acceleration`
  /// Its one value, signed; nullopt where it is drawn or on a schedule.
  std::optional<Eigen::Vector3d> pull;
  bool has_walls = false, has_box_walls = false;
  bool has_ground = false;  ///< walls, fixed or kinematic objects
  bool is_single = false;
  double epsilon = 0;  ///< of the precision
  double count = 0;    ///< objects in all groups
  double moving = 0;   ///< those that move when they are pushed
  std::vector<GroupFacts> groups;

  double Time() const { return timestep * cycles; }
  bool MayTouch() const { return has_walls || count > 1; }
  /// Gravity presses objects to something.
  bool HasWeight() const { return g > 0 && has_ground; }

  /// Upper bounds of how far objects fall between walls, of the speed that they gain by it, of the
  /// speed, and of its largest component.
  double FallHeight(const GroupFacts& objects) const;
  double FallSpeed(const GroupFacts& objects) const;
  double FastestSpeed(const GroupFacts& objects) const;
  double FastestComponent(const GroupFacts& objects) const;
};

/// `scene` outlives the facts.
SceneFacts FactsOf(const plan::Scene& scene);

/// Where `location at(…)` places the group's object.
std::optional<Eigen::Vector3d> FixedPositionOf(const GroupFacts& objects);
/// The one value of a vector; nullopt where it is drawn or on a schedule.
std::optional<Eigen::Vector3d> ConstantOf(const schema::Value& value);
/// `value` is `word`, or draws it.
bool MayBe(const schema::Value& value, std::string_view word);
/// The switch is on, or drawn.
bool MayBeOn(const GroupFacts& objects, schema::GroupParameter name);

}  // namespace cdb::lints
