#include "runtime/engine/world/timed_world.h"

#include <time.h>

namespace cdb::world {

std::int64_t Now() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1000000000} * now.tv_sec + now.tv_nsec;
}

void TimedWorld::TimedStep(btScalar timestep) {
  stamps_.step_begin = Now();
  stepSimulation(timestep, 1, timestep);
  stamps_.step_end = Now();
}

void TimedWorld::performDiscreteCollisionDetection() {
  const bool detects = !Omits(schema::Component::kDetection);
  stamps_.detect_begin = Now();
  if (detects) {
    updateAabbs();
    computeOverlappingPairs();
  }
  stamps_.broad_end = Now();
  if (detects)
    getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher());
  stamps_.detect_end = Now();
}

void TimedWorld::solveConstraints(btContactSolverInfo& info) {
  stamps_.solve_begin = Now();
  LeanWorld::solveConstraints(info);
  stamps_.solve_end = Now();
}

void TimedWorld::integrateTransforms(btScalar timestep) {
  stamps_.integrate_begin = Now();
  LeanWorld::integrateTransforms(timestep);
  stamps_.integrate_end = Now();
}

std::array<double, protocol::kPhaseCount> TimedWorld::Durations() const {
  std::array<double, protocol::kPhaseCount> durations = {};
  const auto set = [&](protocol::Phase phase, std::int64_t begin, std::int64_t end) {
    durations[protocol::IndexOf(phase)] = static_cast<double>(end - begin);
  };
  set(protocol::Phase::kBroad, stamps_.detect_begin, stamps_.broad_end);
  set(protocol::Phase::kNarrow, stamps_.broad_end, stamps_.detect_end);
  set(protocol::Phase::kDetect, stamps_.detect_begin, stamps_.detect_end);
  set(protocol::Phase::kSolve, stamps_.solve_begin, stamps_.solve_end);
  set(protocol::Phase::kIntegrate, stamps_.integrate_begin, stamps_.integrate_end);
  set(protocol::Phase::kStep, stamps_.step_begin, stamps_.step_end);
  return durations;
}

}  // namespace cdb::world
