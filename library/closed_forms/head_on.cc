// Two balls that collide once: momentum is conserved, and the speed of approach is multiplied by
// the product of both restitutions.
#include <fmt/format.h>

#include <algorithm>

#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

class HeadOn : public ClosedForm {
 public:
  /// The balls meet after `meeting` seconds.
  HeadOn(const Fit& fit, double meeting) : objects_(fit.objects()), meeting_(meeting) {
    const layouts::ObjectState &a = objects_[0], &b = objects_[1];
    const double mass = a.mass + b.mass;
    const Vector3d common = (a.mass * a.linear_velocity + b.mass * b.linear_velocity) / mass;
    const double restitution = a.numbers["restitution"] * b.numbers["restitution"];
    after_ = {common + restitution * (common - a.linear_velocity),
              common + restitution * (common - b.linear_velocity)};
    const double closing = (b.linear_velocity - a.linear_velocity).norm();
    energy_scale_ = a.mass * b.mass / mass / 2 * closing * closing;
    lost_ = (1 - restitution * restitution) * energy_scale_;
  }

  Truth At(double time_s) const override {
    Truth truth;
    for (std::size_t i = 0; i < 2; ++i) {
      const layouts::ObjectState& ball = objects_[i];
      const double before = std::min(time_s, meeting_);
      truth.velocities.push_back(time_s < meeting_ ? ball.linear_velocity : after_[i]);
      truth.positions.push_back(ball.pose.position + before * ball.linear_velocity +
                                (time_s - before) * after_[i]);
    }
    truth.energy = time_s < meeting_ ? 0 : -lost_;
    const Momenta momenta = MomentaOf(objects_, truth.positions, truth.velocities, {});
    truth.momentum = momenta.linear;
    truth.angular_momentum = momenta.angular;
    return truth;
  }

  /// Relative to that of the same momentum.
  double energy_scale() const override { return energy_scale_; }
  const Vector3d& after(std::size_t index) const { return after_[index]; }

 private:
  std::vector<layouts::ObjectState> objects_;
  double meeting_, energy_scale_, lost_;
  std::vector<Vector3d> after_;  ///< velocities
};

}  // namespace

std::unique_ptr<ClosedForm> MakeHeadOn(const Fit& fit) {
  if (fit.size() != 2)
    fit.Refuse(fmt::format("there are {} objects", fit.size()), "the closed form has two balls");
  fit.RequireNoAcceleration();
  for (std::size_t i = 0; i < 2; ++i) {
    fit.RequireBall(i);
    fit.RequireNoSpin(i);
  }
  const layouts::ObjectState &a = fit.object(0), &b = fit.object(1);
  const Vector3d apart = b.pose.position - a.pose.position;
  const Vector3d closing = a.linear_velocity - b.linear_velocity;
  const double approach = closing.dot(apart) / apart.norm();
  if (!(approach > 0) || (apart.normalized() * approach - closing).norm() > kSame * approach)
    fit.Refuse("the balls do not come towards each other along the line of their centres",
               "let their velocities differ along that line only");
  const double gap = apart.norm() - (a.solid.sides.x() + b.solid.sides.x()) / 2;
  const double meeting = gap / approach;
  if (meeting >= fit.end())
    fit.Refuse(fmt::format("they meet after {:.4g} s, and the run ends after {:.4g} s", meeting,
                           fit.end()),
               "make it longer, or use `flight`");
  auto form = std::make_unique<HeadOn>(fit, meeting);
  for (std::size_t i = 0; i < 2; ++i) {
    const layouts::ObjectState& ball = fit.object(i);
    const Vector3d at_meeting = ball.pose.position + meeting * ball.linear_velocity;
    fit.RequireClearOfWalls(i, ReachOf(ball), ball.pose.position, ball.linear_velocity,
                            Vector3d::Zero(), meeting);
    fit.RequireClearOfWalls(i, ReachOf(ball), at_meeting, form->after(i), Vector3d::Zero(),
                            fit.end() - meeting);
  }
  return form;
}

}  // namespace cdb::closed_forms
