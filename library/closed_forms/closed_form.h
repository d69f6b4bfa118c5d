// Analytic solutions of simple scenes, without any engine: a ground truth for errors.
//
// In double. SI units. Bodies are rigid, contacts hard, friction Coulomb's; of what Bullet adds
// (sleep, margins, speculative contacts) a form knows nothing, as that is the error to be seen.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "library/scene_error.h"

namespace cdb::closed_forms {

/// What is so at one time. Lists are by object, in the order of the initial state; empty where the
/// form says nothing.
struct Truth {
  std::vector<Eigen::Vector3d> positions;           ///< of the centres of mass, m
  std::vector<Eigen::Vector3d> velocities;          ///< m/s
  std::vector<Eigen::Quaterniond> orientations;     ///< unit
  std::vector<Eigen::Vector3d> spins;               ///< in the world's axes, rad/s
  std::optional<double> energy;                     ///< kinetic and potential, J, above the start's
  std::optional<Eigen::Vector3d> momentum;          ///< of all, kg m/s
  std::optional<Eigen::Vector3d> angular_momentum;  ///< of all, about their centre of mass, kg m²/s
};

/// Not for several threads.
class ClosedForm {
 public:
  virtual ~ClosedForm() = default;
  /// `time_s` after the initial state, warm-up included; from 0 to the end of the run. Ascending
  /// times are the fastest.
  virtual Truth At(double time_s) const = 0;
  /// J, > 0, what errors of energy are divided by: what the scene has at the start above the least
  /// that it can have; where there is no least, what moves or is set free until the end.
  virtual double energy_scale() const = 0;
};

/// `name` is of ClosedForms() (compiler/schema/catalogue.h); any other is our own bug. Throws
/// SceneError that names what in the scene is not of this form, and what would be. Scene and state
/// are looked at and not kept.
std::unique_ptr<ClosedForm> MakeClosedForm(std::string_view name, const plan::Scene& scene,
                                           const layouts::InitialState& state);

}  // namespace cdb::closed_forms
