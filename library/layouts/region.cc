#include "library/layouts/region.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "compiler/schema/parametrised_words.h"
#include "library/layouts/exact_layouts.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

[[noreturn]] void Refuse(const plan::Group& group, std::string_view parameter,
                         const std::string& cause, const std::string& remedy) {
  throw library::SceneError(
      fmt::format("the {} of group `{}` cannot be determined: {}", parameter, group.name, cause),
      remedy, group.name, std::string(parameter));
}

class RegionFinder {
 public:
  RegionFinder(const Bodies& bodies, const GroupRange& range) : bodies_(bodies), range_(range) {}

  Region Find() const {
    const schema::Call* call = schema::AsCall(range_.group->settings.Get("region"));
    if (call == nullptr || call->name == "box") return FixedRegionOf(*range_.group, bodies_.side());
    Region region{Beside(*call)};
    region.stands = call->name == "on_top";
    if ((region.box.lower.array() < region.box.upper.array()).all()) return region;
    Refuse("there is no room between the group and the wall", "make world.side larger");
  }

 private:
  objects::Box Cube() const { return CubeOf(bodies_.side()); }

  /// The box at one side of a group.
  objects::Box Beside(const schema::Call& call) const {
    const GroupRange& other = GroupBefore(bodies_, range_, GroupOfRegion(*range_.group), "region");
    objects::Box box = bodies_.BoxOf(other.first);
    for (std::size_t i = other.first + 1; i < other.end; ++i) {
      box.lower = box.lower.cwiseMin(bodies_.BoxOf(i).lower);
      box.upper = box.upper.cwiseMax(bodies_.BoxOf(i).upper);
    }
    Vector3d towards = Vector3d::UnitY();
    const schema::Number* extent = nullptr;
    if (call.name == "beside") {
      const auto* given = std::get_if<Vector3d>(&schema::ArgumentOf(call, "towards"));
      towards = given != nullptr ? *given : Vector3d::UnitX();
      extent = schema::AsNumber(schema::ArgumentOf(call, "width"));
    } else if (call.name == "above") {
      extent = schema::AsNumber(schema::ArgumentOf(call, "height"));
    }
    Eigen::Index axis = 0;
    const double along = towards.cwiseAbs().maxCoeff(&axis);
    if (towards.cwiseAbs().sum() > along)
      Refuse("its direction is not along an axis", "write (1, 0, 0), (0, 0, -1) or the like");
    if (towards[axis] > 0) {
      box.lower[axis] = box.upper[axis];
      box.upper[axis] = extent != nullptr ? box.lower[axis] + extent->AsReal() : Cube().upper[axis];
    } else {
      box.upper[axis] = box.lower[axis];
      box.lower[axis] = extent != nullptr ? box.upper[axis] - extent->AsReal() : Cube().lower[axis];
    }
    return box;
  }

  [[noreturn]] void Refuse(const std::string& cause, const std::string& remedy) const {
    layouts::Refuse(*range_.group, "region", cause, remedy);
  }

  const Bodies& bodies_;
  const GroupRange& range_;
};

}  // namespace

std::string GroupOfRegion(const plan::Group& group) {
  const schema::Call* call = schema::AsCall(group.settings.Get("region"));
  if (call == nullptr || call->name == "box") return {};
  return std::get<schema::Word>(schema::ArgumentOf(*call, "group")).text;
}

std::string GroupOfLayout(const plan::Group& group) {
  const schema::Call* call = schema::AsCall(group.settings.Get("location"));
  if (call == nullptr || call->name != schema::kRelativeCall) return {};
  return std::get<schema::Word>(schema::ArgumentOf(*call, "group")).text;
}

const GroupRange& GroupBefore(const Bodies& bodies, const GroupRange& range, std::string_view name,
                              std::string_view parameter) {
  const auto refuse = [&](const std::string& cause, const std::string& remedy) {
    Refuse(*range.group, parameter, cause, remedy);
  };
  const auto found = std::ranges::find(bodies.groups(), name,
                                       [](const GroupRange& other) { return other.group->name; });
  if (found == bodies.groups().end() || found->size() == 0)
    refuse(fmt::format("there is no group `{}` with objects", name), {});
  if (found->group == range.group)
    refuse("it is at its own group", "name a group that is written before it");
  if (found->first > range.first)
    refuse(fmt::format("group `{}` is written after it, and placed later", name),
           fmt::format("write `{}` first", name));
  if (HasExactLayout(*range.group) && !HasExactLayout(*found->group))
    refuse(fmt::format("group `{}` is placed at random, after all groups with a layout such as {}",
                       name, schema::AsCall(range.group->settings.Get("location"))->name),
           fmt::format("give `{}` a layout, or place `{}` at random as well", name,
                       range.group->name));
  return *found;
}

Region RegionOf(const Bodies& bodies, const GroupRange& range) {
  return RegionFinder(bodies, range).Find();
}

objects::Box CubeOf(double side) {
  const Vector3d half = Vector3d::Constant(side / 2);
  return {-half, half};
}

objects::Box BoxOf(const schema::Call& box) {
  return {std::get<Vector3d>(schema::ArgumentOf(box, "lower")),
          std::get<Vector3d>(schema::ArgumentOf(box, "upper"))};
}

Region FixedRegionOf(const plan::Group& group, double side) {
  const schema::Call* call = schema::AsCall(group.settings.Get("region"));
  Region region{CubeOf(side)};
  if (call == nullptr) {
    region.stands = group.settings.WordOr("region") == "floor";
    region.is_cube = true;
    return region;
  }
  region.box = BoxOf(*call);
  if ((region.box.lower.array() < region.box.upper.array()).all()) return region;
  Refuse(group, "region", "its lower corner is not below its upper one",
         "exchange the coordinates");
}

objects::Box DomainOf(const Region& region, double side, const objects::Box& bounds) {
  const Vector3d half = Vector3d::Constant(side / 2);
  objects::Box domain = {(-half).cwiseMax(region.box.lower) - bounds.lower,
                         half.cwiseMin(region.box.upper) - bounds.upper};
  if (!region.stands) return domain;
  const double gap = kStandingGap * (bounds.upper.y() - bounds.lower.y());
  const double floor = domain.lower.y();
  domain.upper.y() = std::min(domain.upper.y(), floor + 1.5 * gap);
  domain.lower.y() = floor + 0.5 * gap;
  return domain;
}

}  // namespace cdb::layouts
