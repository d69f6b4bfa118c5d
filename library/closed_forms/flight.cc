// Free fall: x = x0 + v t + a t²/2.
#include <fmt/format.h>

#include <algorithm>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

class Trajectory : public ClosedForm {
 public:
  Trajectory(const Fit& fit, double energy_scale)
      : objects_(fit.objects()), acceleration_(fit.acceleration()), energy_scale_(energy_scale) {
    std::vector<Vector3d> positions, velocities, spins;
    for (const layouts::ObjectState& object : objects_) {
      positions.push_back(object.pose.position);
      velocities.push_back(object.linear_velocity);
      spins.push_back(object.angular_velocity);
      mass_ += object.mass;
    }
    start_ = MomentaOf(objects_, positions, velocities, spins);
  }

  Truth At(double time_s) const override {
    Truth truth;
    for (const layouts::ObjectState& object : objects_) {
      const Vector3d gained = acceleration_ * time_s;
      truth.velocities.push_back(object.linear_velocity + gained);
      truth.positions.push_back(object.pose.position +
                                time_s * (object.linear_velocity + gained / 2));
    }
    truth.energy = 0;
    truth.momentum = start_.linear + mass_ * time_s * acceleration_;
    truth.angular_momentum = start_.angular;
    return truth;
  }

  double energy_scale() const override { return energy_scale_; }

 private:
  std::vector<layouts::ObjectState> objects_;
  Vector3d acceleration_;
  double energy_scale_, mass_ = 0;
  Momenta start_;
};

/// The data that decide whether two objects meet: read for each pair.
struct Flyer {
  Vector3d position, velocity;
  double radius = 0;  ///< around it, m
  bool turns = false;
};

/// Relative to one of the two, the other moves in a straight line, as both fall alike.
bool MayTouch(const Flyer& a, const Flyer& b, double end) {
  const Vector3d apart = b.position - a.position;
  const Vector3d closing = b.velocity - a.velocity;
  const double speed2 = closing.squaredNorm(), reach = a.radius + b.radius;
  if (speed2 == 0 && !a.turns && !b.turns) return false;
  const double nearest = speed2 > 0 ? std::clamp(-apart.dot(closing) / speed2, 0.0, end) : 0.0;
  return (apart + nearest * closing).squaredNorm() <= reach * reach;
}

/// The largest kinetic energy, at the start or at the end: the speed on a parabola is largest
/// there.
double LargestKineticEnergy(const Fit& fit) {
  double start = 0, end = 0;
  for (const layouts::ObjectState& object : fit.objects()) {
    const Vector3d spin = object.pose.orientation.conjugate() * object.angular_velocity;
    const double turning = object.solid.InertiaPerMass().dot(spin.cwiseAbs2());
    const Vector3d last = object.linear_velocity + fit.end() * fit.acceleration();
    start += object.mass / 2 * (object.linear_velocity.squaredNorm() + turning);
    end += object.mass / 2 * (last.squaredNorm() + turning);
  }
  return std::max(start, end);
}

}  // namespace

std::unique_ptr<ClosedForm> MakeFlight(const Fit& fit) {
  std::vector<Flyer> flyers;
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const layouts::ObjectState& object = fit.object(i);
    flyers.push_back({object.pose.position, object.linear_velocity, object.solid.OuterRadius(),
                      !object.angular_velocity.isZero(0)});
    fit.RequireClearOfWalls(i, ReachOf(object), object.pose.position, object.linear_velocity,
                            fit.acceleration(), fit.end());
    for (std::size_t j = 0; j < i; ++j)
      if (MayTouch(flyers[j], flyers[i], fit.end()))
        fit.Refuse(
            fmt::format("{} comes so close to {} that they may touch", fit.Name(i), fit.Name(j)),
            "make the run shorter, or place them farther apart");
  }
  const double energy = LargestKineticEnergy(fit);
  if (energy == 0) fit.Refuse("nothing moves", "give it an acceleration or a velocity");
  return std::make_unique<Trajectory>(fit, energy);
}

}  // namespace cdb::closed_forms
