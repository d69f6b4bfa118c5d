// The objects of a scene during placement: cached bounds, and overlap tests.
#pragma once

#include <Eigen/Core>
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
    const Core& core = cores_[index];
    const Core& theirs = cores_[other];
    const double distance = (theirs.position - place).squaredNorm();
    const double inner = core.inner + theirs.inner;
    if (distance < inner * inner * (1 - kRounding) && core.inner > 0 && theirs.inner > 0)
      return true;
    const double outer = core.outer + theirs.outer;
    if (distance > outer * outer * (1 + kRounding)) return false;
    return SurfacesTouch(index, place, box, other);
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
