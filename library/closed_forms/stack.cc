// One column of boxes that stand on each other and stay at rest.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

class Stack : public ClosedForm {
 public:
  explicit Stack(Truth rest, double energy_scale)
      : rest_(std::move(rest)), energy_scale_(energy_scale) {}
  Truth At(double) const override { return rest_; }
  double energy_scale() const override { return energy_scale_; }

 private:
  Truth rest_;
  double energy_scale_;
};

}  // namespace

std::unique_ptr<ClosedForm> MakeStack(const Fit& fit) {
  fit.RequireLevelFloor();
  std::vector<std::size_t> upwards(fit.size());
  std::iota(upwards.begin(), upwards.end(), 0);
  std::ranges::sort(upwards, {}, [&](std::size_t i) { return fit.object(i).pose.position.y(); });
  Truth rest;
  rest.positions.resize(fit.size());
  rest.velocities.assign(fit.size(), Vector3d::Zero());
  rest.spins.assign(fit.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < fit.size(); ++i)
    rest.orientations.push_back(fit.object(i).pose.orientation);
  rest.momentum = rest.angular_momentum = Vector3d::Zero();
  double energy = 0, scale = 0, top = fit.WallAt(-1), top_at_start = top;
  const Vector3d axis = fit.object(upwards[0]).pose.position;
  for (const std::size_t i : upwards) {
    fit.RequireNoSpin(i);
    fit.RequireNoVelocity(i);
    const layouts::ObjectState& box = fit.object(i);
    const double height = box.solid.sides[fit.RequireLevelCuboid(i)];
    const Vector3d start = box.pose.position;
    Vector3d off = start - axis;
    off.y() = 0;
    if (off.norm() > kSame * box.solid.sides.norm())
      fit.Refuse(fit.Name(i) + " is not in one column with the lowest",
                 "make location stack, with one column");
    fit.RequireStanding(i, start.y() - height / 2 - top_at_start, height);
    top_at_start = start.y() + height / 2;
    rest.positions[i] = {start.x(), top + height / 2, start.z()};
    top += height;
    const double weight = box.mass * fit.Pressing();
    energy += weight * (rest.positions[i].y() - start.y());
    scale += weight * (start.y() - fit.WallAt(-1));
  }
  rest.energy = energy;
  return std::make_unique<Stack>(std::move(rest), scale);
}

}  // namespace cdb::closed_forms
