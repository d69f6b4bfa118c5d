#include "compiler/schema/components.h"

#include <algorithm>

#include "dsl/check.h"

namespace cdb::schema {
namespace {

// clang-format off
constexpr ComponentInfo kComponents[] = {
    {Component::kWalls, "walls",
     "a wall for the objects that cannot reach it, and the whole wall where none can",
     "pairs and the broad phase are without them"},
    {Component::kRaycastTree, "raycast_tree",
     "the tree for ray casts that Bullet keeps beside sap and sap32",
     "the broad phase keeps no second tree"},
    {Component::kDetection, "detection",
     "broad and narrow phase, where nothing can touch and no record asks for them",
     "nothing is detected"},
    {Component::kSolver, "solver",
     "islands and constraint solver, where nothing can touch",
     "solve is forces becoming velocity, and nothing else"},
    {Component::kSleeping, "sleeping",
     "the watch for objects at rest, where none can come to rest",
     "step is without it"},
    {Component::kSweptContacts, "swept_contacts",
     "the pass that looks for contacts on the way of ccd objects", ""},
    {Component::kGravity, "gravity",
     "the pass that applies gravity", ""},
    {Component::kDamping, "damping",
     "two powers an object and cycle that slow it", ""},
    {Component::kRotation, "rotation",
     "turning objects that never spin", ""},
    {Component::kMotionStates, "motion_states",
     "the pass that would hand poses to a renderer", ""},
    {Component::kStaticBoxes, "static_boxes",
     "boxes of walls and fixed objects, worked out anew each cycle", ""},
    {Component::kPools, "pools",
     "memory set aside for more contacts than the scene can have", ""},
};
// clang-format on

}  // namespace

std::span<const ComponentInfo> Components() { return kComponents; }

const ComponentInfo& InfoOf(Component component) {
  const ComponentInfo& info = kComponents[static_cast<std::size_t>(component)];
  CDB_CHECK(info.component == component);
  return info;
}

const ComponentInfo* FindComponent(std::string_view name) {
  const auto* row = std::ranges::find(kComponents, name, &ComponentInfo::name);
  return row == std::end(kComponents) ? nullptr : row;
}

}  // namespace cdb::schema
