// A scene in Bullet, built from the plan and advanced cycle by cycle.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/time_table.h"
#include "compiler/plan/plan.h"
#include "library/distributions/draw.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/detection/scene_view.h"
#include "runtime/engine/world/links.h"
#include "runtime/engine/world/population.h"
#include "runtime/engine/world/pushes.h"
#include "runtime/engine/world/shapes.h"
#include "runtime/engine/world/timed_world.h"
#include "runtime/omissions/omissions.h"

namespace cdb::world {

/// Contains only what the run does not omit; every body moves as it would without omissions.
///
/// Walls are fixed bodies with the friction and restitution of `world`. `plane` walls are
/// infinite half-spaces; `box` walls are a tenth of the cube's side thick and reach over its edges.
/// A fixed object does not move: its velocities are drawn but not used. A kinematic object is moved
/// only by Kinematics, and stays at its initial pose until then. Not thread-safe.
class Engine {
 public:
  /// Builds the world of `state`, which MakeInitialState drew from `scene`, without the components
  /// in `omissions` (SettleNeeds of the same two). Bodies are added object by object in the plan's
  /// order, then the standing walls that some object keeps, in the order -x, +x, -y, +y, -z, +z.
  /// Throws library::SceneError for values that the detector or the precision cannot represent, and
  /// if `omit` names a component that turns out to be needed once the world is built.
  Engine(const plan::Scene& scene, layouts::InitialState state, omissions::Omissions omissions);
  /// The same with the given detectors instead of those of the scene.
  Engine(const plan::Scene& scene, layouts::InitialState state, omissions::Omissions omissions,
         const detection::Detectors& detectors);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// One cycle: one internal step of the scene's timestep.
  void Step() {
    if (population_ != nullptr) {
      Change();
      ++stepped_;
    }
    if (acts_) BeginStep();
    if (timed_world_ != nullptr) {
      timed_world_->TimedStep(timestep_);
    } else {
      world_->stepSimulation(timestep_, 1, timestep_);
    }
    if (acts_) EndStep();
  }

  /// Lets objects come and go, as the next Step does first; for what has to know its bodies.
  void Change() {
    if (population_ != nullptr && changed_ == stepped_) population_->BeforeStep(changed_++);
  }
  /// Null if the same objects are there all the time.
  const Population* population() const { return population_.get(); }
  bool IsPresent(std::size_t object) const { return is_present_[object] != 0; }
  std::size_t present() const { return present_; }
  /// Puts an object that has not been in the world into it, with its velocities of the start.
  void Add(std::size_t object, const Eigen::Vector3d& place);
  /// Takes objects out of the world, for good, and wakes those that they touch.
  void Remove(std::span<const std::size_t> objects);

  /// Broad and narrow phase of the bodies where they are. Nothing moves.
  void Detect() {
    if (timed_world_ != nullptr) {
      timed_world_->TimedDetection();
    } else {
      world_->performDiscreteCollisionDetection();
    }
  }

  /// The omissions; may be fewer than those it was built with.
  const omissions::Omissions& omissions() const { return omissions_; }
  /// True if `wall` (0 to 5: -x, +x, -y, +y, -z, +z) is in the scene, but omitted for this object.
  bool IsWithoutWall(std::size_t object, int wall) const {
    return !omissions_.walls.empty() && (standing_ & ~omissions_.walls[object] & 1 << wall) != 0;
  }
  /// By the objects' indices; for a wall, by the object's.
  bool MayTouch(std::size_t object, std::size_t other) const {
    return collisions_.MayTouch(state_.objects[object].group, state_.objects[other].group);
  }
  bool MayTouchWalls(std::size_t object) const {
    return collisions_.MayTouchWalls(state_.objects[object].group);
  }
  std::string_view detector() const { return scene_.world.WordOr("detector"); }
  /// The bodies as input of detectors; null if both phases are Bullet's own.
  const detection::SceneView* scene_view() const { return scene_view_.get(); }

  /// Null if the scene records neither timing nor counters; its cycles then run without a clock.
  const TimedWorld* timed_world() const { return timed_world_; }
  LeanWorld& world() { return *world_; }
  const layouts::InitialState& initial_state() const { return state_; }
  /// The objects, in the order of the initial state; one that is not in the world has a position
  /// and velocities that are NaN. The getUserIndex of an object is its index
  /// here, that of a wall is the number of objects plus its own index.
  const std::vector<std::unique_ptr<btRigidBody>>& objects() const { return objects_; }
  const std::vector<std::unique_ptr<btRigidBody>>& walls() const { return walls_; }
  const Links& links() const { return *links_; }
  /// The current value, rounded to the precision of the engine. Setting it wakes all sleeping
  /// bodies.
  const Eigen::Vector3d& acceleration() const { return acceleration_; }
  void SetAcceleration(const Eigen::Vector3d& acceleration);
  /// The forces and torques on objects, which the next step applies.
  Pushes& pushes() { return *pushes_; }
  const Pushes& pushes() const { return *pushes_; }
  /// J, since the start: of forces and torques on objects, and of motors that give one.
  double Work() const { return pushes_->Work() + links_->Work(); }
  btScalar timestep() const { return timestep_; }
  double side() const { return side_; }

 private:
  void BeginStep();
  void EndStep();
  void MakeDetection(const detection::Detectors& detectors);
  bool IsKept(int wall) const;  ///< by at least one object
  void MakeObject(const layouts::ObjectState& object);
  void MakeWall(int wall);
  void SettleRotation();
  void CutPlanes();
  void MakeWorld();
  void AddBodies();
  void AddObject(std::size_t object);
  /// Group and mask.
  std::pair<int, int> FilterOf(std::size_t object) const;
  int WallMask() const;
  void SetUpSolver();

  // Members are declared in dependency order: the world uses all members before it.
  const plan::Scene scene_;
  const layouts::InitialState state_;
  const analysis::Collisions collisions_;
  omissions::Omissions omissions_;
  const std::uint8_t standing_;  ///< walls of the scene, one bit each
  const double side_;
  const btScalar timestep_;
  const bool faithful_, sleeping_;
  Eigen::Vector3d acceleration_;
  ShapePool shapes_;
  std::vector<std::unique_ptr<btCollisionShape>> wall_shapes_;
  std::vector<std::unique_ptr<btRigidBody>> objects_, walls_;
  btDefaultCollisionConfiguration configuration_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<detection::SceneView> scene_view_;  ///< null if both detectors are Bullet's own
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btBroadphaseInterface> broad_phase_;
  std::unique_ptr<LeanWorld> world_;
  std::unique_ptr<Links> links_;
  std::unique_ptr<Pushes> pushes_;
  std::vector<char> is_present_;  ///< by object
  std::size_t present_ = 0;
  std::unique_ptr<Population> population_;  ///< null if no objects come or go
  std::uint64_t stepped_ = 0;               ///< steps done, if there is a population
  std::uint64_t changed_ = 0;               ///< steps for which it has changed them
  bool acts_ = false;                  ///< forces, torques or motors need BeginStep and EndStep
  std::uint64_t steps_ = 0;            ///< done, if it acts
  TimedWorld* timed_world_ = nullptr;  ///< `world_`, if it is a TimedWorld
};

// Checks that the Bullet library at run time has the precision that this program was built for.

/// `single` or `double`: the precision that this program was built for.
const char* EnginePrecision();

/// Empty if they agree; otherwise an error message. Headers of one precision and a library of the
/// other link and run, but compute wrong numbers. Cheap; call it before any other function of
/// Bullet.
std::string PrecisionMismatch();

// Moves the kinematic objects of an engine.
//
// During the step from t to t + dt, a kinematic object is at the pose of its motion
// (layouts::PoseAt) at t, as all other objects are, and has the velocity that takes it to its pose
// at t + dt; after the step it is at that pose. Contacts are therefore found between poses of the
// same time. Velocities are computed in double and passed to Bullet's solver; no error accumulates.
// t counts from the start, including the warm-up. Not thread-safe.

class Kinematics {
 public:
  /// Of no object.
  explicit Kinematics(const plan::Scene& scene);
  /// The engine must outlive it.
  Kinematics(const plan::Scene& scene, Engine& engine);
  /// A kinematic object and its body, which must outlive it.
  void Add(const layouts::ObjectState& object, btRigidBody& body) {
    all_.emplace_back(&object, &body);
  }

  /// Call before and after each step. `step` counts from 0.
  void BeforeStep(std::uint64_t step) const;
  void AfterStep(std::uint64_t step) const;

 private:
  double TimeOf(std::uint64_t step) const { return static_cast<double>(step) * timestep_; }

  const double timestep_;  ///< s, as in the scene, not rounded
  std::vector<std::pair<const layouts::ObjectState*, btRigidBody*>> all_;
};

// Schedules: accelerations and velocities that change during a run.
//
// `every(n, value)` sets the value anew before every n-th step, `rotating(vector, about, period)`
// before each; both count steps from the start, including the warm-up. A table, of a force or a
// torque, gives the value in the middle of each step. Setting a value wakes sleeping objects.
// Velocities are set regardless of changes by contacts since the last time. Not thread-safe.
// Brownian scenes and moving gravity: Serpa & Rodrigues, "Broadmark", Computer Graphics Forum
// 39(1), 2020.

class Schedules {
 public:
  /// The scene and the engine must outlive it.
  Schedules(const plan::Scene& scene, Engine& engine);

  /// Call before each step. `step` counts from 0. Throws library::SceneError as drawing does.
  void BeforeStep(std::uint64_t step) {
    for (Row& row : rows_) Apply(row, step);
  }

 private:
  enum class Target { kAcceleration, kLinearVelocity, kAngularVelocity, kForce, kTorque };
  /// A parameter with a schedule.
  struct Row {
    Target target;
    const schema::Call* call;
    std::unique_ptr<distributions::Draw> draw;  ///< of `every`
    std::optional<analysis::TimeTable> table;   ///< of `table`
    std::size_t first = 0, end = 0;             ///< objects
  };

  void Add(Target target, const plan::Group* group, const schema::Parameter& parameter,
           std::size_t first, std::size_t end);
  void Apply(Row& row, std::uint64_t step);
  Eigen::Vector3d ValueAt(Row& row, std::uint64_t step) const;

  const plan::Scene& scene_;
  Engine& engine_;
  std::vector<Row> rows_;
};

}  // namespace cdb::world
