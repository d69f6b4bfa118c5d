// Analytic solutions of simple scenes, without any engine: a ground truth for errors.
//
// In double. SI units. Bodies are rigid, contacts hard, friction Coulomb's. A form ignores
// everything that Bullet adds (sleep, margins, speculative contacts), as that is the error to be
// measured.
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

/// The true state at one time. Lists are by object, in the order of the initial state; a list is
/// empty if the form does not predict it.
struct Truth {
  std::vector<Eigen::Vector3d> positions;           ///< of the centres of mass, m
  std::vector<Eigen::Vector3d> velocities;          ///< m/s
  std::vector<Eigen::Quaterniond> orientations;     ///< unit
  std::vector<Eigen::Vector3d> spins;               ///< in world axes, rad/s
  std::optional<double> energy;                     ///< kinetic and potential, J, relative to start
  std::optional<Eigen::Vector3d> momentum;          ///< of all, kg m/s
  std::optional<Eigen::Vector3d> angular_momentum;  ///< of all, about their centre of mass, kg m²/s
};

/// Not thread-safe.
class ClosedForm {
 public:
  virtual ~ClosedForm() = default;
  /// `time_s` after the initial state, including warm-up; from 0 to the end of the run. Ascending
  /// times are the fastest.
  virtual Truth At(double time_s) const = 0;
  /// The divisor for errors of energy, J, > 0: the energy at the start above the least possible
  /// energy; if there is no such minimum, the energy that moves or is released until the end.
  virtual double energy_scale() const = 0;
};

/// `name` is one of ClosedForms() (compiler/schema/catalogue.h); any other is an internal error.
/// Throws SceneError that names the property of the scene that violates the form, and a remedy.
/// Scene and state are read but not kept.
std::unique_ptr<ClosedForm> MakeClosedForm(std::string_view name, const plan::Scene& scene,
                                           const layouts::InitialState& state);

}  // namespace cdb::closed_forms
