// THE table of components: the parts of the engine that a run can leave out. The checker, `cdb doc
// omit`, the plan and the engine read it.
#pragma once

#include <span>
#include <string_view>

namespace cdb::schema {

/// The parts of the engine that a scene may do without, in the order of the table.
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
  std::string_view doc;      ///< what it is, one line
  std::string_view changes;  ///< what of the measurement changes without it; empty: nothing does
  bool is_in_auto = true;    ///< `omit auto` leaves it out where it can; otherwise `omit` names it
  /// Every summary names it where it is left out.
  bool IsVisible() const { return !changes.empty(); }
};
std::span<const ComponentInfo> Components();
const ComponentInfo& InfoOf(Component component);
/// Null where there is none.
const ComponentInfo* FindComponent(std::string_view name);

}  // namespace cdb::schema
