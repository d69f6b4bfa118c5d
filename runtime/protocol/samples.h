// Samples for the comparison with the ground truth: the state of every object at regular times,
// taken in a pass without a clock, and the resulting errors. Of a scene with soft bodies, the
// objects of samples are their nodes, then the rigid objects that contacts move. Shared by worker,
// runner and store.
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

namespace cdb::protocol {

/// Size of a body's state: position, orientation quaternion x y z w, linear and angular velocity.
inline constexpr std::size_t kStateSize = 13;
/// Constants of a body: mass, kg (0 if it is fixed), and size, m; of a node, the size is that of
/// its body.
inline constexpr std::size_t kBodySize = 2;

/// Quantities summed over all objects at a sample.
enum Observable {
  kKinetic,        ///< J
  kPotential,      ///< J, of weight under the acceleration at that time, and of springs
  kAccelerationX,  ///< m/s^2, at that time
  kAccelerationY,
  kAccelerationZ,
  kMomentumX,  ///< kg m/s
  kMomentumY,
  kMomentumZ,
  kAngularX,  ///< kg m^2/s, about the common centre of mass
  kAngularY,
  kAngularZ,
  kMomentumSum,     ///< sum of the objects' m|v|
  kAngularSum,      ///< sum of the magnitudes of the objects' own angular momenta
  kDepthMean,       ///< mean over overlapping contacts, in sizes of the smaller object; 0 if there
                    ///< are none
  kDepthMax,        ///< their maximum
  kContactCount,    ///< contact points
  kPairsExact,      ///< pairs of objects whose exact boxes overlap; no value if not requested
  kPairsMissed,     ///< exact pairs that the broad phase lacks
  kPairsPhantom,    ///< pairs of the broad phase that are not exact pairs
  kOverlapsExact,   ///< exact overlaps that were compared; no value if geometry is not requested
  kOverlapsMissed,  ///< those without a contact point
  kDepthErrorSum,   ///< sum of |depth - exact| over the others, in sizes of the smaller object
  kNormalErrorSum,  ///< sum of the angles between normals, rad, where the normal is unique
  kNormalCount,     ///< number of these angles
  kObservableCount,
};
std::span<const std::string_view> ObservableNames();
std::span<const std::string_view> StateNames();
/// The unit of each observable, separated by spaces; 1 if it has none.
std::string_view ObservableUnits();
std::string_view StateUnits();

/// The layout of all samples of a run in one block of doubles: bodies, then states, then
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
/// Nullopt if the scene requests no errors.
std::optional<SampleShape> SampleShapeOf(const plan::Scene& scene);

/// A read-only view of a run's samples. `values` are `shape.Count()` numbers owned elsewhere.
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
  /// The direction along which heights are measured: against the acceleration at the start; y if
  /// there is none.
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
  /// True if every object's state is finite at every sample.
  bool IsFinite() const;
};

/// The errors of one run, by their arrays in /accuracy: one value, or one per sample.
struct RunErrors {
  std::map<std::string, std::vector<double>, std::less<>> values;
  std::string truth;    ///< the standard that they are compared with: a closed form, or the id of a
                        ///< reference
  std::string message;  ///< the reason why some have no value; empty if all have one
};

}  // namespace cdb::protocol
