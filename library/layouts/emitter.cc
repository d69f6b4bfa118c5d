#include "library/layouts/emitter.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/analysis/population.h"
#include "library/distributions/draw.h"
#include "library/layouts/bodies.h"
#include "library/objects/distance.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

objects::Box BoxAround(const Core& core) {
  const Vector3d half = Vector3d::Constant(core.outer);
  return {core.position - half, core.position + half};
}

Core CoreAt(const objects::Solid& solid, const Vector3d& place) {
  return {place, solid.InnerRadius(), solid.OuterRadius()};
}

}  // namespace

Emitter::Emitter(const plan::Scene& scene, const std::vector<ObjectState>& objects,
                 std::size_t group)
    : objects_(objects),
      side_(scene.world.Real("world.side")),
      region_(FixedRegionOf(scene.groups[group], side_)),
      stream_(distributions::NamedStream(scene, scene.groups[group].name, "location")) {
  for (std::size_t i = 0; i < group; ++i) first_ += scene.groups[i].settings.Count("quantity");
  end_ = first_ + scene.groups[group].settings.Count("quantity");
  for (std::size_t i = first_; i < end_; ++i)
    largest_ = std::max(largest_, objects[i].solid.OuterRadius());
}

void Emitter::Begin() {
  small_.clear();
  large_.clear();
  grid_.reset();
}

void Emitter::Meet(std::size_t index, const objects::Pose& pose) {
  const objects::Solid& solid = objects_[index].solid;
  const double outer = solid.OuterRadius();
  const Vector3d nearest = pose.position.cwiseMax(region_.box.lower).cwiseMin(region_.box.upper);
  const double reach = (outer + 2 * largest_) * (1 + kRounding);
  if ((pose.position - nearest).squaredNorm() > reach * reach) return;
  (outer > largest_ ? large_ : small_)
      .push_back({CoreAt(solid, pose.position), index, pose.orientation});
  grid_.reset();
}

void Emitter::AddToGrid(std::size_t neighbour) {
  grid_->Add(static_cast<std::uint32_t>(neighbour), HashGrid::LevelOf(2 * largest_),
             BoxAround(small_[neighbour].core));
}

bool Emitter::Touches(std::size_t index, const Core& core, const Neighbour& other) const {
  const ObjectState& object = objects_[index];
  const auto touch =
      TouchByBalls((other.core.position - core.position).squaredNorm(), core, other.core);
  if (touch) return *touch;
  return objects::Overlap(object.solid, {core.position, object.pose.orientation},
                          objects_[other.index].solid, {other.core.position, other.orientation});
}

bool Emitter::IsFree(std::size_t index, const Vector3d& place) const {
  const Core core = CoreAt(objects_[index].solid, place);
  for (const Neighbour& other : large_)
    if (Touches(index, core, other)) return false;
  return !grid_->AnyOf(BoxAround(core),
                       [&](std::uint32_t other) { return Touches(index, core, small_[other]); });
}

std::optional<Vector3d> Emitter::FindPlace(std::size_t index) {
  if (!grid_) {
    grid_.emplace(2 * small_.size() + 64);  // with room for those that come
    for (std::size_t i = 0; i < small_.size(); ++i) AddToGrid(i);
  }
  const ObjectState& object = objects_[index];
  const objects::Box domain =
      DomainOf(region_, side_, objects::Bounds(object.solid, object.pose.orientation));
  for (int draw = 0; draw < kMostDraws; ++draw) {
    Vector3d place;
    for (int axis = 0; axis < 3; ++axis)
      place[axis] = stream_.Uniform(domain.lower[axis], domain.upper[axis]);
    if (!IsFree(index, place)) continue;
    small_.push_back({CoreAt(object.solid, place), index, object.pose.orientation});
    AddToGrid(small_.size() - 1);
    return place;
  }
  return std::nullopt;
}

void CheckEmitters(const plan::Scene& scene, const InitialState& state) {
  std::size_t index = 0;
  const double side = scene.world.Real("world.side");
  for (const plan::Group& group : scene.groups) {
    const std::size_t end = index + group.settings.Count("quantity");
    if (!analysis::SpawningOf(group)) {
      index = end;
      continue;
    }
    const Region region = FixedRegionOf(group, side);
    for (; index < end; ++index) {
      const ObjectState& object = state.objects[index];
      const objects::Box domain =
          DomainOf(region, side, objects::Bounds(object.solid, object.pose.orientation));
      if ((domain.lower.array() < domain.upper.array()).all()) continue;
      throw library::SceneError(
          fmt::format("object {} of {} (group `{}`) does not fit into the region in which it "
                      "spawns, of {:.4g} x {:.4g} x {:.4g} m within the cube",
                      index + 1, state.objects.size(), group.name, region.Extents().x(),
                      region.Extents().y(), region.Extents().z()),
          "make the region larger, or the size smaller", group.name, "region");
    }
  }
}

}  // namespace cdb::layouts
