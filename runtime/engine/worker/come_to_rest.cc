#include "runtime/engine/worker/come_to_rest.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "dsl/text/check.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::worker {
namespace {

/// Of the drop, and of piles that rest for many runs.
constexpr double kDropStepsOfUnit = 14, kStepsOfUnit = 20;
/// g dt^2 in least half extents: objects sink into one another in proportion to it.
constexpr double kFallOfStep = 0.015;

/// In mean diameters. An object that moves farther in a unit of time is falling.
constexpr double kFallDisplacement = 0.3;

/// Fraction of the velocity that is left after a unit of time: at first, the factor for each later
/// unit, and the least value.
constexpr double kLeftAtFirst = 0.7, kLessLeft = 0.85, kLeastLeft = 0.3;

/// Times that watched objects are looked at.
constexpr int kLooks = 12;
/// Part of the way permitted to an object at rest; one that went less far is not restless yet.
constexpr double kTremble = 0.5;
/// If less than this part of the objects is restless, the others are held while they calm down.
constexpr double kLocalPart = 0.1;

void Damp(world::Engine& engine, const Falling& falling, double left_after_unit) {
  const double left = std::pow(left_after_unit, 1 / falling.UnitOfTime());  // per second
  // For small objects, whose unit is short, the damping would round to 1 and stop them in the air.
  const btScalar most = std::nextafter(btScalar(1), btScalar(0));
  const btScalar damping = std::min(static_cast<btScalar>(1 - left), most);
  for (const std::uint32_t i : falling.objects) engine.objects()[i]->setDamping(damping, damping);
}

class Resting {
 public:
  Resting(world::Engine& engine, const Falling& falling, std::vector<ContactReuse::Body> bodies)
      : engine_(engine), falling_(falling), bodies_(bodies), reuse_(engine, std::move(bodies)) {
    for (const std::uint32_t i : falling_.objects) last_.push_back(PoseOf(i));
  }

  void StepUnit(double left_after_unit, int steps) {
    Damp(engine_, falling_, left_after_unit);
    for (int i = 0; i < steps; ++i) {
      reuse_.BeforeStep();
      engine_.Step();
    }
    displacements_.clear();
    for (std::size_t k = 0; k < falling_.objects.size(); ++k) {
      const std::uint32_t i = falling_.objects[k];
      displacements_.push_back(Displacement(last_[k], PoseOf(i), bodies_[i].radius));
      last_[k] = PoseOf(i);
    }
  }

  /// Number of objects that moved by more than this in the last unit, in mean diameters.
  std::size_t CountFarther(double diameters) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        displacements_, [&](double way) { return !(way <= diameters * falling_.diameter); }));
  }

 private:
  const btTransform& PoseOf(std::uint32_t i) const {
    return engine_.objects()[i]->getWorldTransform();
  }

  world::Engine& engine_;
  const Falling& falling_;
  const std::vector<ContactReuse::Body> bodies_;
  ContactReuse reuse_;
  std::vector<btTransform> last_;      ///< poses of the falling objects, one unit ago
  std::vector<double> displacements_;  ///< in the last unit, m
};

}  // namespace

double Falling::TimestepOf(double steps_of_unit) const {
  return std::min(UnitOfTime() / steps_of_unit,
                  std::sqrt(kFallOfStep * least_half_extent / gravity));
}

double Falling::Timestep() const { return TimestepOf(kStepsOfUnit); }
double Falling::DropTimestep() const { return TimestepOf(kDropStepsOfUnit); }

void FallDown(world::Engine& engine, const Falling& falling, std::vector<ContactReuse::Body> bodies,
              const std::function<void(std::size_t at_rest)>& tell) {
  const std::size_t count = falling.objects.size();
  const auto few = static_cast<std::size_t>(kRestless * static_cast<double>(count));
  const double fall = std::sqrt(2 * engine.side() / falling.gravity);
  const double seconds = kFallTime * falling.UnitOfTime() + fall;
  const auto timestep = static_cast<double>(engine.timestep());
  const int steps = static_cast<int>(std::ceil(falling.UnitOfTime() / timestep));
  Resting resting(engine, falling, std::move(bodies));
  double left = kLeftAtFirst;
  int checks = 0;
  bool is_fallen = false;
  for (double time = 0; time < seconds && checks < kRestChecks; time += steps * timestep) {
    resting.StepUnit(left, steps);
    const std::size_t restless = resting.CountFarther(kRestDisplacement);
    tell(count - restless);
    checks = restless <= few ? checks + 1 : 0;
    is_fallen = is_fallen || resting.CountFarther(kFallDisplacement) <= few;
    if (is_fallen) left = std::max(kLeastLeft, left * kLessLeft);
  }
}

Unrest WatchUnrest(world::Engine& engine, const Falling& falling, double span,
                   std::size_t permitted) {
  const auto timestep = static_cast<double>(engine.timestep());
  const double unit = falling.UnitOfTime();
  const int steps = static_cast<int>(std::ceil(std::max(span, unit) / timestep));
  const int look = std::max(1, steps / kLooks);
  const double most = std::min(kMostRestWay, kRestWay * steps * timestep / unit);
  std::vector<btTransform> start;
  for (const std::uint32_t i : falling.objects)
    start.push_back(engine.objects()[i]->getWorldTransform());
  std::vector<double> ways(start.size(), 0);
  Unrest unrest;
  for (int done = 1; done <= steps; ++done) {
    engine.Step();
    if (done % look != 0 && done != steps) continue;
    unrest = {.moved = {}, .restless = {}, .way = 0, .seconds = done * timestep};
    for (std::size_t k = 0; k < start.size(); ++k) {
      const std::uint32_t i = falling.objects[k];
      const objects::Solid& solid = engine.initial_state().objects[i].solid;
      const double way =
          Displacement(start[k], engine.objects()[i]->getWorldTransform(), solid.OuterRadius()) /
          (2 * solid.LeastHalfExtent());
      // A state that is not finite is not at rest.
      if (!(way <= ways[k])) ways[k] = way;
      if (!(ways[k] <= most)) unrest.moved.push_back(i);
      if (!(ways[k] <= most * std::max(kTremble, static_cast<double>(done) / steps)))
        unrest.restless.push_back(i);
      if (!(ways[k] <= unrest.way)) unrest.way = ways[k];
    }
    if (unrest.moved.size() > permitted) break;
  }
  return unrest;
}

namespace {

/// Fixes all falling objects except for these and those that touch them.
void HoldOthers(world::Engine& engine, const Falling& falling,
                const std::vector<std::uint32_t>& restless) {
  std::vector<char> is_restless(engine.objects().size(), 0), is_free(is_restless);
  for (const std::uint32_t i : restless) is_restless[i] = is_free[i] = 1;
  const auto free_beside = [&](const btCollisionObject* body, const btCollisionObject* other) {
    const auto index = static_cast<std::size_t>(body->getUserIndex()),
               beside = static_cast<std::size_t>(other->getUserIndex());
    if (index < is_free.size() && beside < is_free.size() && is_restless[index] != 0)
      is_free[beside] = 1;
  };
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine.world())) {
    free_beside(manifold.getBody0(), manifold.getBody1());
    free_beside(manifold.getBody1(), manifold.getBody0());
  }
  for (const std::uint32_t i : falling.objects) {
    if (is_free[i] != 0) continue;
    btRigidBody& body = *engine.objects()[i];
    body.setMassProps(0, btVector3(0, 0, 0));
    body.setLinearVelocity(btVector3(0, 0, 0));
    body.setAngularVelocity(btVector3(0, 0, 0));
    body.forceActivationState(ISLAND_SLEEPING);  // no contacts are found between two of them
  }
}

}  // namespace

void CalmDown(world::Engine& engine, const Falling& falling, std::vector<ContactReuse::Body> bodies,
              double seconds, const std::vector<std::uint32_t>& restless) {
  if (static_cast<double>(restless.size()) <
      kLocalPart * static_cast<double>(falling.objects.size()))
    HoldOthers(engine, falling, restless);
  ContactReuse reuse(engine, std::move(bodies));
  Damp(engine, falling, kLeastLeft);
  const double steps = std::ceil(seconds / static_cast<double>(engine.timestep()));
  for (int i = 0; i < static_cast<int>(steps); ++i) {
    reuse.BeforeStep();
    engine.Step();
  }
}

namespace {

/// Stored in a body's second user index, the only data that Bullet's callback can read.
enum : int { kStays = 0, kMoved = 1 };

bool HasMoved(const btBroadphaseProxy& proxy) {
  return static_cast<const btCollisionObject*>(proxy.m_clientObject)->getUserIndex2() == kMoved;
}

void FindContactsOfMoved(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                         const btDispatcherInfo& info) {
  if (pair.m_algorithm == nullptr || HasMoved(*pair.m_pProxy0) || HasMoved(*pair.m_pProxy1))
    return btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
  thread_local btManifoldArray manifolds;  // keeps its memory between calls
  manifolds.resizeNoInitialize(0);
  pair.m_algorithm->getAllContactManifolds(manifolds);
  for (int i = 0; i < manifolds.size(); ++i)
    manifolds[i]->refreshContactPoints(manifolds[i]->getBody0()->getWorldTransform(),
                                       manifolds[i]->getBody1()->getWorldTransform());
}

}  // namespace

double Displacement(const btTransform& from, const btTransform& to, double radius) {
  btScalar squares = 0;
  for (int row = 0; row < 3; ++row)
    squares += (to.getBasis()[row] - from.getBasis()[row]).length2();
  // A rotation by the angle a changes the matrix by 2 sqrt(2) sin(a/2), whatever its axis.
  const double turn = std::sqrt(static_cast<double>(squares)) / std::numbers::sqrt2;
  return static_cast<double>((to.getOrigin() - from.getOrigin()).length()) + radius * turn;
}

ContactReuse::ContactReuse(world::Engine& engine, std::vector<Body> bodies)
    : engine_(engine), bodies_(std::move(bodies)) {
  CDB_CHECK(bodies_.size() == engine_.objects().size());
  for (const auto& body : engine_.objects()) counted_.push_back(body->getWorldTransform());
  static_cast<btCollisionDispatcher*>(engine_.world().getDispatcher())
      ->setNearCallback(FindContactsOfMoved);
}

void ContactReuse::BeforeStep() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    btRigidBody& body = *engine_.objects()[i];
    if (body.isStaticOrKinematicObject()) continue;
    const btTransform& pose = body.getWorldTransform();
    const bool has_moved =
        !(Displacement(counted_[i], pose, bodies_[i].radius) <= bodies_[i].tolerance);
    if (has_moved) counted_[i] = pose;
    body.setUserIndex2(has_moved ? kMoved : kStays);
  }
}

}  // namespace cdb::worker
