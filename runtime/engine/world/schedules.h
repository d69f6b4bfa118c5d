// Schedules: accelerations and velocities that change during a run.
//
// `every(n, value)` sets the value anew before every n-th step, `rotating(vector, about, period)`
// before each; both count steps from the start, including the warm-up. Setting a value wakes
// sleeping objects. Velocities are set regardless of changes by contacts since the last time. Not
// thread-safe. Brownian scenes and moving gravity: Serpa & Rodrigues, "Broadmark", Computer
// Graphics Forum 39(1), 2020.
#pragma once

#include <memory>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/distributions/draw.h"
#include "runtime/engine/world/engine.h"

namespace cdb::world {

class Schedules {
 public:
  /// The scene and the engine must outlive it.
  Schedules(const plan::Scene& scene, Engine& engine);

  /// Call before each step. `step` counts from 0. Throws library::SceneError as drawing does.
  void BeforeStep(std::uint64_t step) {
    for (Row& row : rows_) Apply(row, step);
  }

 private:
  enum class Target { kAcceleration, kLinearVelocity, kAngularVelocity };
  /// A parameter with a schedule.
  struct Row {
    Target target;
    const schema::Call* call;
    std::unique_ptr<distributions::Draw> draw;  ///< of `every`
    std::size_t first = 0, end = 0;             ///< objects
  };

  void Add(Target target, const plan::Group* group, const schema::Parameter& parameter,
           std::size_t first, std::size_t end);
  void Apply(Row& row, std::uint64_t step);
  Eigen::Vector3d ValueAt(Row& row, std::uint64_t step) const;

  const plan::Scene& scene_;
  Engine& engine_;
  std::vector<Row> rows_;
};

}  // namespace cdb::world
