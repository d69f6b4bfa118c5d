#include "runtime/engine/world/motor_watch.h"

#include <algorithm>

#include "runtime/engine/world/manifolds.h"
#include "runtime/engine/world/multibodies.h"

namespace cdb::world {
namespace {

/// What joints and gears connect, except by what does not move.
struct Machine {
  std::size_t bodies = 0, joints = 0, gears = 0, motors = 0;
  bool is_held = false;  ///< by what does not move

  bool MayContradict() const {
    const bool has_loop = joints + (is_held ? 0 : 1) > bodies;
    return motors > 1 && (has_loop || gears > 0);
  }
};

}  // namespace

MotorWatch::MotorWatch(std::span<const JointFrame> joints, std::span<Gear* const> gears) {
  std::vector<std::size_t> above;  // disjoint sets, by body
  const auto root_of = [&](std::size_t body) {
    while (above[body] != body) body = above[body] = above[above[body]];
    return body;
  };
  const auto index_of = [&](const btRigidBody& body) {
    const auto [found, is_new] = machines_.emplace(&body, above.size());
    if (is_new) above.push_back(above.size());
    return found->second;
  };
  const auto moves = [](const btRigidBody& body) { return !body.isStaticOrKinematicObject(); };
  const auto body_of = [&](const btRigidBody& first, const btRigidBody& second) {
    return root_of(index_of(moves(first) ? first : second));
  };
  const auto join = [&](const btRigidBody& first, const btRigidBody& second) {
    if (moves(first) && moves(second)) above[root_of(index_of(first))] = root_of(index_of(second));
  };
  for (const JointFrame& joint : joints) {
    for (const btRigidBody* body : {joint.first, joint.second})
      if (moves(*body)) index_of(*body);
    join(*joint.first, *joint.second);
  }
  for (const Gear* gear : gears) {
    const JointAxis &a = gear->driven(), &b = gear->driver();
    join(moves(a.first()) ? a.first() : a.second(), moves(b.first()) ? b.first() : b.second());
  }
  std::vector<Machine> machines(above.size());
  for (auto& [body, machine] : machines_) {
    machine = root_of(machine);
    ++machines[machine].bodies;
  }
  for (const JointFrame& joint : joints) {
    if (!moves(*joint.first) && !moves(*joint.second)) continue;
    Machine& machine = machines[body_of(*joint.first, *joint.second)];
    ++machine.joints;
    machine.is_held = machine.is_held || !moves(*joint.first) || !moves(*joint.second);
    machine.motors += joint.drive != nullptr && joint.drive->HasMotor() ? 1 : 0;
  }
  for (const Gear* gear : gears)
    ++machines[body_of(gear->driven().first(), gear->driven().second())].gears;
  is_touched_.resize(machines.size());
  for (const JointFrame& joint : joints) {
    if (joint.drive == nullptr || !joint.drive->HasMotor()) continue;
    if (!moves(*joint.first) && !moves(*joint.second)) continue;
    const std::size_t machine = body_of(*joint.first, *joint.second);
    if (!machines[machine].MayContradict()) motors_.push_back({joint.drive, machine});
  }
}

std::optional<double> MotorWatch::LargestMiss(btCollisionWorld& world, double length) {
  std::ranges::fill(is_touched_, 0);
  for (const btPersistentManifold& manifold : TouchingManifolds(world))
    for (const btCollisionObject* body : {manifold.getBody0(), manifold.getBody1()})
      if (const auto found = machines_.find(body); found != machines_.end())
        is_touched_[found->second] = 1;
  std::optional<double> largest;
  for (const Motor& motor : motors_) {
    const std::optional<double> miss = motor.drive->TakeMiss(length);
    if (miss && is_touched_[motor.machine] == 0) largest = std::max(largest.value_or(0), *miss);
  }
  return largest;
}

}  // namespace cdb::world
