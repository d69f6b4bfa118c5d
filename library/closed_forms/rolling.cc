// A plate of mass M on N balls of mass m and moment I that roll on the floor, all under an
// acceleration a along it; after the rolling test of SimBenchmark
// (leggedrobotics.github.io/SimBenchmark). Nothing slips, so that the top of a ball, and with it
// the plate, moves twice as fast as its centre, and the work of a becomes kinetic energy:
//   d/dt [M (2v)²/2 + N (m + I/r²) v²/2] = M a 2v + N m a v
//   v' = a (2M + N m) / (4M + N (m + I/r²))
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

class Rolling : public ClosedForm {
 public:
  /// `along` is the acceleration of the balls, `rest` the position of each object's centre when it
  /// stands.
  Rolling(const Fit& fit, std::size_t plate, double radius, const Vector3d& along,
          std::vector<Vector3d> rest)
      : objects_(fit.objects()),
        plate_(plate),
        radius_(radius),
        along_(along),
        rest_(std::move(rest)) {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const Vector3d weight = objects_[i].mass * fit.acceleration();
      released_ += weight.dot(Way(i, fit.end()));
      settled_ -= weight.dot(rest_[i] - objects_[i].pose.position);
    }
  }

  Truth At(double time_s) const override {
    Truth truth;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const bool is_plate = i == plate_;
      truth.positions.push_back(rest_[i] + Way(i, time_s));
      truth.velocities.push_back((is_plate ? 2 : 1) * time_s * along_);
      truth.spins.push_back(is_plate
                                ? Vector3d(Vector3d::Zero())
                                : Vector3d(Vector3d::UnitY().cross(time_s * along_) / radius_));
    }
    truth.energy = settled_;
    const Momenta momenta = MomentaOf(objects_, truth.positions, truth.velocities, truth.spins);
    truth.momentum = momenta.linear;
    truth.angular_momentum = momenta.angular;
    return truth;
  }

  double energy_scale() const override { return released_; }

 private:
  Vector3d Way(std::size_t index, double time_s) const {
    return (index == plate_ ? 2 : 1) * time_s * time_s / 2 * along_;
  }

  std::vector<layouts::ObjectState> objects_;
  std::size_t plate_;
  double radius_;
  Vector3d along_;
  std::vector<Vector3d> rest_;
  double released_ = 0;  ///< until the end, J
  double settled_ = 0;   ///< from the start to `rest_`, J
};

const objects::Box kNowhere = {Vector3d::Constant(HUGE_VAL), Vector3d::Constant(-HUGE_VAL)};

void Extend(objects::Box& box, const Vector3d& point) {
  box = {box.lower.cwiseMin(point), box.upper.cwiseMax(point)};
}

/// The only object that is not a ball.
std::size_t RequirePlateOnBalls(const Fit& fit) {
  std::size_t plate = fit.size();
  for (std::size_t i = 0; i < fit.size(); ++i) {
    fit.RequireNoSpin(i);
    fit.RequireNoVelocity(i);
    if (fit.object(i).numbers["rolling_friction"] != 0)
      fit.Refuse(fit.Name(i) + " has rolling friction", "make its rolling_friction 0");
    if (fit.object(i).solid.shape != objects::Shape::kCuboid) continue;
    if (plate < fit.size())
      fit.Refuse("there is more than one cuboid", "the closed form has one cuboid, on balls");
    plate = i;
  }
  if (plate == fit.size()) fit.Refuse("there is no cuboid", "put one on the balls");
  if (fit.size() < 2) fit.Refuse("there are no balls", "put the cuboid on balls");
  return plate;
}

/// The requirements for a plate and its balls; each function rejects the scene if one is violated.
struct PlateOnBalls {
  const Fit& fit;
  const std::size_t plate_index;
  const int upright;  ///< the upright axis of the plate
  const layouts::ObjectState& plate;
  const layouts::ObjectState& ball;  ///< one of the balls, which must all be alike

  double radius() const { return ball.solid.sides.x() / 2; }
  double height() const { return plate.solid.sides[upright]; }
  double balls() const { return static_cast<double>(fit.size() - 1); }
  Vector3d FromPlate(std::size_t i) const {
    return fit.object(i).pose.position - plate.pose.position;
  }

  /// The positions from which they roll, by object. `way`: the displacement of the plate past a
  /// ball until the end.
  std::vector<Vector3d> RequireRest(const Vector3d& way) const {
    const double floor = fit.WallAt(-1);
    std::vector<Vector3d> rest(fit.size());
    for (std::size_t i = 0; i < fit.size(); ++i) {
      const Vector3d& position = fit.object(i).pose.position;
      rest[i] = position;
      if (i == plate_index) {
        rest[i].y() = floor + 2 * radius() + height() / 2;
        fit.RequireStanding(i, position.y() - rest[i].y(), height());
        continue;
      }
      RequireLikeBall(i);
      rest[i].y() = floor + radius();
      fit.RequireStanding(i, position.y() - rest[i].y(), 2 * radius());
      if (!fit.IsOverBase(plate_index, upright, FromPlate(i)) ||
          !fit.IsOverBase(plate_index, upright, FromPlate(i) - way))
        fit.Refuse(fit.Name(i) + " is not under the plate from start to end",
                   "make the plate larger or the run shorter");
    }
    return rest;
  }

  void RequireLikeBall(std::size_t i) const {
    fit.RequireBall(i);
    const layouts::ObjectState& object = fit.object(i);
    if (object.solid.sides != ball.solid.sides || object.mass != ball.mass ||
        object.numbers["friction"] != ball.numbers["friction"])
      fit.Refuse(fit.Name(i) + " differs from the other balls",
                 "give all the same size, mass and friction");
  }

  /// The point below the plate where the forces of the balls act in sum must be between the balls,
  /// judged by their bounding box. `held`: the acceleration of the plate by friction, m/s^2.
  void RequireNoTipping(const Vector3d& held, const Vector3d& way) const {
    objects::Box at_start = kNowhere, at_end = kNowhere;  // of the centres, relative to the plate
    for (std::size_t i = 0; i < fit.size(); ++i) {
      if (i == plate_index) continue;
      Extend(at_start, FromPlate(i));
      Extend(at_end, FromPlate(i) - way);
    }
    const Vector3d pressed = held / fit.Pressing() * height() / 2;
    for (const objects::Box& box : {at_start, at_end})
      for (const int axis : {0, 2})
        if (pressed[axis] < box.lower[axis] || pressed[axis] > box.upper[axis])
          fit.Refuse("the plate would tip off the balls",
                     "put balls under its ends, or make the run shorter");
  }

  /// The friction needed to prevent slipping, summed over all balls.
  void RequireNoSlipping(const Vector3d& downhill, const Vector3d& along) const {
    const Vector3d held = downhill - 2 * along;
    const double on_plate = plate.mass * held.norm();
    const double on_floor =
        (balls() * ball.mass * (along - downhill) + plate.mass * (2 * along - downhill)).norm();
    const double above =
        plate.numbers["friction"] * ball.numbers["friction"] * plate.mass * fit.Pressing();
    const double below = ball.numbers["friction"] * fit.WallFriction() *
                         (plate.mass + balls() * ball.mass) * fit.Pressing();
    if (on_plate > above || on_floor > below)
      fit.Refuse(
          fmt::format("the balls would slip on the {}", on_plate > above ? "plate" : "floor"),
          "make the friction larger or tilt the acceleration less");
  }
};

}  // namespace

std::unique_ptr<ClosedForm> MakeRolling(const Fit& fit) {
  fit.RequireFloor();
  const std::size_t plate_index = RequirePlateOnBalls(fit);
  const layouts::ObjectState& plate = fit.object(plate_index);
  const layouts::ObjectState& ball = fit.object(plate_index == 0 ? 1 : 0);
  const PlateOnBalls system = {fit, plate_index, fit.RequireLevelCuboid(plate_index), plate, ball};
  const double radius = system.radius();

  // The plate moves past each ball by as much as the ball moves.
  const double rolling = ball.mass * (1 + ball.solid.InertiaPerMass().x() / (radius * radius));
  const double gain =
      (2 * plate.mass + system.balls() * ball.mass) / (4 * plate.mass + system.balls() * rolling);
  const Vector3d downhill = fit.Downhill(), along = gain * downhill;
  if (downhill.isZero(0)) fit.Refuse("the acceleration is straight down", "tilt it");
  const Vector3d way = along * fit.end() * fit.end() / 2;

  std::vector<Vector3d> rest = system.RequireRest(way);
  system.RequireNoTipping(downhill - 2 * along, way);
  system.RequireNoSlipping(downhill, along);
  return std::make_unique<Rolling>(fit, plate_index, radius, along, std::move(rest));
}

}  // namespace cdb::closed_forms
