#include <cstddef>
#include <map>
#include <utility>

#include "library/robots/reader.h"

namespace cdb::robots {

using analysis::Robot;
using analysis::RobotInertia;
using analysis::RobotJoint;
using analysis::RobotLink;
using analysis::RobotShape;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// What a mass at `way` from an axis adds to a tensor.
Matrix3d OfPoint(double mass, const Vector3d& way) {
  return mass * (way.squaredNorm() * Matrix3d::Identity() - way * way.transpose());
}

}  // namespace

RobotInertia Together(const RobotInertia& first, const RobotInertia& second,
                      const Isometry3d& pose) {
  RobotInertia both;
  const Vector3d other = pose * second.centre;
  both.mass = first.mass + second.mass;
  if (both.mass > 0) both.centre = (first.mass * first.centre + second.mass * other) / both.mass;
  both.tensor = first.tensor + pose.linear() * second.tensor * pose.linear().transpose() +
                OfPoint(first.mass, first.centre - both.centre) +
                OfPoint(second.mass, other - both.centre);
  return both;
}

Robot MergeFixed(const Robot& robot, bool only_frames) {
  Robot merged = robot;
  merged.links.clear();
  merged.joints.clear();
  struct Place {
    std::size_t body;
    Isometry3d pose;  ///< of the link in its body
  };
  std::vector<Place> places;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const RobotLink& link = robot.links[i];
    const RobotJoint* joint = i > 0 ? &robot.joints[i - 1] : nullptr;
    const bool is_held = joint != nullptr && joint->type == RobotJoint::Type::kFixed;
    const bool is_joined = is_held && (!only_frames || link.IsFrame() || !link.inertia ||
                                       merged.links[places[joint->parent].body].IsFrame());
    if (!is_joined) {
      places.push_back({merged.links.size(), Isometry3d::Identity()});
      merged.links.push_back(link);
      if (joint == nullptr) continue;
      RobotJoint moved = *joint;
      const Place& parent = places[joint->parent];
      moved.parent = parent.body;
      moved.child = merged.links.size() - 1;
      moved.origin = parent.pose * joint->origin;
      merged.joints.push_back(std::move(moved));
      continue;
    }
    const Place& parent = places[joint->parent];
    const Place place{parent.body, parent.pose * joint->origin};
    RobotLink& body = merged.links[place.body];
    if (body.IsFrame() && !link.IsFrame()) {
      body.parts.push_back(body.name);
      body.name = link.name;
      body.line = link.line;
    } else {
      body.parts.push_back(link.name);
    }
    for (RobotShape shape : link.shapes) {
      shape.pose = place.pose * shape.pose;
      body.shapes.push_back(std::move(shape));
    }
    if (link.inertia)
      body.inertia = Together(body.inertia.value_or(RobotInertia()), *link.inertia, place.pose);
    places.push_back(place);
  }
  return merged;
}

}  // namespace cdb::robots
