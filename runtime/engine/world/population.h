// The objects that come into the world while it runs, and leave it.
#pragma once

#include <cstdint>
#include <vector>

#include "compiler/analysis/population.h"
#include "compiler/plan/plan.h"
#include "library/layouts/emitter.h"
#include "library/objects/solid.h"

namespace cdb::world {

class Engine;

/// Before a cycle, objects leave that meet a condition where they are, and then those come that are
/// due, in the order of their group, each at a free place of its region. One for which none is
/// found waits, and so do those after it; they are tried again before the next cycle. Depends on
/// nothing but the states of the objects. Not thread-safe.
class Population {
 public:
  /// The engine must outlive it; its objects are those of the start.
  Population(const plan::Scene& scene, Engine& engine);

  /// `step` counts from 0, from the start including the warm-up.
  void BeforeStep(std::uint64_t step);

  /// Of the last BeforeStep.
  struct Change {
    std::int32_t spawned = 0, departed = 0, waiting = 0;
    double ns = 0;  ///< to add and remove bodies, without finding places
  };
  const Change& last() const { return last_; }

 private:
  struct Source {
    analysis::Spawning spawning;
    layouts::Emitter emitter;
    std::size_t next;  ///< the object that comes next
  };
  struct Sink {
    std::size_t first, end;  ///< objects
    analysis::Removal removal;
    objects::Box box;  ///< out of which they leave, if they do
    bool has_box = false;
  };

  bool Leaves(const Sink& sink, std::size_t object, std::uint64_t step) const;
  void RemoveAt(std::uint64_t step);
  void SpawnAt(Source& source, std::uint64_t step);

  Engine& engine_;
  std::vector<Source> sources_;
  std::vector<Sink> sinks_;
  std::vector<std::uint64_t> since_;  ///< by object, the step before which it came
  Change last_;
};

}  // namespace cdb::world
