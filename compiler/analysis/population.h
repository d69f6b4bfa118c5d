// Objects that come into the world while it runs, and leave it: `spawn` and `remove`.
//
// A group with `spawn` has a slot for each object of its quantity, and none in the world at the
// start; slots are filled in order, and not again once their object has left.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/analysis/scene_fault.h"
#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// In cycles from the start, including the warm-up.
struct Spawning {
  std::uint64_t count, every, start;

  /// The objects that are due up to `cycle`, at most `quantity`.
  std::uint64_t DueAt(std::uint64_t cycle, std::uint64_t quantity) const;
};

struct Removal {
  std::optional<double> below;  ///< m, height of the centre of mass
  bool outside_cube = false;
  const schema::Call* outside_box = nullptr;  ///< box( ), of the group's settings
  std::optional<std::uint64_t> after;         ///< cycles in the world
};

/// Nullopt if all objects of the group are there from the start.
std::optional<Spawning> SpawningOf(const plan::Group& group);
/// Nullopt if no object of the group leaves.
std::optional<Removal> RemovalOf(const plan::Group& group);

/// The first group with objects that come or go; null if there is none.
const plan::Group* FindChanging(const plan::Scene& scene);
bool ComesOrGoes(const plan::Scene& scene);
/// Detectors of cdb and Bullet, which are told of each object that comes or goes.
bool KnowsChanges(std::string_view detector);

/// What a scene with objects that come and go cannot have, or only they; nullopt if there is
/// nothing.
std::optional<SettingFault> FindPopulationFault(const plan::Scene& scene);

}  // namespace cdb::analysis
