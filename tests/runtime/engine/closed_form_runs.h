// Runs of the engine compared with a closed form, and the order of convergence.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "library/closed_forms/closed_form.h"
#include "tests/library/closed_forms/closed_form_scenes.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {

/// The largest error of each kind over the samples of a run.
struct FormErrors {
  double position = 0;          ///< of any object, m
  double velocity = 0;          ///< m/s
  double turn = 0;              ///< of orientation, rad; 0 if the form does not define it
  double energy = 0;            ///< relative to the form's scale
  double momentum = 0;          ///< kg m/s
  double angular_momentum = 0;  ///< relative to the initial value; 0 if that is zero
};

struct Observed {
  double energy = 0;  ///< J
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
};

inline Observed Observe(const world::Engine& engine) {
  Observed sum;
  sum.energy = engine.links().SpringEnergy(0);
  double mass = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  const auto& objects = engine.initial_state().objects;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    mass += objects[i].mass;
    centre += objects[i].mass * Position(engine, i);
  }
  centre /= mass;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const btRigidBody& body = *engine.objects()[i];
    const Eigen::Vector3d v = Velocity(engine, i), x = Position(engine, i);
    const Eigen::Quaterniond turn = Orientation(engine, i);
    const Eigen::Vector3d inertia = objects[i].mass * objects[i].solid.InertiaPerMass();
    const Eigen::Vector3d spin = turn.conjugate() * ToEigen(body.getAngularVelocity());
    sum.energy += objects[i].mass * (v.squaredNorm() / 2 - engine.acceleration().dot(x)) +
                  inertia.dot(spin.cwiseAbs2()) / 2;
    sum.momentum += objects[i].mass * v;
    sum.angular += objects[i].mass * (x - centre).cross(v) + turn * inertia.cwiseProduct(spin);
  }
  return sum;
}

/// Runs the scene to its end and takes a sample every `interval` steps.
inline FormErrors AgainstForm(std::string_view name, const plan::Scene& scene,
                              std::uint64_t interval = 1) {
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const auto form = closed_forms::MakeClosedForm(name, scene, state);
  world::Engine engine = WholeEngine(scene, state);
  const Observed start = Observe(engine);
  const double timestep = scene.world.Real("timestep");
  FormErrors worst;
  for (std::uint64_t n = 1; n <= scene.world.Count("cycles"); ++n) {
    engine.Step();
    if (n % interval != 0) continue;
    const closed_forms::Truth truth = form->At(static_cast<double>(n) * timestep);
    for (std::size_t i = 0; i < state.objects.size(); ++i) {
      worst.position = std::max(worst.position, (Position(engine, i) - truth.positions[i]).norm());
      worst.velocity = std::max(worst.velocity, (Velocity(engine, i) - truth.velocities[i]).norm());
      if (!truth.orientations.empty())
        worst.turn =
            std::max(worst.turn, Orientation(engine, i).angularDistance(truth.orientations[i]));
    }
    const Observed now = Observe(engine);
    worst.energy = std::max(
        worst.energy, std::abs(now.energy - start.energy - *truth.energy) / form->energy_scale());
    worst.momentum = std::max(worst.momentum, (now.momentum - *truth.momentum).norm());
    if (start.angular.norm() > 0)
      worst.angular_momentum =
          std::max(worst.angular_momentum,
                   (now.angular - *truth.angular_momentum).norm() / start.angular.norm());
  }
  return worst;
}

/// The p of error = c dt^p, by a least-squares fit of the logarithms.
inline double OrderOf(const std::vector<double>& timesteps, const std::vector<double>& errors) {
  const auto log = [](const std::vector<double>& values) {
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()))
            .log());
  };
  Eigen::MatrixXd line(timesteps.size(), 2);
  line << Eigen::VectorXd::Ones(static_cast<Eigen::Index>(timesteps.size())), log(timesteps);
  return line.colPivHouseholderQr().solve(log(errors))[1];
}

}  // namespace cdb::tests
