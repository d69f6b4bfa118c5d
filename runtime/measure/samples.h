// Samples compared with the ground truth: the state of every object at even times, taken in a pass
// without a clock, and the resulting errors. Shared by worker, runner and store.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::measure {

/// Of a body's state: position, orientation quaternion x y z w, linear and angular velocity.
inline constexpr std::size_t kStateSize = 13;
/// Of a body once: mass, kg (0 where it is fixed), and size, m.
inline constexpr std::size_t kBodySize = 2;

/// What is summed over all objects at a sample.
enum Observable {
  kKinetic,        ///< J
  kPotential,      ///< J, of weight under the acceleration of the time, and of springs
  kAccelerationX,  ///< m/s^2, of that time
  kAccelerationY,
  kAccelerationZ,
  kMomentumX,  ///< kg m/s
  kMomentumY,
  kMomentumZ,
  kAngularX,  ///< kg m^2/s, about the common centre of mass
  kAngularY,
  kAngularZ,
  kMomentumSum,     ///< of the objects' m|v|
  kAngularSum,      ///< of the lengths of the objects' own
  kDepthMean,       ///< of the contacts that overlap, in sizes of the smaller object; 0 for none
  kDepthMax,        ///< of them
  kContactCount,    ///< contact points
  kPairsExact,      ///< pairs of objects whose exact boxes overlap; no value where nobody asks
  kPairsMissed,     ///< of them, those that the broad phase has not got
  kPairsPhantom,    ///< those that it has got and are none of them
  kOverlapsExact,   ///< overlaps that a closed form tells; no value where nobody asks for geometry
  kOverlapsMissed,  ///< of them, those without a contact point
  kDepthErrorSum,   ///< of the others' |depth - exact|, in sizes of the smaller object
  kNormalErrorSum,  ///< of the angles between normals, rad, where there is only one normal
  kNormalCount,     ///< those
  kObservableCount,
};
std::span<const std::string_view> ObservableNames();
std::span<const std::string_view> StateNames();
/// The unit of each, separated by spaces; 1 where it has none.
std::string_view ObservableUnits();
std::string_view StateUnits();

/// Places in a block of doubles that holds all of a run's samples: bodies, then states, then
/// observables.
struct SampleShape {
  std::size_t samples = 0, objects = 0;

  std::size_t Count() const { return Observables(samples); }
  std::size_t Body(std::size_t object) const { return object * kBodySize; }
  std::size_t State(std::size_t sample, std::size_t object) const {
    return Body(objects) + (sample * objects + object) * kStateSize;
  }
  std::size_t Observables(std::size_t sample) const {
    return State(samples, 0) + sample * kObservableCount;
  }
  bool operator==(const SampleShape&) const = default;
};
/// Nullopt where the scene asks for no errors.
std::optional<SampleShape> SampleShapeOf(const plan::Scene& scene);

/// A run's samples, to be read. `values` are `shape.Count()` of somebody else's.
struct Samples {
  SampleShape shape;
  double interval_s = 0;
  std::span<const double> values;

  double Time(std::size_t sample) const { return static_cast<double>(sample) * interval_s; }
  double mass(std::size_t object) const { return values[shape.Body(object)]; }
  double size(std::size_t object) const { return values[shape.Body(object) + 1]; }
  Eigen::Map<const Eigen::Vector3d> position(std::size_t sample, std::size_t object) const {
    return Eigen::Map<const Eigen::Vector3d>(&values[shape.State(sample, object)]);
  }
  Eigen::Map<const Eigen::Vector3d> velocity(std::size_t sample, std::size_t object) const {
    return Eigen::Map<const Eigen::Vector3d>(&values[shape.State(sample, object) + 7]);
  }
  Eigen::Map<const Eigen::Quaterniond> orientation(std::size_t sample, std::size_t object) const {
    return Eigen::Map<const Eigen::Quaterniond>(&values[shape.State(sample, object) + 3]);
  }
  double observable(std::size_t sample, Observable which) const {
    return values[shape.Observables(sample) + which];
  }
  Eigen::Vector3d acceleration(std::size_t sample) const {
    return Eigen::Map<const Eigen::Vector3d>(&values[shape.Observables(sample) + kAccelerationX]);
  }
  /// Heights are measured along it: against the acceleration at the start; y where there is none.
  Eigen::Vector3d Up() const;
  Eigen::Vector3d momentum(std::size_t sample) const {
    return Eigen::Map<const Eigen::Vector3d>(&values[shape.Observables(sample) + kMomentumX]);
  }
  Eigen::Vector3d angular_momentum(std::size_t sample) const {
    return Eigen::Map<const Eigen::Vector3d>(&values[shape.Observables(sample) + kAngularX]);
  }
  double energy(std::size_t sample) const {
    return observable(sample, kKinetic) + observable(sample, kPotential);
  }
  /// Every object's state is a number at every sample.
  bool IsFinite() const;
};

/// The errors of one run, by the arrays of /accuracy that hold them: one value, or one a sample.
struct RunErrors {
  std::map<std::string, std::vector<double>, std::less<>> values;
  std::string truth;    ///< what they are compared with: a closed form, or a reference's id
  std::string message;  ///< why some have no value; empty where all have
};

}  // namespace cdb::measure
