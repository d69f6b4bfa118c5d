#include "library/layouts/bodies.h"

#include <fmt/format.h>

#include "library/objects/distance.h"

namespace cdb::layouts {
namespace {

bool Meet(const objects::Box& a, const objects::Box& b) {
  return (a.lower.array() <= b.upper.array()).all() && (a.upper.array() >= b.lower.array()).all();
}

}  // namespace

Bodies::Bodies(const plan::Scene& scene, InitialState& state)
    : scene_(scene), state_(state), side_(scene.world.Real("world.side")) {
  std::size_t first = 0;
  for (const plan::Group& group : scene.groups) {
    const std::size_t end = first + group.settings.Count("quantity");
    groups_.push_back({&group, first, end});
    first = end;
  }
  bounds_.reserve(size());
  cores_.reserve(size());
  for (const ObjectState& object : state.objects) {
    bounds_.push_back(objects::Bounds(object.solid, object.pose.orientation));
    cores_.push_back(
        {object.pose.position, object.solid.InnerRadius(), object.solid.OuterRadius()});
  }
}

void Bodies::MoveTo(std::size_t index, const Eigen::Vector3d& place) {
  state_.objects[index].pose.position = place;
  cores_[index].position = place;
}

void Bodies::MoveTo(std::size_t index, const objects::Pose& pose) {
  ObjectState& object = state_.objects[index];
  object.pose.orientation = pose.orientation;
  bounds_[index] = objects::Bounds(object.solid, pose.orientation);
  MoveTo(index, pose.position);
}

bool Bodies::SurfacesTouch(std::size_t index, const Eigen::Vector3d& place, const objects::Box& box,
                           std::size_t other) const {
  const ObjectState &object = state_.objects[index], &neighbour = state_.objects[other];
  return Meet(box, BoxOf(other)) && objects::Overlap(object.solid, {place, object.pose.orientation},
                                                     neighbour.solid, neighbour.pose);
}

std::string Bodies::Name(std::size_t index) const {
  return fmt::format("object {} of {} (group `{}`)", index + 1, size(),
                     scene_.groups[state_.objects[index].group].name);
}

}  // namespace cdb::layouts
