// THE table of components: the parts of the engine that a run can leave out. The checker, `cdb doc
// omit`, the plan and the engine read it.
#pragma once

#include <span>
#include <string_view>

namespace cdb::schema {

/// The parts of the engine that a scene can omit, in the order of the table.
enum class Component {
  kWalls,
  kRaycastTree,
  kDetection,
  kSolver,
  kSleeping,
  kSweptContacts,
  kGravity,
  kDamping,
  kRotation,
  kMotionStates,
  kStaticBoxes,
  kPools,
  kWallPairs,
};

/// One row of THE table of components.
struct ComponentInfo {
  Component component;
  std::string_view name;     ///< the word that `omit` takes
  std::string_view doc;      ///< a description, one line
  std::string_view changes;  ///< effect of its omission on the measurement; empty if none
  bool is_in_auto = true;    ///< `omit auto` may leave it out; otherwise `omit` must name it
  /// True if every summary names the component when it is left out.
  bool IsVisible() const { return !changes.empty(); }
};
std::span<const ComponentInfo> Components();
const ComponentInfo& InfoOf(Component component);
/// Null if there is none with this name.
const ComponentInfo* FindComponent(std::string_view name);

}  // namespace cdb::schema
