// Scenes of a benchmark that cannot be built or that have another closed form: each fault once,
// with the number of runs that have it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compiler/analysis/scene_fault.h"
#include "compiler/configure/configuration.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// Not thread-safe.
class SceneFaults {
 public:
  /// `benchmark`: the location of its name, for faults that no single setting causes. `find` may be
  /// empty: no faults are then found. `most_objects`: the limit on placed objects.
  SceneFaults(text::Span benchmark, analysis::FindSceneFault find, dsl::Diagnostics& diagnostics,
              std::uint64_t most_objects = kMostObjects)
      : benchmark_(benchmark),
        find_(std::move(find)),
        diagnostics_(diagnostics),
        most_objects_(most_objects) {}

  /// Adds the scene at the chosen point of `configuration`, which has `runs` runs. Scenes that
  /// place the same objects are checked once. Checks stop at `most_objects` objects in total, at
  /// kMostPairs pairs of objects that a closed form may examine, or at kMostDraws random positions
  /// in crowded scenes, which take a second or two: remaining faults show in the runs.
  void Add(configure::Configuration& configuration, const plan::Scene& scene, std::size_t runs);
  /// Reports for a plan of `runs` runs. A wrong closed form is an error, and so are objects that
  /// cannot be placed in any run. If only some runs fail, the others are still useful: a warning.
  void Report(std::size_t runs) const;

  static constexpr std::uint64_t kMostObjects = 1'000'000, kMostPairs = 200'000'000,
                                 kMostDraws = 4'000'000;

 private:
  struct Finding {
    analysis::SceneFault fault;  ///< of the first run
    text::Span span;
    bool is_default_size = false;
    std::size_t runs = 0;
  };
  using FindingKey = std::pair<analysis::SceneFault::Kind, std::string>;  ///< by group

  /// Nullopt if the scene is not checked.
  std::optional<std::optional<analysis::SceneFault>> Find(configure::Configuration& configuration,
                                                          const plan::Scene& scene);
  /// Finds types that are no solids, and those of odd inertias, and warns of hulls that do not fit
  /// their mesh.
  std::optional<analysis::SceneFault> FindInModels(configure::Configuration& configuration,
                                                   const plan::Scene& scene);
  /// `across`: m, the diagonal of the box around the parts.
  void FindOddInertia(configure::Configuration& configuration, const std::string& group,
                      const schema::Value& type, double across);
  void ReportOddInertias() const;
  void WarnOfDefaultSizes(configure::Configuration& configuration, const plan::Scene& scene);
  /// Warns of spheres whose sides are drawn one by one.
  void WarnOfEllipsoids(configure::Configuration& configuration, const plan::Scene& scene);
  /// Warns of orientations of more than a turn, and of limits of joints, which are probably in
  /// degrees.
  void WarnOfDegrees(configure::Configuration& configuration, const plan::Scene& scene);
  text::Span SpanOf(configure::Configuration& configuration,
                    const analysis::SceneFault& fault) const;

  text::Span benchmark_;
  analysis::FindSceneFault find_;
  dsl::Diagnostics& diagnostics_;
  std::uint64_t most_objects_;
  std::map<std::string, std::optional<std::optional<analysis::SceneFault>>>
      known_;                              ///< by the settings that determine the placement
  std::uint64_t objects_ = 0, pairs_ = 0;  ///< examined so far
  std::uint64_t draws_ = kMostDraws;       ///< left
  std::size_t unplaced_runs_ = 0, looked_at_ = 0;
  std::map<FindingKey, Finding> findings_;
  std::set<std::string> default_sizes_;  ///< groups already warned of
  std::set<std::string> poor_fits_;      ///< types already warned of
  /// Groups whose mass is spread as in a body of another size.
  struct OddInertia {
    std::string group;
    double spread, across;  ///< m: the diagonals of a box of that inertia and of the parts
    text::Span span;
  };
  std::vector<OddInertia> odd_inertias_;
  std::set<std::string> degrees_;  ///< joints already warned of
};

}  // namespace cdb::checks
