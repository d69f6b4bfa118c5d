#include "compiler/schema/components.h"

#include <algorithm>

#include "dsl/text/check.h"

namespace cdb::schema {
namespace {

// clang-format off
constexpr ComponentInfo kTable[] = {
    {Component::kWalls, "walls",
     "pairs of a wall and an object that cannot reach it; the whole wall if no object can",
     "pairs and the broad phase exclude them"},
    {Component::kRaycastTree, "raycast_tree",
     "the tree for ray casts that Bullet keeps beside sap and sap32",
     "the broad phase has no tree for ray casts"},
    {Component::kDetection, "detection",
     "broad and narrow phase, if nothing can touch and `record` does not ask for them",
     "nothing is detected"},
    {Component::kSolver, "solver",
     "islands and constraint solver, if nothing can touch",
     "solve only applies forces to velocities"},
    {Component::kSleeping, "sleeping",
     "the detection of objects at rest, if no object can come to rest",
     "step excludes it"},
    {Component::kSweptContacts, "swept_contacts",
     "the pass that finds contacts along the paths of ccd objects", ""},
    {Component::kGravity, "gravity",
     "the pass that applies gravity", ""},
    {Component::kDamping, "damping",
     "two calls of pow per object and cycle", ""},
    {Component::kRotation, "rotation",
     "the rotation of objects that never spin", ""},
    {Component::kMotionStates, "motion_states",
     "the pass that reports poses to a renderer", ""},
    {Component::kStaticBoxes, "static_boxes",
     "recomputing the boxes of walls and fixed objects in each cycle", ""},
    {Component::kPools, "pools",
     "memory for more contacts than the scene can have", ""},
    {Component::kWallPairs, "wall_pairs",
     "pairs of an object and a plane whose half-space its box does not reach; only if named",
     "pairs and the broad phase exclude them", false},
};
// clang-format on

}  // namespace

std::span<const ComponentInfo> Components() { return kTable; }

const ComponentInfo& InfoOf(Component component) {
  const ComponentInfo& info = kTable[static_cast<std::size_t>(component)];
  CDB_CHECK(info.component == component);
  return info;
}

const ComponentInfo* FindComponent(std::string_view name) {
  const auto* row = std::ranges::find(kTable, name, &ComponentInfo::name);
  return row == std::end(kTable) ? nullptr : row;
}

}  // namespace cdb::schema
