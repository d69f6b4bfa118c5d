#include "runtime/engine/world/timed_world.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <string_view>

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#define CDB_HAS_VALGRIND 1
#else
#define CDB_HAS_VALGRIND 0
#endif

namespace cdb::world {
namespace {

/// Whether a count could not be read.
bool g_has_lost_count = false;
/// Null: stamps have no counts.
const machine::EventCounters* g_counters = nullptr;

#if CDB_HAS_VALGRIND
/// Valgrind's, once it is the clock.
int g_log = -1;

/// The count in the answer to `status internal`: `events-1: 122514`, with the number of the thread.
/// -1: there is none.
std::int64_t CountIn(std::string_view answer) {
  constexpr std::string_view kBegin = "\nevents-1: ";
  const std::size_t begin = answer.find(kBegin);
  std::int64_t count = -1;
  if (begin != answer.npos)
    std::from_chars(answer.data() + begin + kBegin.size(), answer.data() + answer.size(), count);
  return count;
}

/// Reads the whole log, in which warnings of Valgrind may precede the answer, and empties it. -1:
/// it has no count, is too long, or cannot be read.
std::int64_t TakeCount() {
  // Not of the heap, so that the addresses of the run are those of a run by time.
  static std::array<char, 1 << 16> log;
  std::size_t length = 0;
  ssize_t size = 0;
  do {
    size = pread(g_log, log.data() + length, log.size() - length, static_cast<off_t>(length));
    if (size > 0) length += static_cast<std::size_t>(size);
  } while (size > 0 || (size < 0 && errno == EINTR));
  // Valgrind writes at the place that its descriptor shares with ours.
  if (size < 0 || ftruncate(g_log, 0) != 0 || lseek(g_log, 0, SEEK_SET) != 0) return -1;
  return length < log.size() ? CountIn({log.data(), length}) : -1;
}

/// Asks Valgrind for the count. The answer is that of the request of callgrind_control(1), which
/// names the functions on the stack after the count. A failure is remembered, and returns the last
/// count, so that no duration is negative.
std::int64_t ReadCount() {
  static std::int64_t last = 0;
  CALLGRIND_TOGGLE_COLLECT;  // off: what follows is the clock's own work
  VALGRIND_MONITOR_COMMAND("status internal");
  if (const std::int64_t count = TakeCount(); count >= 0)
    last = count;
  else
    g_has_lost_count = true;
  CALLGRIND_TOGGLE_COLLECT;
  return last;
}
#endif

}  // namespace

std::int64_t Now() {
#if CDB_HAS_VALGRIND
  if (g_log >= 0) return ReadCount();
#endif
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1000000000} * now.tv_sec + now.tv_nsec;
}

void CountInstructions(int log) {
#if CDB_HAS_VALGRIND
  if (!RUNNING_ON_VALGRIND)
    throw std::runtime_error("clock instructions: this worker was not started by Valgrind");
  if (ftruncate(log, 0) != 0 || lseek(log, 0, SEEK_SET) != 0)
    throw std::runtime_error("clock instructions: cannot read the log of Valgrind");
  g_log = log;
  ReadCount();
  if (g_has_lost_count)
    throw std::runtime_error(
        "clock instructions: this version of Valgrind does not tell its count of instructions");
#else
  static_cast<void>(log);
  throw std::runtime_error(
      "clock instructions: cdb was built without the headers of Valgrind; install the package "
      "valgrind, and build cdb again");
#endif
}

void RequireCounts() {
  if (g_has_lost_count)
    throw std::runtime_error(
        "clock instructions: Valgrind did not tell its count at every stamp, so that the numbers "
        "of instructions are not known; run it again");
}

Stamp operator-(const Stamp& later, const Stamp& earlier) {
  Stamp between = {.time = later.time - earlier.time};
  for (std::size_t i = 0; i < between.counts.size(); ++i)
    between.counts[i] = later.counts[i] - earlier.counts[i];
  return between;
}

Stamp operator+(const Stamp& a, const Stamp& b) {
  Stamp sum = {.time = a.time + b.time};
  for (std::size_t i = 0; i < sum.counts.size(); ++i) sum.counts[i] = a.counts[i] + b.counts[i];
  return sum;
}

Stamp TakeStamp() {
  Stamp stamp;
  if (g_counters != nullptr) stamp.counts = g_counters->Read();
  stamp.time = Now();
  return stamp;
}

void CountEvents() {
  static const machine::EventCounters counters;
  g_counters = &counters;
}

void RecordPhases(const PhaseStamps& phases, std::uint64_t cycle, protocol::Recording& recording) {
  const auto durations = recording.Reals("duration"), counters = recording.Reals("counters");
  const std::size_t cycles =
      std::max(durations.size(), counters.size() / protocol::kCounterCount) / protocol::kPhaseCount;
  for (std::size_t phase = 0; phase < phases.size(); ++phase) {
    if (!phases[phase]) continue;
    if (!durations.empty())
      durations[phase * cycles + cycle] = static_cast<double>(phases[phase]->time);
    if (counters.empty()) continue;
    for (std::size_t i = 0; i < protocol::kCounterCount; ++i)
      counters[(i * phases.size() + phase) * cycles + cycle] = phases[phase]->counts[i];
  }
}

void TimedWorld::TimedStep(btScalar timestep) {
  stamps_.step_begin = TakeStamp();
  stepSimulation(timestep, 1, timestep);
  stamps_.step_end = TakeStamp();
}

void TimedWorld::TimedDetection() {
  stamps_ = {};
  stamps_.step_begin = TakeStamp();
  performDiscreteCollisionDetection();
  stamps_.step_end = TakeStamp();
}

void TimedWorld::performDiscreteCollisionDetection() {
  const bool detects = !Omits(schema::Component::kDetection);
  stamps_.detect_begin = TakeStamp();
  if (detects) {
    updateAabbs();
    computeOverlappingPairs();
  }
  stamps_.broad_end = TakeStamp();
  if (detects)
    getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher());
  stamps_.detect_end = TakeStamp();
}

void TimedWorld::solveConstraints(btContactSolverInfo& info) {
  stamps_.solve_begin = TakeStamp();
  LeanWorld::solveConstraints(info);
  stamps_.solve_end = TakeStamp();
}

void TimedWorld::integrateTransforms(btScalar timestep) {
  stamps_.integrate_begin = TakeStamp();
  LeanWorld::integrateTransforms(timestep);
  stamps_.integrate_end = TakeStamp();
}

PhaseStamps TimedWorld::Phases() const {
  PhaseStamps phases = {};
  const auto set = [&](protocol::Phase phase, const Stamp& begin, const Stamp& end) {
    phases[protocol::IndexOf(phase)] = end - begin;
  };
  set(protocol::Phase::kBroad, stamps_.detect_begin, stamps_.broad_end);
  set(protocol::Phase::kNarrow, stamps_.broad_end, stamps_.detect_end);
  set(protocol::Phase::kDetect, stamps_.detect_begin, stamps_.detect_end);
  set(protocol::Phase::kSolve, stamps_.solve_begin, stamps_.solve_end);
  set(protocol::Phase::kIntegrate, stamps_.integrate_begin, stamps_.integrate_end);
  set(protocol::Phase::kStep, stamps_.step_begin, stamps_.step_end);
  return phases;
}

std::array<double, protocol::kPhaseCount> TimedWorld::Durations() const {
  std::array<double, protocol::kPhaseCount> durations = {};
  std::ranges::transform(Phases(), durations.begin(), [](const std::optional<Stamp>& phase) {
    return static_cast<double>(phase->time);
  });
  return durations;
}

namespace {

using schema::Component;

btVector3 Moved(const btRigidBody& body, btScalar timestep) {
  return body.getWorldTransform().getOrigin() + body.getLinearVelocity() * timestep;
}

/// The impulse that the solver adds to the spin of a body without contacts.
btVector3 SpinImpulse(btRigidBody& body, btScalar timestep) {
  btVector3 impulse = body.getTotalTorque() * body.getInvInertiaTensorWorld() * timestep;
  if ((body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY) != 0)
    impulse += body.computeGyroscopicImpulseImplicit_Body(timestep);
  return impulse;
}

/// The solver first adds the change by contacts, here 0, and then the forces: the first turns -0
/// into 0.
btVector3 AfterSolver(const btVector3& velocity, const btVector3& impulse) {
  return (velocity + btVector3(0, 0, 0)) + impulse;
}

bool SameBits(const btVector3& a, const btVector3& b) {
  return std::memcmp(&a, &b, 3 * sizeof(btScalar)) == 0;
}

}  // namespace

LeanWorld::LeanWorld(btDispatcher* dispatcher, btBroadphaseInterface* broad_phase,
                     btConstraintSolver* solver, btCollisionConfiguration* configuration,
                     const omissions::Omissions& omissions)
    : btDiscreteDynamicsWorld(dispatcher, broad_phase, solver, configuration) {
  for (const analysis::PruningDecision& part : omissions.decisions)
    if (omissions.Omits(part.component)) omitted_ |= 1u << static_cast<int>(part.component);
}

void LeanWorld::updateAabbs() {
  if (view_ != nullptr) {
    view_->UpdateBoxes(getForceUpdateAllAabbs());
  } else {
    btDiscreteDynamicsWorld::updateAabbs();
  }
  // The first update enlarges the boxes with which bodies were added.
  if (Omits(Component::kStaticBoxes)) setForceUpdateAllAabbs(false);
}

void LeanWorld::performDiscreteCollisionDetection() {
  if (Omits(Component::kDetection)) return;
  if (!before_narrow_) return btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
  updateAabbs();
  computeOverlappingPairs();
  before_narrow_();
  getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher());
}

void LeanWorld::solveConstraints(btContactSolverInfo& info) {
  if (multibodies_ != nullptr)
    return multibodies_->Solve(m_nonStaticRigidBodies, *getDispatcher(), m_gravity,
                               getDispatchInfo().m_deterministicOverlappingPairs, info);
  if (!Omits(Component::kSolver)) return btDiscreteDynamicsWorld::solveConstraints(info);
  for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i) {
    btRigidBody& body = *m_nonStaticRigidBodies[i];
    if (body.isActive() && body.getInvMass() != 0) ApplyForces(body, info.m_timeStep);
  }
}

void LeanWorld::ApplyForces(btRigidBody& body, btScalar timestep) {
  body.setLinearVelocity(
      AfterSolver(body.getLinearVelocity(), body.getTotalForce() * body.getInvMass() * timestep));
  if (Omits(Component::kRotation)) return;
  body.setAngularVelocity(AfterSolver(body.getAngularVelocity(), SpinImpulse(body, timestep)));
}

void LeanWorld::applyGravity() {
  if (!Omits(Component::kGravity)) btDiscreteDynamicsWorld::applyGravity();
}

void LeanWorld::synchronizeMotionStates() {
  if (!Omits(Component::kMotionStates)) btDiscreteDynamicsWorld::synchronizeMotionStates();
}

void LeanWorld::predictUnconstraintMotion(btScalar timestep) {
  const bool damps = !Omits(Component::kDamping), turns = !Omits(Component::kRotation);
  if (damps && turns) return btDiscreteDynamicsWorld::predictUnconstraintMotion(timestep);
  for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i) {
    btRigidBody& body = *m_nonStaticRigidBodies[i];
    if (body.isStaticOrKinematicObject()) continue;
    if (damps) body.applyDamping(timestep);
    btTransform& predicted = body.getInterpolationWorldTransform();
    if (turns) {
      body.predictIntegratedTransform(timestep, predicted);
    } else {
      predicted.setOrigin(Moved(body, timestep));  // the orientation stays as it was from the start
    }
  }
}

void LeanWorld::createPredictiveContacts(btScalar timestep) {
  if (!Omits(Component::kSweptContacts))
    btDiscreteDynamicsWorld::createPredictiveContacts(timestep);
}

void LeanWorld::calculateSimulationIslands() {
  if (!Omits(Component::kSolver)) btDiscreteDynamicsWorld::calculateSimulationIslands();
}

void LeanWorld::updateActivationState(btScalar timestep) {
  if (!Omits(Component::kSleeping)) btDiscreteDynamicsWorld::updateActivationState(timestep);
}

void LeanWorld::integrateTransforms(btScalar timestep) {
  if (!Omits(Component::kRotation)) {
    btDiscreteDynamicsWorld::integrateTransforms(timestep);
    if (multibodies_ != nullptr) multibodies_->Integrate(timestep);
    return;
  }
  for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i) {
    btRigidBody& body = *m_nonStaticRigidBodies[i];
    if (!body.isActive() || body.isStaticOrKinematicObject()) continue;
    const btVector3 place = Moved(body, timestep);
    body.getWorldTransform().setOrigin(place);
    body.getInterpolationWorldTransform().setOrigin(place);
  }
}

bool MayOmitRotation(btRigidBody& body, btScalar timestep) {
  const btVector3& spin = body.getAngularVelocity();
  if (!spin.isZero()) return false;
  btTransform turned;
  body.predictIntegratedTransform(timestep, turned);
  const btTransform& pose = body.getWorldTransform();
  for (int row = 0; row < 3; ++row)
    if (!SameBits(turned.getBasis()[row], pose.getBasis()[row])) return false;
  return SameBits(AfterSolver(spin, SpinImpulse(body, timestep)), spin);
}

}  // namespace cdb::world
