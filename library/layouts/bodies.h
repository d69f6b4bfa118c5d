// The objects of a scene during placement: cached bounds, and overlap tests.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

inline objects::Box Shifted(const objects::Box& box, const Eigen::Vector3d& by) {
  return {by + box.lower, by + box.upper};
}

/// Inner and outer spheres of a solid about its centre of mass; they decide most pairs.
struct Core {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double inner = 0, outer = 0;  ///< radii, m; `inner` is 0 if the centre is outside the solid
};

/// The objects of one group: indices in [first, end).
struct GroupRange {
  const plan::Group* group;
  std::size_t first, end;
  std::size_t size() const { return end - first; }
};

/// Tolerance for rounding where distances alone decide.
inline constexpr double kRounding = 1e-9;

/// Whether two solids touch whose centres have this squared distance, by the balls inside and
/// around them; nullopt if these do not decide.
inline std::optional<bool> TouchByBalls(double squared_distance, const Core& a, const Core& b) {
  const double inner = a.inner + b.inner;
  if (squared_distance < inner * inner * (1 - kRounding) && a.inner > 0 && b.inner > 0) return true;
  const double outer = a.outer + b.outer;
  if (squared_distance > outer * outer * (1 + kRounding)) return false;
  return std::nullopt;
}

/// Lengths in m. Scene and state must outlive it. Not thread-safe.
class Bodies {
 public:
  Bodies(const plan::Scene& scene, InitialState& state);

  const plan::Scene& scene() const { return scene_; }
  const std::vector<GroupRange>& groups() const { return groups_; }
  double side() const { return side_; }  ///< of the cube
  std::size_t size() const { return state_.objects.size(); }
  const ObjectState& object(std::size_t index) const { return state_.objects[index]; }
  std::span<const ObjectState> ObjectsOf(const GroupRange& range) const {
    return std::span(state_.objects).subspan(range.first, range.size());
  }
  /// With its centre of mass at the origin.
  const objects::Box& bounds(std::size_t index) const { return bounds_[index]; }
  Eigen::Vector3d Extents(std::size_t index) const {
    return bounds_[index].upper - bounds_[index].lower;
  }
  const Core& core(std::size_t index) const { return cores_[index]; }
  /// The box around the object at its current position.
  objects::Box BoxOf(std::size_t index) const {
    return Shifted(bounds_[index], cores_[index].position);
  }

  void MoveTo(std::size_t index, const Eigen::Vector3d& place);
  /// Also turns it; `pose` is that of the body.
  void MoveTo(std::size_t index, const objects::Pose& pose);
  /// Whether the object would touch `other` if it were at `place`, with `box` around it there.
  bool TouchesAt(std::size_t index, const Eigen::Vector3d& place, const objects::Box& box,
                 std::size_t other) const {
    // Inline, as most calls return here.
    const Core& theirs = cores_[other];
    const auto touch = TouchByBalls((theirs.position - place).squaredNorm(), cores_[index], theirs);
    return touch ? *touch : SurfacesTouch(index, place, box, other);
  }

  const plan::Group& GroupOf(std::size_t index) const {
    return *groups_[state_.objects[index].group].group;
  }
  /// For messages: `object 3 of 10 (group `pebbles`)`.
  std::string Name(std::size_t index) const;

 private:
  bool SurfacesTouch(std::size_t index, const Eigen::Vector3d& place, const objects::Box& box,
                     std::size_t other) const;

  const plan::Scene& scene_;
  InitialState& state_;
  double side_;
  std::vector<GroupRange> groups_;
  std::vector<objects::Box> bounds_;
  std::vector<Core> cores_;
};

}  // namespace cdb::layouts
