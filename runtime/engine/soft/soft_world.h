// A scene with soft bodies in one of Bullet's two worlds of them, built from the plan and advanced
// cycle by cycle.
//
// Contents of each phase (Bullet 3.24):
//   broad      boxes updated, pairs found and lost
//   narrow     contacts of the pairs
//   detect     both
//   solve      positions: constraints of the soft bodies; springs: contacts and damping
//   integrate  positions: gravity and the motion of the nodes without constraints, which comes
//              before detection; springs: forces, and nodes moved
//   step       all of stepSimulation; with springs, also collisions between soft bodies and of a
//              body with itself, which are in none of the others
#pragma once

// The header defines a global variable `seed`, which parameters of that name would hide.
#define seed bt_soft_body_seed
#include <BulletSoftBody/btSoftBody.h>
#undef seed
#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "compiler/analysis/soft.h"
#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/soft/material.h"
#include "runtime/engine/world/clock.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/shapes.h"
#include "runtime/protocol/series.h"

namespace cdb::soft {

/// What the phases of a step take.
class PhaseClock {
 public:
  using Phase = protocol::Phase;
  /// Without calls of Enable, nothing is measured.
  void Enable() { is_on_ = true; }
  bool is_on() const { return is_on_; }
  void Begin(Phase phase);
  /// Adds what was spent since Begin of the phase.
  void End(Phase phase);
  void Reset() { spent_ = {}; }
  world::PhaseStamps Phases() const;

 private:
  bool is_on_ = false;
  std::array<world::Stamp, protocol::kPhaseCount> begin_ = {}, spent_ = {};
};

/// One of Bullet's worlds with soft bodies.
class BulletSoftWorld {
 public:
  virtual ~BulletSoftWorld() = default;
  virtual btDiscreteDynamicsWorld& world() = 0;
  virtual btSoftBodyWorldInfo& info() = 0;
  /// `body`: its settings are complete. `group`: the group of the scene that it belongs to.
  virtual void Add(btSoftBody& body, const plan::Group& group) = 0;
};

/// The nodes of a body that move as a rigid body, whatever pulls at them.
struct Drive {
  std::vector<std::uint32_t> nodes;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m: their mean at the start
  std::vector<Eigen::Vector3d> from;                 ///< m: of each, from the centre, at the start
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();   ///< m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< rad/s
  /// m: of the i-th of the nodes, `time` s after the start.
  Eigen::Vector3d PlaceAt(std::size_t i, double time) const;
};

/// A soft body and what its mesh was at the start.
struct SoftObject {
  std::size_t object;  ///< index in the initial state
  std::unique_ptr<btSoftBody> body;
  analysis::SoftMesh mesh;
  std::vector<double> rest;    ///< m: length of each link
  std::vector<double> masses;  ///< kg: of each node, 0 if it is pinned or driven
  double stiffness = 0;        ///< N/m: of each link; 0 of a solid and in the world of positions
  Material material = {};      ///< of a solid
  std::vector<Element> elements = {};  ///< its tetrahedra
  Drive drive = {};
};

/// Rigid objects are convex, and never sleep; kinematic ones follow their velocities or path.
/// Nodes share the mass of their body: those of a rope, that of the halves of its links; those of a
/// cloth, that of thirds of their triangles; those of a solid, that of quarters of their
/// tetrahedra. Pinned nodes keep their place, driven ones follow their motion, and their mass is
/// that of the pin. Not thread-safe.
class SoftWorld {
 public:
  /// Throws library::SceneError for values that the precision cannot represent.
  SoftWorld(const plan::Scene& scene, layouts::InitialState state);
  ~SoftWorld();
  SoftWorld(const SoftWorld&) = delete;
  SoftWorld& operator=(const SoftWorld&) = delete;

  /// One cycle: one internal step of the scene's timestep.
  void Step();
  const PhaseClock& clock() const { return clock_; }

  const std::vector<SoftObject>& bodies() const { return bodies_; }
  /// The rigid objects and the walls; getUserIndex is the index of an object.
  std::span<const std::unique_ptr<btRigidBody>> rigid() const { return rigid_; }
  const layouts::ObjectState& ObjectOf(const btRigidBody& body) const {
    return state_.objects[static_cast<std::size_t>(body.getUserIndex())];
  }
  const std::vector<std::unique_ptr<btRigidBody>>& walls() const { return walls_; }
  const layouts::InitialState& initial_state() const { return state_; }
  btDiscreteDynamicsWorld& world() { return world_->world(); }
  std::size_t ContactCount() const;
  const Eigen::Vector3d& acceleration() const { return state_.acceleration; }
  double timestep() const { return static_cast<double>(timestep_); }
  double side() const { return side_; }
  bool has_springs() const { return has_springs_; }

 private:
  void MoveDriven(const SoftObject& one) const;
  void MakeRigid(const layouts::ObjectState& object, std::size_t index);
  void MakeWall(int wall);
  void MakeSoft(const layouts::ObjectState& object, std::size_t index);

  const plan::Scene scene_;
  const layouts::InitialState state_;
  const btScalar timestep_;
  const double side_;
  const bool has_springs_;
  PhaseClock clock_;
  world::ShapePool shapes_;
  std::vector<std::unique_ptr<btCollisionShape>> wall_shapes_;
  std::vector<std::unique_ptr<btRigidBody>> rigid_, walls_;
  world::Kinematics kinematics_;
  std::unique_ptr<btCollisionConfiguration> configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btBroadphaseInterface> broad_phase_;
  std::unique_ptr<BulletSoftWorld> world_;
  std::vector<SoftObject> bodies_;
  std::uint64_t steps_ = 0;
};

/// True if contacts move the body.
inline bool IsFree(const btRigidBody& body) { return !body.isStaticOrKinematicObject(); }

/// 16 hex digits: FNV-1a (64 bits) over the position and velocity of every node, then over the pose
/// and the velocities of every rigid body that moves, in order and in the bits of Bullet's own
/// precision.
std::string StateHash(const SoftWorld& world);

}  // namespace cdb::soft
