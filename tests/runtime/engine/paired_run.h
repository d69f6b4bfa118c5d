// Runs the same scene side by side, whole and pruned.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>

#include "runtime/engine/probes/state_hash.h"
#include "runtime/engine/world/engine.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {

struct PairedRun {
  omissions::Omissions omissions;      ///< of the pruned run, at its end
  std::optional<std::string> tripped;  ///< the reason for starting again with all walls
  std::uint64_t tripped_in = 0;        ///< the step before or in which that happened
  std::string names() const { return analysis::OmittedNames(omissions.decisions); }
  bool Omits(schema::Component component) const { return omissions.Omits(component); }
  const std::string& why(schema::Component component) const {
    return omissions.decisions[static_cast<std::size_t>(component)].why;
  }
};

/// Compares the states of all bodies bit by bit: those that `probes::StateHash` covers.
inline bool HaveSameState(const world::Engine& a, const world::Engine& b) {
  const auto same = [](const btVector3& v, const btVector3& w) {
    return std::memcmp(v.m_floats, w.m_floats, 3 * sizeof(btScalar)) == 0;
  };
  return std::ranges::equal(a.objects(), b.objects(), [&](const auto& x, const auto& y) {
    const btTransform &p = x->getWorldTransform(), &q = y->getWorldTransform();
    return same(p.getOrigin(), q.getOrigin()) && same(p.getBasis()[0], q.getBasis()[0]) &&
           same(p.getBasis()[1], q.getBasis()[1]) && same(p.getBasis()[2], q.getBasis()[2]) &&
           same(x->getLinearVelocity(), y->getLinearVelocity()) &&
           same(x->getAngularVelocity(), y->getAngularVelocity());
  });
}

/// Steps both through the whole run, and expects identical states of every body after every step. A
/// pruned run that trips the guard starts again, as in the worker.
inline PairedRun RunPaired(const plan::Scene& scene, const layouts::InitialState& state,
                           omissions::Omissions omissions) {
  PairedRun paired;
  for (;;) {
    world::Engine whole(scene, state, omissions::KeepEverything(scene));
    world::Engine pruned(scene, state, omissions);
    world::OmissionGuard guard(pruned);
    const world::Kinematics of_whole(scene, whole), of_pruned(scene, pruned);
    const std::uint64_t steps = scene.world.Count("warmup") + scene.world.Count("cycles");
    std::uint64_t step = 0;
    try {
      for (; step < steps; ++step) {
        of_whole.BeforeStep(step);
        of_pruned.BeforeStep(step);
        guard.BeforeStep();
        whole.Step();
        pruned.Step();
        of_whole.AfterStep(step);
        of_pruned.AfterStep(step);
        guard.AfterStep();
        if (HaveSameState(whole, pruned)) continue;
        ADD_FAILURE() << "another state after step " << step + 1 << " of " << steps << " without\n"
                      << analysis::DecisionsText(pruned.omissions().decisions);
        break;
      }
      paired.omissions = pruned.omissions();
      return paired;
    } catch (const world::OmissionGuardTripped& tripped) {
      EXPECT_FALSE(paired.tripped) << "tripped again: " << tripped.what();
      if (paired.tripped) return paired;
      paired.tripped = tripped.what();
      paired.tripped_in = step;
      omissions.Keep(schema::Component::kWalls, tripped.what());
    }
  }
}

inline PairedRun RunPaired(const plan::Scene& scene, const layouts::InitialState& state) {
  return RunPaired(scene, state, omissions::DecideOmissions(scene, state));
}

inline PairedRun RunPaired(const plan::Scene& scene) {
  return RunPaired(scene, layouts::MakeInitialState(scene));
}

}  // namespace cdb::tests
