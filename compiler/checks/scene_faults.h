// Scenes of a benchmark that cannot be built or have another closed form: each fault once, with the
// number of its runs.
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

/// Not for several threads.
class SceneFaults {
 public:
  /// `benchmark`: where its name stands, for what no setting is to blame for. `find` may be empty:
  /// then there are no faults. `most_objects`: that are placed.
  SceneFaults(text::Span benchmark, analysis::FindSceneFault find, dsl::Diagnostics& diagnostics,
              std::uint64_t most_objects = kMostObjects)
      : benchmark_(benchmark),
        find_(std::move(find)),
        diagnostics_(diagnostics),
        most_objects_(most_objects) {}

  /// The scene at the chosen point of `configuration`, which is run so many times. Scenes that
  /// place the same objects are looked at once, and no more than hold `most_objects` together, or
  /// kMostPairs of objects that a closed form may look at, which take a second or two: the rest
  /// shows when it is run.
  void Add(configure::Configuration& configuration, const plan::Scene& scene, std::size_t runs);
  /// Of a plan of so many runs. A wrong closed form is an error, and so are objects that cannot be
  /// placed in any run; where only some runs fail of it, the others are worth having: a warning.
  void Report(std::size_t runs) const;

  static constexpr std::uint64_t kMostObjects = 1'000'000, kMostPairs = 200'000'000;

 private:
  struct Finding {
    analysis::SceneFault fault;  ///< of the first run
    text::Span span;
    bool is_default_size = false;
    std::size_t runs = 0;
  };
  using FindingKey = std::pair<analysis::SceneFault::Kind, std::string>;  ///< by group

  /// Nullopt where the scene is not looked at.
  std::optional<std::optional<analysis::SceneFault>> Find(const plan::Scene& scene);
  void WarnOfDefaultSizes(configure::Configuration& configuration, const plan::Scene& scene);
  /// Spheres whose sides are drawn one by one.
  void WarnOfEllipsoids(configure::Configuration& configuration, const plan::Scene& scene);
  text::Span SpanOf(configure::Configuration& configuration,
                    const analysis::SceneFault& fault) const;

  text::Span benchmark_;
  analysis::FindSceneFault find_;
  dsl::Diagnostics& diagnostics_;
  std::uint64_t most_objects_;
  std::map<std::string, std::optional<std::optional<analysis::SceneFault>>>
      known_;                              ///< by what decides it
  std::uint64_t objects_ = 0, pairs_ = 0;  ///< looked at so far
  std::size_t unplaced_runs_ = 0, looked_at_ = 0;
  std::map<FindingKey, Finding> findings_;
  std::set<std::string> default_sizes_;  ///< groups that were warned of
};

}  // namespace cdb::checks
