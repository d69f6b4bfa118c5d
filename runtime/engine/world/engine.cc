#include "runtime/engine/world/engine.h"

#include <btBulletDynamicsCommon.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>
#include <string>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/joints.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/recorded.h"
#include "compiler/analysis/reference.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/layouts/number_range.h"
#include "library/scene_error.h"
#include "runtime/engine/detection/adapter_broad_phase.h"
#include "runtime/engine/detection/adapter_dispatcher.h"
#include "runtime/engine/detection/broad_phase.h"
#include "runtime/engine/detection/wall_pairs.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/internal_edges.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::world {
namespace {

using layouts::ObjectState;
using library::SceneError;
using schema::Component;

/// Bullet's default group for moving bodies, and one group for each wall, so that an object can
/// exclude it.
constexpr int kObjectGroup = btBroadphaseProxy::DefaultFilter;
constexpr int WallGroup(int wall) { return 64 << wall; }

/// With `collides_with`, the groups of a class: bits that no wall has.
constexpr int ClassGroup(std::size_t collision_class, bool is_fixed) {
  const auto bit = static_cast<int>(2 * collision_class) + (is_fixed ? 1 : 0);
  return 1 << (bit < 6 ? bit : bit + 6);
}
static_assert(ClassGroup(analysis::kMostCollisionClasses - 1, true) == 1 << 29);

/// N, by group: the largest force of its table; 0 if it has none.
std::vector<double> LargestOfTables(const plan::Scene& scene) {
  const schema::GroupParameter force = "force";
  std::vector<double> largest;
  for (const plan::Group& group : scene.groups) {
    const schema::Call* call = analysis::TimeTableOf(group.settings.Get(force));
    largest.push_back(call == nullptr ? 0 : ReadTable(*call, group.settings, *force).Largest());
  }
  return largest;
}

/// The extent of sweep and prune's coordinates: the cube, and, if walls are missing, also the
/// largest distance that an object can fly in the run, or a robot reach.
double Reach(const plan::Scene& scene, const layouts::InitialState& state) {
  const double half = scene.world.Real("world.side") / 2;
  const analysis::Collisions collisions(scene);
  bool are_held = scene.world.WordOr("world.walls") == "all";
  for (std::size_t i = 0; i < scene.groups.size(); ++i)
    are_held = are_held && collisions.MayTouchWalls(i);
  if (are_held) return half;
  if (analysis::HasConfigurations(scene)) {
    // A folded arm may reach farther than this; sweep and prune then clamps its boxes.
    double farthest = 0;
    for (const ObjectState& object : state.objects)
      farthest = std::max(farthest, object.pose.position.norm() + object.solid.OuterRadius());
    return std::max(half, std::min(2 * farthest, analysis::kLargestBox));
  }
  const std::vector<double> tables = LargestOfTables(scene);
  double fastest = 0, pushed = 0;
  for (const ObjectState& object : state.objects) {
    fastest = std::max(fastest, object.linear_velocity.norm());
    const double force = std::max(object.force.norm(), tables[object.group]);
    if (!object.IsFixed()) pushed = std::max(pushed, force / object.mass);
  }
  const double pull = state.acceleration.norm() + pushed;
  const double seconds =
      scene.world.Real("timestep") *
      static_cast<double>(scene.world.Count("cycles") + scene.world.Count("warmup"));
  const double flight = fastest * seconds + pull * seconds * seconds / 2;
  // Bullet disables bodies that are farther out.
  return std::min(half + flight, std::max(half, analysis::kLargestBox));
}

btDefaultCollisionConstructionInfo PoolSizes(const omissions::Omissions& omissions) {
  btDefaultCollisionConstructionInfo info;
  if (omissions.Omits(Component::kPools))
    info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize =
        std::max(omissions.pool_size, 1);
  return info;
}

/// Takes the place of a solver that is never called.
class NoSolver : public btConstraintSolver {
 public:
  btScalar solveGroup(btCollisionObject**, int, btPersistentManifold**, int, btTypedConstraint**,
                      int, const btContactSolverInfo&, btIDebugDraw*, btDispatcher*) override {
    CDB_CHECK(false);
  }
  void reset() override {}
  btConstraintSolverType getSolverType() const override { return BT_SEQUENTIAL_IMPULSE_SOLVER; }
};

std::unique_ptr<btConstraintSolver> MakeSolver(const plan::Scene& scene,
                                               const omissions::Omissions& omissions) {
  if (omissions.Omits(Component::kSolver)) return std::make_unique<NoSolver>();
  if (analysis::HasGears(scene)) return std::make_unique<GearSolver>();
  if (analysis::FindMotor(scene) != nullptr) return std::make_unique<DriveSolver>();
  return std::make_unique<btSequentialImpulseConstraintSolver>();
}

}  // namespace

Engine::Engine(const plan::Scene& scene, layouts::InitialState state,
               omissions::Omissions omissions)
    : Engine(scene, std::move(state), omissions,
             omissions.Omits(Component::kDetection) ? detection::Detectors{}
                                                    : detection::MakeDetectors(scene)) {}

Engine::Engine(const plan::Scene& scene, layouts::InitialState state,
               omissions::Omissions omissions, const detection::Detectors& detectors)
    : scene_(scene),
      state_(std::move(state)),
      collisions_(scene_),
      omissions_(std::move(omissions)),
      standing_(omissions::StandingWalls(scene)),
      side_(scene.world.Real("world.side")),
      timestep_(static_cast<btScalar>(scene.world.Real("timestep"))),
      faithful_(scene.world.WordOr("contact") == "faithful"),
      sleeping_(scene.world.On("sleeping")),
      acceleration_(state_.acceleration),
      configuration_(PoolSizes(omissions_)),
      solver_(MakeSolver(scene_, omissions_)) {
  layouts::CheckRange(scene_, state_);
  objects_.reserve(state_.objects.size());
  for (const ObjectState& object : state_.objects) {
    MakeObject(object);
    is_present_.push_back(!analysis::SpawningOf(scene_.groups[object.group]));
    present_ += is_present_.back() != 0;
  }
  for (int wall = 0; wall < omissions::kWallCount; ++wall)
    if ((standing_ & 1 << wall) != 0 && IsKept(wall)) MakeWall(wall);
  SettleRotation();
  CutPlanes();
  MakeDetection(detectors);
  links_ = std::make_unique<Links>(scene_, state_, objects_, *world_);
  pushes_ = std::make_unique<Pushes>(scene_, state_, objects_);
  if (analysis::ComesOrGoes(scene_)) population_ = std::make_unique<Population>(scene_, *this);
  acts_ = !pushes_->IsEmpty() || links_->HasTimedMotors();
  if (links_->multibodies() == nullptr) return;
  world_->SolveBy(*links_->multibodies());
  // As in Bullet's own world of multibodies.
  world_->getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
}

void Engine::MakeDetection(const detection::Detectors& detectors) {
  const auto reach = static_cast<btScalar>(Reach(scene_, state_));
  const std::size_t bodies =
      state_.objects.size() + static_cast<std::size_t>(std::popcount(standing_));
  if (!detectors.broad) {
    CDB_CHECK(!detectors.narrow);
    const btVector3 corner(reach, reach, reach);
    dispatcher_ = std::make_unique<btCollisionDispatcher>(&configuration_);
    broad_phase_ = detection::MakeBroadPhase(
        {.detector = omissions_.Omits(Component::kDetection) ? "simple" : detector(),
         .bodies = bodies,
         .lower = -corner,
         .upper = corner,
         .raycast_tree = !omissions_.Omits(Component::kRaycastTree),
         .numbers_bodies = analysis::ComesOrGoes(scene_)});
    return MakeWorld();
  }
  for (const detection::NamedDetector* detector : {&detectors.broad, &detectors.narrow}) {
    detection::CheckHolds(detector->name, detector->max_bodies, bodies);
    if (*detector && analysis::ComesOrGoes(scene_) && !analysis::KnowsChanges(detector->name))
      throw SceneError(fmt::format(
          "detector `{}` is told of its bodies once, at the start, but the objects of {} come and "
          "go; use a detector of cdb or Bullet",
          detector->name, analysis::FindChanging(scene_)->name));
  }
  scene_view_ = std::make_unique<detection::SceneView>(
      objects_, walls_, state_, std::max(detectors.broad.threads, detectors.narrow.threads));
  // Bullet's own broad phases keep all wall pairs by default, as in Bullet alone.
  if ((omissions_.Omits(Component::kWallPairs) || !detection::IsBullets(detectors.broad.name)) &&
      detection::WhyAllWallPairs(scene_, objects_).empty())
    scene_view_->CutPlanes();
  auto broad_phase = std::make_unique<detection::AdapterBroadPhase>(detectors.broad, *scene_view_);
  detection::AdapterBroadPhase& broad = *broad_phase;
  broad_phase_ = std::move(broad_phase);
  detection::AdapterDispatcher* narrow = nullptr;
  if (detectors.narrow) {
    auto dispatcher = std::make_unique<detection::AdapterDispatcher>(
        &configuration_, detectors.narrow, *scene_view_);
    narrow = dispatcher.get();
    dispatcher_ = std::move(dispatcher);
  } else {
    dispatcher_ = std::make_unique<btCollisionDispatcher>(&configuration_);
  }
  MakeWorld();
  world_->ComputeBoxesBy(*scene_view_);
  broad.Prepare();
  if (narrow != nullptr && detectors.narrow.detector != detectors.broad.detector) narrow->Prepare();
}

Engine::~Engine() {
  // Bullet searches all pairs for each body that it removes; without pairs that costs nothing.
  btOverlappingPairCache* cache = broad_phase_->getOverlappingPairCache();
  while (cache->getNumOverlappingPairs() > 0) {
    const btBroadphasePair last =
        cache->getOverlappingPairArray()[cache->getNumOverlappingPairs() - 1];
    if (cache->removeOverlappingPair(last.m_pProxy0, last.m_pProxy1, dispatcher_.get()) ==
            nullptr &&
        cache->findPair(last.m_pProxy0, last.m_pProxy1) != nullptr)
      break;
  }
}

void Engine::BeginStep() {
  const double timestep = scene_.world.Real("timestep");
  links_->BeginStep(static_cast<double>(steps_) * timestep, timestep);
  pushes_->BeforeStep(links_->multibodies());
}

void Engine::EndStep() {
  const auto timestep = static_cast<double>(timestep_);
  links_->EndStep(timestep);
  pushes_->AfterStep(timestep);
  ++steps_;
}

void Engine::SetUpSolver() {
  btContactSolverInfo& info = world_->getSolverInfo();
  info.m_numIterations = static_cast<int>(scene_.world.Count("solver.iterations"));
  info.m_erp = info.m_erp2 = static_cast<btScalar>(scene_.world.Real("solver.erp"));
  const double warm_start = scene_.world.Real("solver.warm_start");
  info.m_warmstartingFactor = static_cast<btScalar>(warm_start);
  if (warm_start == 0) info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;
  // Speculative contacts reduce the rebound, and so does split impulse for shallow ones.
  if (faithful_) info.m_splitImpulsePenetrationThreshold = 0;
}

void Engine::SetAcceleration(const Eigen::Vector3d& acceleration) {
  acceleration_ = acceleration;
  // Bullet applies gravity to active bodies only.
  for (const auto& body : objects_)
    if (!body->isStaticOrKinematicObject()) body->activate(true);
  world_->setGravity(ToBullet(acceleration));
}

bool Engine::IsKept(int wall) const {
  return omissions_.walls.empty() || std::ranges::any_of(omissions_.walls, [&](std::uint8_t kept) {
           return (kept & 1 << wall) != 0;
         });
}

void Engine::MakeObject(const ObjectState& object) {
  const bool smooth_edges =
      object.solid.IsSurface() && scene_.groups[object.group].settings.WordOr("edges") == "smooth";
  btCollisionShape* shape = shapes_.Get(object.solid, object.numbers["margin"], smooth_edges);
  auto body = MakeBody(object, shape);
  if (!object.IsFixed() && (!sleeping_ || analysis::HasPush(scene_.groups[object.group])))
    body->setActivationState(DISABLE_DEACTIVATION);
  if (smooth_edges) {
    gContactAddedCallback = AdjustAtEdges;
    body->setCollisionFlags(body->getCollisionFlags() |
                            btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
  }
  if (std::isfinite(object.numbers["contact_stiffness"]))
    body->setContactStiffnessAndDamping(static_cast<btScalar>(object.numbers["contact_stiffness"]),
                                        static_cast<btScalar>(object.numbers["contact_damping"]));
  if (object.numbers.On("ccd")) {
    // Bullet sweeps only convex shapes, and ignores others silently.
    if (!shape->isConvex())
      throw SceneError(
          fmt::format("object {}: ccd is for convex types, and it is a {}; set "
                      "ccd off for its group",
                      objects_.size() + 1, object.solid.IsSurface() ? "surface" : "compound"));
    const auto radius = static_cast<btScalar>(object.solid.InnerRadius());
    body->setCcdMotionThreshold(radius);
    body->setCcdSweptSphereRadius(radius);
  }
  body->setUserIndex(static_cast<int>(objects_.size()));
  objects_.push_back(std::move(body));
}

void Engine::MakeWall(int wall) {
  const int axis = wall / 2, sign = wall % 2 == 0 ? -1 : 1;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  if (scene_.world.WordOr("world.wall_shape") == "plane") {
    centre[axis] = sign * side_ / 2;
    const btVector3 normal = ToBullet(-sign * Eigen::Vector3d::Unit(axis));
    if (omissions_.Omits(Component::kWallPairs)) {
      wall_shapes_.push_back(std::make_unique<detection::HalfSpaceShape>(normal, btScalar(0)));
    } else {
      wall_shapes_.push_back(std::make_unique<btStaticPlaneShape>(normal, btScalar(0)));
    }
  } else {
    const double thickness = omissions::kWallThickness * side_;
    Eigen::Vector3d half = Eigen::Vector3d::Constant(side_ / 2 + thickness);
    half[axis] = thickness / 2;
    centre[axis] = sign * (side_ + thickness) / 2;
    wall_shapes_.push_back(std::make_unique<btBoxShape>(ToBullet(half)));
  }
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, wall_shapes_.back().get());
  info.m_startWorldTransform.setOrigin(ToBullet(centre));
  info.m_friction = static_cast<btScalar>(scene_.world.Real("world.wall_friction"));
  info.m_restitution = static_cast<btScalar>(scene_.world.Real("world.wall_restitution"));
  auto body = std::make_unique<btRigidBody>(info);
  body->setUserIndex(static_cast<int>(objects_.size()) + wall);
  walls_.push_back(std::move(body));
}

void Engine::SettleRotation() {
  if (!omissions_.Omits(Component::kRotation)) return;
  const auto turning = std::ranges::find_if(objects_, [&](const auto& body) {
    return !body->isStaticOrKinematicObject() && !MayOmitRotation(*body, timestep_);
  });
  if (turning == objects_.end()) return;
  const std::string why =
      fmt::format("object {} rotates because of rounding, without an angular velocity",
                  turning - objects_.begin() + 1);
  if (analysis::RequestFor(scene_, Component::kRotation) == analysis::PruningRequest::kByName)
    throw SceneError(fmt::format("omit rotation: this scene needs it: {}", why));
  omissions_.Keep(Component::kRotation, why);
}

void Engine::CutPlanes() {
  if (!omissions_.Omits(Component::kWallPairs)) return;
  CDB_CHECK(detection::WhyAllWallPairs(scene_, objects_).empty());
  for (const auto& wall : walls_) {
    auto& plane = static_cast<detection::HalfSpaceShape&>(*wall->getCollisionShape());
    plane.SetBox(detection::HalfSpaceBox(*wall, objects_));
  }
}

void Engine::MakeWorld() {
  if (analysis::MeasuresPhases(scene_)) {
    auto world = std::make_unique<TimedWorld>(dispatcher_.get(), broad_phase_.get(), solver_.get(),
                                              &configuration_, omissions_);
    timed_world_ = world.get();
    world_ = std::move(world);
  } else {
    world_ = std::make_unique<LeanWorld>(dispatcher_.get(), broad_phase_.get(), solver_.get(),
                                         &configuration_, omissions_);
  }
  world_->setGravity(ToBullet(state_.acceleration));
  world_->getDispatchInfo().m_deterministicOverlappingPairs =
      scene_.world.WordOr("pair_order") == "sorted";
  SetUpSolver();
  if (faithful_) {
    for (const auto& body : objects_) body->setContactProcessingThreshold(0);
    for (const auto& wall : walls_) wall->setContactProcessingThreshold(0);
  }
  AddBodies();
}

void Engine::AddBodies() {
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (IsPresent(i)) {
      AddObject(i);
    } else if (scene_view_ != nullptr) {
      // Detectors read the filters of all bodies at the start.
      const auto [group, mask] = FilterOf(i);
      scene_view_->SetFilter(static_cast<Id>(i), group, mask);
    }
  }
  for (const auto& wall : walls_) {
    const int own = WallGroup(wall->getUserIndex() - static_cast<int>(objects_.size()));
    if (!collisions_.AllMayTouch()) {
      world_->addRigidBody(wall.get(), own, WallMask());
    } else if (omissions_.walls.empty()) {
      world_->addRigidBody(wall.get());
    } else {
      world_->addRigidBody(wall.get(), own, kObjectGroup);
    }
  }
}

void Engine::AddObject(std::size_t object) {
  const auto [group, mask] = FilterOf(object);
  world_->addRigidBody(objects_[object].get(), group, mask);
}

// With `collides_with`, fixed objects have groups of their own, because two of them never touch.
std::pair<int, int> Engine::FilterOf(std::size_t object) const {
  const bool is_fixed = objects_[object]->isStaticOrKinematicObject();
  int without = 0;
  for (int wall = 0; wall < omissions::kWallCount; ++wall)
    if (IsWithoutWall(object, wall)) without |= WallGroup(wall);
  if (collisions_.AllMayTouch()) {
    // Those that addRigidBody chooses without any.
    if (without != 0) return {kObjectGroup, btBroadphaseProxy::AllFilter & ~without};
    if (!is_fixed) return {kObjectGroup, btBroadphaseProxy::AllFilter};
    return {btBroadphaseProxy::StaticFilter,
            btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter};
  }
  const std::size_t group = state_.objects[object].group;
  int mask = 0;
  for (std::size_t other = 0; other < scene_.groups.size(); ++other) {
    if (!collisions_.MayTouch(group, other)) continue;
    mask |= ClassGroup(collisions_.ClassOf(other), false);
    if (!is_fixed) mask |= ClassGroup(collisions_.ClassOf(other), true);
  }
  if (!is_fixed && collisions_.MayTouchWalls(group))
    for (int wall = 0; wall < omissions::kWallCount; ++wall)
      if ((without & WallGroup(wall)) == 0) mask |= WallGroup(wall);
  return {ClassGroup(collisions_.ClassOf(group), is_fixed), mask};
}

/// With `collides_with`: the groups of moving objects that may touch walls.
int Engine::WallMask() const {
  int movers = 0;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const std::size_t group = state_.objects[i].group;
    if (!objects_[i]->isStaticOrKinematicObject() && collisions_.MayTouchWalls(group))
      movers |= ClassGroup(collisions_.ClassOf(group), false);
  }
  return movers;
}

void Engine::Add(std::size_t object, const Eigen::Vector3d& place) {
  CDB_CHECK(!IsPresent(object));
  btRigidBody& body = *objects_[object];
  btTransform pose = body.getWorldTransform();
  pose.setOrigin(ToBullet(place));
  body.setCenterOfMassTransform(pose);
  const btVector3 velocity = ToBullet(state_.objects[object].linear_velocity),
                  spin = ToBullet(state_.objects[object].angular_velocity);
  body.setLinearVelocity(velocity);
  body.setInterpolationLinearVelocity(velocity);
  body.setAngularVelocity(spin);
  body.setInterpolationAngularVelocity(spin);
  body.forceActivationState(sleeping_ ? ACTIVE_TAG : DISABLE_DEACTIVATION);
  is_present_[object] = 1;
  ++present_;
  AddObject(object);
}

void Engine::Remove(std::span<const std::size_t> objects) {
  for (const std::size_t object : objects) is_present_[object] = 0;
  const auto leaves = [this](const btCollisionObject& body) {
    const auto index = static_cast<std::size_t>(body.getUserIndex());
    return index < objects_.size() && !IsPresent(index);
  };
  // Bullet would leave what lies on them asleep in the air.
  for (const btPersistentManifold& manifold : TouchingManifolds(*world_)) {
    const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
    if (leaves(a)) b.activate();
    if (leaves(b)) a.activate();
  }
  constexpr btScalar kNone = std::numeric_limits<btScalar>::quiet_NaN();
  const btVector3 none(kNone, kNone, kNone);
  for (const std::size_t object : objects) {
    btRigidBody& body = *objects_[object];
    world_->removeRigidBody(&body);
    body.getWorldTransform().setOrigin(none);
    body.getInterpolationWorldTransform().setOrigin(none);
    body.setLinearVelocity(none);
    body.setAngularVelocity(none);
  }
  present_ -= objects.size();
}

namespace {

#ifdef BT_USE_DOUBLE_PRECISION
constexpr std::size_t kScalarBytes = 8;
#else
constexpr std::size_t kScalarBytes = 4;
#endif
static_assert(sizeof(btScalar) == kScalarBytes, "Bullet's headers have a different precision");

}  // namespace

const char* EnginePrecision() { return kScalarBytes == 8 ? "double" : "single"; }

std::string PrecisionMismatch() {
  // This function is compiled into the library, not inline: it reads a transform and writes two
  // vectors in the library's precision. The space suffices for either.
  struct alignas(32) Room {
    unsigned char bytes[512];
  };
  Room pose_room = {}, lower_room = {}, upper_room = {}, shape_room = {};
  static_assert(sizeof(btTransform) <= sizeof(Room) && sizeof(btStaticPlaneShape) <= sizeof(Room));
  auto* pose = new (&pose_room) btTransform(btQuaternion::getIdentity(), btVector3(1, 2, 3));
  auto* lower = new (&lower_room) btVector3(0, 0, 0);
  auto* upper = new (&upper_room) btVector3(0, 0, 0);
  // Virtual, because the symbols of a library of the other precision have the same names.
  const btSphereShape* sphere = new (&shape_room) btSphereShape(4);
  const btCollisionShape* volatile shape = sphere;
  shape->getAabb(*pose, *lower, *upper);
  const bool agrees = lower->x() == -3 && lower->y() == -2 && lower->z() == -1 && upper->x() == 5 &&
                      upper->y() == 6 && upper->z() == 7;
  if (agrees) return "";
  return std::string("this worker was built for Bullet in ") + EnginePrecision() +
         " precision, but the library has another; install libbullet-dev as packaged";
}

namespace {

/// The constant spin, rad/s, that turns one orientation into another in `seconds`, the shorter way.
Eigen::Vector3d SpinBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to,
                            double seconds) {
  const Eigen::AngleAxisd turn(to * from.conjugate());
  return turn.angle() / seconds * turn.axis();
}

btQuaternion QuaternionOf(const Eigen::Quaterniond& turn) {
  return {static_cast<btScalar>(turn.x()), static_cast<btScalar>(turn.y()),
          static_cast<btScalar>(turn.z()), static_cast<btScalar>(turn.w())};
}

}  // namespace

Kinematics::Kinematics(const plan::Scene& scene) : timestep_(scene.world.Real("timestep")) {}

Kinematics::Kinematics(const plan::Scene& scene, Engine& engine) : Kinematics(scene) {
  const auto& objects = engine.initial_state().objects;
  for (std::size_t i = 0; i < objects.size(); ++i)
    if (objects[i].is_kinematic) Add(objects[i], *engine.objects()[i]);
}

void Kinematics::BeforeStep(std::uint64_t step) const {
  for (const auto& [object, body] : all_) {
    const objects::Pose from = layouts::PoseAt(*object, TimeOf(step));
    const objects::Pose to = layouts::PoseAt(*object, TimeOf(step + 1));
    // A constant spin is used directly: beyond half a turn per step, the poses would not determine
    // it.
    const bool is_told = object->path != nullptr && object->path->has_orientation();
    body->setLinearVelocity(ToBullet((to.position - from.position) / timestep_));
    body->setAngularVelocity(ToBullet(is_told
                                          ? SpinBetween(from.orientation, to.orientation, timestep_)
                                          : object->angular_velocity));
  }
}

void Kinematics::AfterStep(std::uint64_t step) const {
  for (const auto& [object, body] : all_) {
    const objects::Pose pose = layouts::PoseAt(*object, TimeOf(step + 1));
    const btTransform transform(QuaternionOf(pose.orientation), ToBullet(pose.position));
    body->setWorldTransform(transform);
    body->setInterpolationWorldTransform(transform);
  }
}

namespace {

using Eigen::Vector3d;
using schema::ArgumentOf;
using schema::GroupParameter;
using schema::WorldParameter;

bool IsDueAt(const schema::Call& call, std::uint64_t step) {
  return call.name != "every" ||
         step % std::get<schema::Number>(ArgumentOf(call, "cycles")).AsCount() == 0;
}

}  // namespace

Schedules::Schedules(const plan::Scene& scene, Engine& engine) : scene_(scene), engine_(engine) {
  Add(Target::kAcceleration, nullptr, *WorldParameter("acceleration"), 0, 1);
  std::size_t first = 0;
  for (const plan::Group& group : scene.groups) {
    const std::size_t end = first + group.settings.Count("quantity");
    Add(Target::kLinearVelocity, &group, *GroupParameter("linear_velocity"), first, end);
    Add(Target::kAngularVelocity, &group, *GroupParameter("angular_velocity"), first, end);
    Add(Target::kForce, &group, *GroupParameter("force"), first, end);
    Add(Target::kTorque, &group, *GroupParameter("torque"), first, end);
    first = end;
  }
}

void Schedules::Add(Target target, const plan::Group* group, const schema::Parameter& parameter,
                    std::size_t first, std::size_t end) {
  const schema::Call* call = schema::AsCall(group != nullptr ? group->settings.ValueOf(parameter)
                                                             : scene_.world.ValueOf(parameter));
  if (call == nullptr) return;
  if (first == end) return;
  Row row{target, call, nullptr, {}, first, end};
  if (analysis::TimeTableOf(*call) != nullptr)
    row.table = ReadTable(*call, group->settings, parameter);
  if (call->name == "every") {
    row.draw = std::make_unique<distributions::Draw>(scene_, group, parameter);
    // The initial state already has the first values.
    for (std::size_t i = first; i < end; ++i) row.draw->Vector();
  }
  rows_.push_back(std::move(row));
}

Vector3d Schedules::ValueAt(Row& row, std::uint64_t step) const {
  if (row.draw != nullptr) return row.draw->Vector();
  if (row.table)
    return row.table->VectorAt((static_cast<double>(step) + 0.5) * scene_.world.Real("timestep"));
  const auto& vector = std::get<Vector3d>(ArgumentOf(*row.call, "vector"));
  const auto& about = std::get<Vector3d>(ArgumentOf(*row.call, "about"));
  const double turns = static_cast<double>(step) * scene_.world.Real("timestep") /
                       std::get<schema::Number>(ArgumentOf(*row.call, "period")).AsReal();
  const double angle = 2 * std::numbers::pi * (turns - std::floor(turns));
  return Eigen::AngleAxisd(angle, about.stableNormalized()) * vector;
}

void Schedules::Apply(Row& row, std::uint64_t step) {
  if ((step == 0 && !row.table) || !IsDueAt(*row.call, step)) return;
  if (row.target == Target::kAcceleration) {
    engine_.SetAcceleration(ValueAt(row, step));
    return;
  }
  for (std::size_t i = row.first; i < row.end; ++i) {
    const Vector3d value = ValueAt(row, step);
    btRigidBody& body = *engine_.objects()[i];
    if (body.isStaticOrKinematicObject()) continue;
    body.activate(true);
    switch (row.target) {
      case Target::kAcceleration:
        break;
      case Target::kLinearVelocity:
        body.setLinearVelocity(ToBullet(value));
        break;
      case Target::kAngularVelocity:
        body.setAngularVelocity(ToBullet(value));
        break;
      case Target::kForce:
        engine_.pushes().SetForce(i, value);
        break;
      case Target::kTorque:
        engine_.pushes().SetTorque(i, value);
        break;
    }
  }
}

}  // namespace cdb::world
