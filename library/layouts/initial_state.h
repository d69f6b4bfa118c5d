// The initial state of a scene: every object, drawn and placed. Computed in double from the plan
// alone, so that it is the same for every precision, detector and machine.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/pose_table.h"
#include "library/objects/solid.h"

namespace cdb::layouts {

/// For each row of the schema, how many rows before it are drawn numbers; last, how many there are.
inline constexpr auto kNumberSlots = [] {
  std::array<std::size_t, schema::kParameters.size() + 1> slots = {};
  for (std::size_t row = 0; row < schema::kParameters.size(); ++row)
    slots[row + 1] =
        slots[row] +
        (schema::MayBe(schema::kParameters[row], schema::ValueKind::kDrawnNumber) ? 1 : 0);
  return slots;
}();

/// m; the schema's default, which Bullet reduces for small objects. A margin that is written as
/// 0.04 means the same.
inline constexpr double kBulletMargin = 0.04;

/// The numbers drawn for an object, by parameter: `numbers["friction"]`. A misspelt one is a
/// compile error. A word is the number that its row gives; a switch is 0 or 1. SI units.
class DrawnNumbers {
 public:
  using Parameter = schema::ParameterRef<true, schema::ValueKind::kDrawnNumber>;

  /// 0, or the numbers of words: rigid contacts.
  DrawnNumbers() {
    ForEach([](const schema::Parameter& row, double& number) { number = row.number_of_word; });
  }

  double& operator[](Parameter parameter) { return values_[kNumberSlots[parameter.row()]]; }
  double operator[](Parameter parameter) const { return values_[kNumberSlots[parameter.row()]]; }
  bool On(Parameter parameter) const { return (*this)[parameter] != 0; }
  /// Calls `visit` with the row and the number of each.
  template <typename Visit>
  void ForEach(Visit visit) {
    for (std::size_t row = 0; row < schema::kParameters.size(); ++row)
      if (kNumberSlots[row] != kNumberSlots[row + 1])
        visit(schema::kParameters[row], values_[kNumberSlots[row]]);
  }

 private:
  std::array<double, kNumberSlots.back()> values_;
};

/// One object. SI units.
struct ObjectState {
  std::size_t group = 0;  ///< index into Scene::groups
  objects::Solid solid;
  objects::Pose pose;  ///< of the body's own axes; a compound's differ from those of its mesh
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  /// At the centre of mass, along the axes of the world, at the start.
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  double mass = 1;  ///< 0 if the object is fixed or kinematic
  DrawnNumbers numbers;
  /// It follows its velocities or its path, whatever it touches.
  bool is_kinematic = false;
  std::shared_ptr<const Path> path = nullptr;  ///< of a kinematic object; null: none

  /// No contact moves it; a kinematic object still moves by itself.
  bool IsFixed() const { return mass == 0; }
};

struct InitialState {
  std::vector<ObjectState> objects;  ///< group by group, in the order of the plan
  std::vector<std::shared_ptr<const objects::ConvexDecomposition>>
      forms;  ///< of the compounds among them
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  double fill_fraction = 0;  ///< volume of the objects at the start divided by that of the cube
};

/// Draws and places. Throws SceneError if a distribution gives no usable value, an object does not
/// fit into the cube, or no free position is found (library/layouts/placement.h).
InitialState MakeInitialState(const plan::Scene& scene);

/// The objects without positions, and the acceleration: the first half of MakeInitialState.
InitialState DrawObjects(const plan::Scene& scene);

/// The pose of a kinematic object `time` s after the start: on its path, or as given by its
/// constant velocities. Without columns of orientation, the object of a path rotates by its angular
/// velocity.
objects::Pose PoseAt(const ObjectState& object, double time);

/// `objects.orientation`, which rotates the axes of the sides: a rotation about the direction of
/// the vector by its length, rad. The last bit depends on std::sin and std::cos.
Eigen::Quaterniond TurnAbout(const Eigen::Vector3d& rotation_vector);

// The displacement of the initial state for the twin of a reference.

/// Moves every object with mass by kDisplacement (compiler/analysis/reference.h) of its largest
/// side, each in a separate direction drawn from the scene's stream `nudge`.
void Displace(const plan::Scene& scene, InitialState& state);

}  // namespace cdb::layouts
