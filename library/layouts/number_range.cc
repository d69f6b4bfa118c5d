#include "library/layouts/number_range.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

#include "compiler/analysis/population.h"
#include "library/layouts/exact_layouts.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

/// `Scalar`: the type of Bullet's numbers.
template <typename Scalar>
class Range {
 public:
  explicit Range(const plan::Scene& scene) : scene_(scene) {}

  void Check(const InitialState& state) const {
    if (!IsFinite(scene_.world.Real("world.side") / 2)) Refuse("world.side", {}, "world.side");
    if (!IsFinite(state.acceleration)) Refuse("the acceleration", {}, "acceleration");
    for (std::size_t i = 0; i < state.objects.size(); ++i) CheckObject(i, state.objects[i]);
    std::size_t first = 0;
    for (const plan::Group& group : scene_.groups) {
      const std::size_t end = first + group.settings.Count("quantity");
      if (group.HasLinks() && group.settings.WordOr("links.type") == "spring" &&
          HasExactLayout(group))
        for (std::size_t i = first + 1; i < end; ++i) CheckSpring(i, state, group.name);
      first = end;
    }
  }

 private:
  using Vector = Eigen::Matrix<Scalar, 3, 1>;

  static bool IsFinite(double value) { return std::isfinite(static_cast<Scalar>(value)); }
  static bool IsFinite(const Vector3d& v) { return v.cast<Scalar>().allFinite(); }
  static bool IsDivisor(Scalar value) { return std::isfinite(value) && std::isfinite(1 / value); }

  void CheckObject(std::size_t index, const ObjectState& object) const {
    const auto refuse = [&](const char* what, const char* parameter) {
      const std::string& group = scene_.groups[object.group].name;
      Refuse(fmt::format("the {} of object {}", what, index + 1), group, parameter);
    };
    const Vector sides = object.solid.sides.template cast<Scalar>();
    if (!IsFinite(object.pose.position) && !analysis::SpawningOf(scene_.groups[object.group]))
      refuse("position", "location");
    if (!IsFinite(object.solid.sides) || !(sides.squaredNorm() > 0)) refuse("size", "size");
    if (!IsFinite(object.linear_velocity)) refuse("linear velocity", "linear_velocity");
    if (!IsFinite(object.angular_velocity)) refuse("angular velocity", "angular_velocity");
    if (object.IsFixed()) return;
    const auto mass = static_cast<Scalar>(object.mass);
    if (!IsDivisor(mass)) refuse("mass", "mass");
    const Vector inertia = mass * object.solid.InertiaPerMass().template cast<Scalar>();
    for (int axis = 0; axis < 3; ++axis)
      if (!IsDivisor(inertia[axis])) refuse("moment of inertia", "size");
  }

  /// Between object `index` and the one before it.
  void CheckSpring(std::size_t index, const InitialState& state, const std::string& group) const {
    const auto place = [&](std::size_t i) {
      return state.objects[i].pose.position.template cast<Scalar>();
    };
    if (state.objects[index - 1].IsFixed() && state.objects[index].IsFixed()) return;
    if ((place(index) - place(index - 1)).squaredNorm() > 0) return;
    throw library::SceneError(
        fmt::format("object {} begins at the position of the previous object, so their spring has "
                    "no direction",
                    index + 1),
        "use another layout", group, "location");
  }

  [[noreturn]] void Refuse(const std::string& what, const std::string& group,
                           std::string_view parameter) const {
    throw library::SceneError(
        fmt::format("{} is out of reach of {} precision", what, scene_.world.WordOr("precision")),
        {}, group, std::string(parameter));
  }

  const plan::Scene& scene_;
};

}  // namespace

void CheckRange(const plan::Scene& scene, const InitialState& state) {
  if (scene.world.WordOr("precision") == "single") {
    Range<float>(scene).Check(state);
  } else {
    Range<double>(scene).Check(state);
  }
}

}  // namespace cdb::layouts
