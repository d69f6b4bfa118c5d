#include "runtime/engine/soft/soft_world.h"

#include <BulletSoftBody/btDefaultSoftBodySolver.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <type_traits>
#include <utility>

#include "compiler/analysis/recorded.h"
#include "compiler/analysis/reference.h"
#include "library/layouts/number_range.h"
#include "library/layouts/soft_nodes.h"
#include "library/objects/soft_form.h"
#include "runtime/engine/detection/broad_phase.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/timed_world.h"
#include "runtime/omissions/omissions.h"

namespace cdb::soft {
namespace {

using Eigen::Vector3d;
using layouts::ObjectState;
using protocol::Phase;
using world::ToBullet;

/// Steps between two collections of the cells that Bullet no longer needs.
constexpr std::uint64_t kCollectEvery = 256;

/// Stamps the narrow phase, which both worlds call without a virtual function of theirs.
class TimedDispatcher final : public btCollisionDispatcher {
 public:
  TimedDispatcher(btCollisionConfiguration* configuration, PhaseClock& clock)
      : btCollisionDispatcher(configuration), clock_(clock) {}
  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override {
    clock_.Begin(Phase::kNarrow);
    btCollisionDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
    clock_.End(Phase::kNarrow);
  }

 private:
  PhaseClock& clock_;
};

/// Stamps the broad phase of either world.
template <typename World>
class TimedBroad : public World {
 public:
  template <typename... Arguments>
  TimedBroad(PhaseClock& clock, Arguments... arguments) : World(arguments...), clock_(clock) {}
  void updateAabbs() override {
    clock_.Begin(Phase::kBroad);
    World::updateAabbs();
  }
  void computeOverlappingPairs() override {
    World::computeOverlappingPairs();
    clock_.End(Phase::kBroad);
  }
  // A length of 0 makes Bullet keep the velocities of kinematic bodies.
  void saveKinematicState(btScalar) override { World::saveKinematicState(btScalar(0)); }

 protected:
  PhaseClock& clock_;
};

class TimedPositionSolver final : public btDefaultSoftBodySolver {
 public:
  explicit TimedPositionSolver(PhaseClock& clock) : clock_(clock) {}
  void predictMotion(btScalar timestep) override {
    clock_.Begin(Phase::kIntegrate);
    btDefaultSoftBodySolver::predictMotion(timestep);
    clock_.End(Phase::kIntegrate);
  }
  void solveConstraints(btScalar timestep) override {
    clock_.Begin(Phase::kSolve);
    btDefaultSoftBodySolver::solveConstraints(timestep);
    clock_.End(Phase::kSolve);
  }

 private:
  PhaseClock& clock_;
};

class PositionWorld final : public BulletSoftWorld {
 public:
  PositionWorld(PhaseClock& clock, btDispatcher& dispatcher, btBroadphaseInterface& broad_phase,
                btCollisionConfiguration& configuration, int iterations)
      : solver_(clock),
        world_(clock, &dispatcher, &broad_phase, &rigid_solver_, &configuration, &solver_),
        iterations_(iterations) {}

  btDiscreteDynamicsWorld& world() override { return world_; }
  btSoftBodyWorldInfo& info() override { return world_.getWorldInfo(); }
  void Add(btSoftBody& body, const plan::Group& group) override {
    body.m_materials[0]->m_kLST = static_cast<btScalar>(group.settings.Real("soft.correction"));
    body.m_cfg.piterations = iterations_;
    body.m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
    world_.addSoftBody(&body);
  }

 private:
  btSequentialImpulseConstraintSolver rigid_solver_;
  TimedPositionSolver solver_;
  TimedBroad<btSoftRigidDynamicsWorld> world_;
  const int iterations_;
};

class TimedSpringWorld final : public TimedBroad<btDeformableMultiBodyDynamicsWorld> {
 public:
  template <typename... Arguments>
  explicit TimedSpringWorld(PhaseClock& clock, Arguments... arguments)
      : TimedBroad(clock, arguments...) {
    // Bullet calls it before and after it solves.
    setSolverCallback([](btScalar, btDeformableMultiBodyDynamicsWorld* world) {
      static_cast<TimedSpringWorld*>(world)->StampSolver();
    });
  }
  void predictUnconstraintMotion(btScalar timestep) override {
    clock_.Begin(Phase::kIntegrate);
    btDeformableMultiBodyDynamicsWorld::predictUnconstraintMotion(timestep);
    clock_.End(Phase::kIntegrate);
  }

 protected:
  void integrateTransforms(btScalar timestep) override {
    clock_.Begin(Phase::kIntegrate);
    btDeformableMultiBodyDynamicsWorld::integrateTransforms(timestep);
    clock_.End(Phase::kIntegrate);
  }

 private:
  void StampSolver() {
    is_solving_ = !is_solving_;
    if (is_solving_) {
      clock_.Begin(Phase::kSolve);
    } else {
      clock_.End(Phase::kSolve);
    }
  }

  bool is_solving_ = false;
};

class SpringWorld final : public BulletSoftWorld {
 public:
  SpringWorld(PhaseClock& clock, btDispatcher& dispatcher, btBroadphaseInterface& broad_phase,
              btCollisionConfiguration& configuration, const btVector3& gravity)
      : world_(clock, &dispatcher, &broad_phase, &contact_solver_, &configuration, &solver_),
        gravity_(gravity) {
    contact_solver_.setDeformableSolver(&solver_);
    gravity_.setIndices(solver_.getIndices());
    solver_.getLagrangianForceArray()->push_back(&gravity_);
  }

  btDiscreteDynamicsWorld& world() override { return world_; }
  btSoftBodyWorldInfo& info() override { return world_.getWorldInfo(); }
  void Add(btSoftBody& body, const plan::Group& group) override {
    body.m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN |
                            btSoftBody::fCollision::VF_DD;
    body.setSelfCollision(group.settings.On("soft.self_collision"));
    world_.addSoftBody(&body);
    gravity_.addSoftBody(&body);
    ForceOf(group).addSoftBody(&body);
  }

 private:
  /// Bullet's addForce would keep the stiffness of the first group for all.
  btDeformableLagrangianForce& ForceOf(const plan::Group& group) {
    auto& force = forces_[&group];
    if (force == nullptr) {
      force = analysis::HasSoftSolids(group)
                  ? MakeForce(MaterialOf(group))
                  : std::make_unique<btDeformableMassSpringForce>(
                        static_cast<btScalar>(group.settings.Real("soft.stiffness")),
                        static_cast<btScalar>(group.settings.Real("soft.damping")), true, 0);
      force->setIndices(solver_.getIndices());
      solver_.getLagrangianForceArray()->push_back(force.get());
    }
    return *force;
  }

  btDeformableBodySolver solver_;
  btDeformableMultiBodyConstraintSolver contact_solver_;
  TimedSpringWorld world_;
  btDeformableGravityForce gravity_;
  std::map<const plan::Group*, std::unique_ptr<btDeformableLagrangianForce>> forces_;
};

/// Gives the body of a solid its tetrahedra, and their volumes.
void AddElements(const plan::Group& group, const std::vector<Vector3d>& places, SoftObject& one) {
  btSoftBody& body = *one.body;
  one.material = MaterialOf(group);
  for (const auto& corners : one.mesh.tetrahedra) {
    body.appendTetra(static_cast<int>(corners[0]), static_cast<int>(corners[1]),
                     static_cast<int>(corners[2]), static_cast<int>(corners[3]));
    const Eigen::Matrix3d edges =
        analysis::EdgesOf(corners, [&](std::uint32_t i) { return places[i]; });
    one.elements.push_back({edges.determinant() / 6, edges.inverse()});
  }
  // What Bullet's readers of files do after the last tetrahedron.
  btSoftBody::TetraScratch at_rest;
  for (btMatrix3x3* matrix : {&at_rest.m_F, &at_rest.m_cofF, &at_rest.m_corotation})
    matrix->setIdentity();
  at_rest.m_trace = 3;
  at_rest.m_J = 1;
  body.m_tetraScratches.resize(body.m_tetras.size(), at_rest);
  body.m_tetraScratchesTn.resize(body.m_tetras.size(), at_rest);
  body.initializeDmInverse();
}

/// `places`: of all nodes, relative to `position`.
Drive DriveOf(const plan::Group& group, const analysis::SoftMesh& mesh, const Vector3d& position,
              const std::vector<Vector3d>& places) {
  Drive drive;
  drive.nodes = analysis::DrivenNodes(group, mesh);
  if (drive.nodes.empty()) {
    if (analysis::HasDrivenPins(group))
      throw library::SceneError(
          fmt::format("group {}: soft.drive.pin moves no nodes: there are none there, or soft.pin "
                      "holds them all",
                      group.name),
          "name another side in soft.drive.pin, or remove it from soft.pin");
    return drive;
  }
  Vector3d mean = Vector3d::Zero();
  for (const std::uint32_t node : drive.nodes)
    mean += places[node] / static_cast<double>(drive.nodes.size());
  for (const std::uint32_t node : drive.nodes) drive.from.push_back(places[node] - mean);
  drive.centre = position + mean;
  drive.linear_velocity = *schema::AsVector(group.settings.Get("soft.drive.linear_velocity"));
  drive.angular_velocity = *schema::AsVector(group.settings.Get("soft.drive.angular_velocity"));
  return drive;
}

/// m: where sweep and prune counts its steps from.
double Reach(const plan::Scene& scene, const layouts::InitialState& state) {
  const double half = scene.world.Real("world.side") / 2;
  double fastest = 0;
  for (const ObjectState& object : state.objects)
    fastest = std::max(fastest, object.linear_velocity.norm());
  for (const plan::Group& group : scene.groups)
    if (analysis::HasDrivenPins(group))
      fastest = std::max(
          fastest, schema::AsVector(group.settings.Get("soft.drive.linear_velocity"))->norm());
  const double seconds =
      scene.world.Real("timestep") *
      static_cast<double>(scene.world.Count("cycles") + scene.world.Count("warmup"));
  const double flight = fastest * seconds + state.acceleration.norm() * seconds * seconds / 2;
  return scene.world.WordOr("world.walls") == "all"
             ? half
             : std::min(half + flight, std::max(half, analysis::kLargestBox));
}

}  // namespace

Vector3d Drive::PlaceAt(std::size_t i, double time) const {
  return centre + time * linear_velocity + layouts::TurnAbout(time * angular_velocity) * from[i];
}

void PhaseClock::Begin(Phase phase) {
  if (is_on_) begin_[protocol::IndexOf(phase)] = world::TakeStamp();
}

void PhaseClock::End(Phase phase) {
  const std::size_t i = protocol::IndexOf(phase);
  if (is_on_) spent_[i] = spent_[i] + (world::TakeStamp() - begin_[i]);
}

world::PhaseStamps PhaseClock::Phases() const {
  world::PhaseStamps phases = {};
  std::ranges::copy(spent_, phases.begin());
  phases[protocol::IndexOf(Phase::kDetect)] =
      spent_[protocol::IndexOf(Phase::kBroad)] + spent_[protocol::IndexOf(Phase::kNarrow)];
  return phases;
}

SoftWorld::SoftWorld(const plan::Scene& scene, layouts::InitialState state)
    : scene_(scene),
      state_(std::move(state)),
      timestep_(static_cast<btScalar>(scene.world.Real("timestep"))),
      side_(scene.world.Real("world.side")),
      has_springs_(scene.world.WordOr("soft_world") == "springs"),
      kinematics_(scene_),
      configuration_(std::make_unique<btSoftBodyRigidBodyCollisionConfiguration>()),
      dispatcher_(std::make_unique<TimedDispatcher>(configuration_.get(), clock_)) {
  layouts::CheckRange(scene_, state_);
  if (analysis::MeasuresPhases(scene_)) clock_.Enable();
  const auto reach = static_cast<btScalar>(Reach(scene_, state_));
  const btVector3 corner(reach, reach, reach), gravity = ToBullet(state_.acceleration);
  broad_phase_ = detection::MakeBroadPhase({.detector = scene_.world.WordOr("detector"),
                                            .bodies = state_.objects.size() + omissions::kWallCount,
                                            .lower = -corner,
                                            .upper = corner});
  if (has_springs_) {
    world_ = std::make_unique<SpringWorld>(clock_, *dispatcher_, *broad_phase_, *configuration_,
                                           gravity);
  } else {
    world_ =
        std::make_unique<PositionWorld>(clock_, *dispatcher_, *broad_phase_, *configuration_,
                                        static_cast<int>(scene_.world.Count("solver.iterations")));
  }
  btDiscreteDynamicsWorld& world = world_->world();
  world.setGravity(gravity);
  world.getSolverInfo().m_numIterations = static_cast<int>(scene_.world.Count("solver.iterations"));
  world.getDispatchInfo().m_deterministicOverlappingPairs =
      scene_.world.WordOr("pair_order") == "sorted";
  btSoftBodyWorldInfo& info = world_->info();
  info.m_gravity = gravity;
  if (const auto* cell = schema::AsNumber(scene_.world.Get("soft_cell")))
    info.m_sparsesdf.setDefaultVoxelsz(static_cast<btScalar>(cell->AsReal()));
  info.m_sparsesdf.Reset();
  for (std::size_t i = 0; i < state_.objects.size(); ++i) {
    const ObjectState& object = state_.objects[i];
    if (analysis::IsSoft(scene_.groups[object.group])) {
      MakeSoft(object, i);
    } else {
      MakeRigid(object, i);
    }
  }
  const std::uint8_t standing = omissions::StandingWalls(scene_);
  for (int wall = 0; wall < omissions::kWallCount; ++wall)
    if ((standing & 1 << wall) != 0) MakeWall(wall);
}

// Bullet searches all pairs for each body that it removes.
SoftWorld::~SoftWorld() {
  for (const SoftObject& one : bodies_) world_->world().removeCollisionObject(one.body.get());
  for (const auto& body : rigid_) world_->world().removeRigidBody(body.get());
  for (const auto& body : walls_) world_->world().removeRigidBody(body.get());
}

void SoftWorld::Step() {
  btDiscreteDynamicsWorld& world = world_->world();
  kinematics_.BeforeStep(steps_);
  for (const SoftObject& one : bodies_) MoveDriven(one);
  clock_.Reset();
  clock_.Begin(Phase::kStep);
  world.stepSimulation(timestep_, 1, timestep_);
  clock_.End(Phase::kStep);
  kinematics_.AfterStep(steps_);
  if (++steps_ % kCollectEvery == 0) world_->info().m_sparsesdf.GarbageCollect(1);
}

std::size_t SoftWorld::ContactCount() const {
  std::size_t count = 0;
  for (const SoftObject& one : bodies_) {
    const btSoftBody& body = *one.body;
    count +=
        static_cast<std::size_t>(body.m_rcontacts.size() + body.m_scontacts.size() +
                                 body.m_nodeRigidContacts.size() + body.m_faceNodeContacts.size());
  }
  return count;
}

void SoftWorld::MoveDriven(const SoftObject& one) const {
  const double timestep = scene_.world.Real("timestep"),
               time = static_cast<double>(steps_ + 1) * timestep;
  for (std::size_t i = 0; i < one.drive.nodes.size(); ++i) {
    btSoftBody::Node& node = one.body->m_nodes[static_cast<int>(one.drive.nodes[i])];
    const Vector3d way = one.drive.PlaceAt(i, time) - world::ToEigen(node.m_x);
    node.m_v = ToBullet(way / static_cast<double>(timestep_));
  }
}

void SoftWorld::MakeRigid(const ObjectState& object, std::size_t index) {
  auto body = world::MakeBody(object, shapes_.Get(object.solid, object.numbers["margin"]));
  if (!object.IsFixed()) body->setActivationState(DISABLE_DEACTIVATION);
  body->setUserIndex(static_cast<int>(index));
  if (object.is_kinematic) kinematics_.Add(state_.objects[index], *body);
  world_->world().addRigidBody(body.get());
  rigid_.push_back(std::move(body));
}

void SoftWorld::MakeWall(int wall) {
  const int axis = wall / 2, sign = wall % 2 == 0 ? -1 : 1;
  const double thickness = omissions::kWallThickness * side_;
  Vector3d half = Vector3d::Constant(side_ / 2 + thickness), centre = Vector3d::Zero();
  half[axis] = thickness / 2;
  centre[axis] = sign * (side_ + thickness) / 2;
  wall_shapes_.push_back(std::make_unique<btBoxShape>(ToBullet(half)));
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, wall_shapes_.back().get());
  info.m_startWorldTransform.setOrigin(ToBullet(centre));
  info.m_friction = static_cast<btScalar>(scene_.world.Real("world.wall_friction"));
  auto body = std::make_unique<btRigidBody>(info);
  body->setUserIndex(static_cast<int>(state_.objects.size()) + wall);
  world_->world().addRigidBody(body.get());
  walls_.push_back(std::move(body));
}

void SoftWorld::MakeSoft(const ObjectState& object, std::size_t index) {
  const plan::Group& group = scene_.groups[object.group];
  SoftObject one{index, nullptr, objects::SoftMeshOf(group.settings.Get("type")), {}, {}, 0};
  const std::size_t count = one.mesh.NodeCount();
  const double margin = object.numbers["margin"];
  one.masses = analysis::MassShares(one.mesh);
  for (double& mass : one.masses) mass *= object.mass;
  const std::vector<Vector3d> places = layouts::NodesAbout(scene_, object);
  // That of a mesh need not be in the middle of its box.
  Vector3d centre = Vector3d::Zero();
  if (!one.mesh.places.empty())
    for (std::size_t node = 0; node < count; ++node)
      centre += one.masses[node] / object.mass * places[node];
  const std::vector<std::uint32_t> pinned = analysis::PinnedNodes(group, one.mesh);
  if (pinned.empty() && !group.settings.Lists("soft.pin", "none"))
    throw library::SceneError(
        fmt::format("group {}: soft.pin holds no nodes: there are none there", group.name),
        "name another side, such as `pin bottom`");
  for (const std::uint32_t node : pinned) one.masses[node] = 0;
  one.drive = DriveOf(group, one.mesh, object.pose.position, places);
  for (const std::uint32_t node : one.drive.nodes) one.masses[node] = 0;
  btAlignedObjectArray<btVector3> points;
  btAlignedObjectArray<btScalar> masses;
  for (std::size_t node = 0; node < count; ++node) {
    points.push_back(ToBullet(object.pose.position + places[node]));
    masses.push_back(static_cast<btScalar>(one.masses[node]));
  }
  one.body = std::make_unique<btSoftBody>(&world_->info(), static_cast<int>(count), &points[0],
                                          &masses[0]);
  btSoftBody& body = *one.body;
  for (const auto& [a, b] : one.mesh.links) {
    body.appendLink(static_cast<int>(a), static_cast<int>(b), body.m_materials[0]);
    one.rest.push_back((places[a] - places[b]).norm());
  }
  for (const auto& [a, b, c] : one.mesh.triangles)
    body.appendFace(static_cast<int>(a), static_cast<int>(b), static_cast<int>(c));
  if (!one.mesh.tetrahedra.empty()) AddElements(group, places, one);
  body.getCollisionShape()->setMargin(static_cast<btScalar>(margin));
  body.m_cfg.kDF = static_cast<btScalar>(object.numbers["friction"]);
  // Bullet takes the fraction of a step.
  body.m_cfg.kDP = static_cast<btScalar>(
      1 - std::pow(1 - object.numbers["linear_damping"], scene_.world.Real("timestep")));
  for (std::size_t node = 0; node < count; ++node)
    if (one.masses[node] > 0)
      body.m_nodes[static_cast<int>(node)].m_v =
          ToBullet(object.linear_velocity + object.angular_velocity.cross(places[node] - centre));
  body.setActivationState(DISABLE_DEACTIVATION);
  body.setUserIndex(static_cast<int>(index));
  if (has_springs_ && one.elements.empty()) one.stiffness = group.settings.Real("soft.stiffness");
  world_->Add(body, group);
  bodies_.push_back(std::move(one));
}

std::string StateHash(const SoftWorld& world) {
  using Bits = std::conditional_t<sizeof(btScalar) == 8, std::uint64_t, std::uint32_t>;
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](const btVector3& vector) {
    for (int axis = 0; axis < 3; ++axis) {
      Bits bits = std::bit_cast<Bits>(vector[axis]);
      for (std::size_t i = 0; i < sizeof(bits); ++i, bits >>= 8)
        hash = (hash ^ (bits & 0xff)) * 0x100000001b3;
    }
  };
  for (const SoftObject& one : world.bodies())
    for (int i = 0; i < one.body->m_nodes.size(); ++i) {
      add(one.body->m_nodes[i].m_x);
      add(one.body->m_nodes[i].m_v);
    }
  for (const auto& body : world.rigid()) {
    if (body->isStaticObject()) continue;
    add(body->getWorldTransform().getOrigin());
    for (int row = 0; row < 3; ++row) add(body->getWorldTransform().getBasis()[row]);
    add(body->getLinearVelocity());
    add(body->getAngularVelocity());
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace cdb::soft
