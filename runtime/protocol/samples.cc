#include "runtime/protocol/samples.h"

#include <algorithm>
#include <cmath>

#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"

namespace cdb::protocol {

std::span<const std::string_view> ObservableNames() {
  static constexpr std::string_view kNames[kObservableCount] = {
      "kinetic",         "potential",       "acceleration_x",   "acceleration_y", "acceleration_z",
      "momentum_x",      "momentum_y",      "momentum_z",       "angular_x",      "angular_y",
      "angular_z",       "momentum_sum",    "angular_sum",      "depth_mean",     "depth_max",
      "contacts",        "pairs_exact",     "pairs_missed",     "pairs_phantom",  "overlaps_exact",
      "overlaps_missed", "depth_error_sum", "normal_error_sum", "normals"};
  return kNames;
}

std::span<const std::string_view> StateNames() {
  static constexpr std::string_view kNames[kStateSize] = {"x",  "y",  "z",  "qx", "qy", "qz", "qw",
                                                          "vx", "vy", "vz", "wx", "wy", "wz"};
  return kNames;
}

std::string_view ObservableUnits() {
  return "J J m/s^2 m/s^2 m/s^2 kg.m/s kg.m/s kg.m/s kg.m^2/s kg.m^2/s kg.m^2/s kg.m/s kg.m^2/s "
         "1 1 1 1 1 1 1 1 1 rad 1";
}

std::string_view StateUnits() { return "m m m 1 1 1 1 m/s m/s m/s rad/s rad/s rad/s"; }

std::optional<SampleShape> SampleShapeOf(const plan::Scene& scene) {
  const auto sampling = analysis::SamplingOf(scene);
  if (!sampling) return std::nullopt;
  return SampleShape{sampling->count, analysis::HasSoft(scene) ? analysis::NodeCount(scene) +
                                                                     analysis::FreeRigidCount(scene)
                                                               : scene.ObjectCount()};
}

Eigen::Vector3d Samples::Up() const {
  const Eigen::Vector3d start = acceleration(0);
  return start.isZero(0) ? Eigen::Vector3d::UnitY() : Eigen::Vector3d(-start.stableNormalized());
}

bool Samples::IsFinite() const {
  const auto states =
      values.subspan(shape.State(0, 0), shape.State(shape.samples, 0) - shape.State(0, 0));
  return std::ranges::all_of(states, [](double value) { return std::isfinite(value); });
}

}  // namespace cdb::protocol
