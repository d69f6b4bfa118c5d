// The physical behaviour expected of a scene, which a verdict compares with its motion.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

enum class Expectation {
  kAnything,  ///< nothing except that it must not gain energy
  kRest,      ///< to stay where it is: a stack
  kEnergy,    ///< to keep its energy: no friction, no damping, elastic bounces
  kDriven,    ///< a schedule or a motor moves it, so that its energy proves nothing
};

/// `anything`, `rest`, `energy`, `driven`.
std::string_view ExpectationName(Expectation expectation);

/// From the parameter `expect`; if that is `auto`, from the settings of the scene. A scene with a
/// schedule or a motor is always driven.
Expectation ExpectationOf(const plan::Scene& scene);

/// True if the layout puts the objects of the group on the floor or on one another.
bool Stands(const plan::Group& group);

/// The reason why the scene need not rest: `group top is placed by at`; nullopt if it must.
std::optional<std::string> WhyNotAtRest(const plan::Scene& scene);

/// What does work on the scene besides gravity: `a schedule moves group box`; empty if nothing
/// does.
std::string DriverText(const plan::Scene& scene);

/// True if nothing takes energy from objects without contacts: no damping, no schedule, no limit of
/// a joint.
bool FliesFreely(const plan::Scene& scene);

// Collision filter of the groups of objects: `collides_with`.

/// The word for the walls among the names of groups.
inline constexpr std::string_view kWallsWord = "walls";

/// Two groups may touch if each allows the other; walls allow every group. A name that is not a
/// group's allows none.
class Collisions {
 public:
  explicit Collisions(const plan::Scene& scene);

  /// True if nothing is filtered.
  bool AllMayTouch() const { return class_count_ == 1 && MayTouch(0, 0) && MayTouchWalls(0); }
  /// By the index of each group in the scene.
  bool MayTouch(std::size_t group, std::size_t other) const {
    return touches_[group * walls_.size() + other] != 0;
  }
  bool MayTouchWalls(std::size_t group) const { return walls_[group] != 0; }
  /// Groups of one class may touch the same groups. Classes are numbered from 0.
  std::size_t ClassOf(std::size_t group) const { return classes_[group]; }
  std::size_t ClassCount() const { return class_count_; }

 private:
  bool AreAlike(std::size_t group, std::size_t other) const;

  std::vector<char> touches_;  ///< a row for each group
  std::vector<char> walls_;
  std::vector<std::size_t> classes_;
  std::size_t class_count_ = 0;
};

/// Bullet's collision masks have no bits for more.
inline constexpr std::size_t kMostCollisionClasses = 12;

// Kinematic objects: they follow their velocities or their path, whatever they touch.

/// The word of `mass` that makes an object kinematic.
inline constexpr std::string_view kKinematicWord = "kinematic";

/// True if the group has objects, and all or some of them may be kinematic.
bool HasKinematic(const plan::Group& group);

/// True if the group has objects, and a force or a torque acts on them, at least at times.
bool HasPush(const plan::Group& group);

/// True if the velocities of the group follow a schedule.
bool HasSchedule(const plan::Group& group);

}  // namespace cdb::analysis
