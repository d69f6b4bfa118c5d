// Settings that a benchmark says and that move or judge nothing in any of its runs.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>

#include "compiler/configure/configuration.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// Velocities of fixed objects, kinematic objects that nothing moves, and expectations of scenes
/// that are driven. Not for several threads.
class IdleSettings {
 public:
  /// `benchmark`: where its name stands, for what no setting is to blame for.
  IdleSettings(text::Span benchmark, dsl::Diagnostics& diagnostics)
      : benchmark_(benchmark), diagnostics_(diagnostics) {}

  /// The scene at the chosen point of `configuration`.
  void Add(configure::Configuration& configuration, const plan::Scene& scene);
  /// Warns of what was idle in every scene that was added.
  void Report() const;

 private:
  struct Finding {
    text::Span span;
    std::string message, help;
  };
  void Look(configure::Configuration& configuration, const scenario::ParameterKey& key,
            bool is_idle, const std::string& message, const std::string& help);

  text::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  std::map<scenario::ParameterKey, Finding> idle_;
  std::set<scenario::ParameterKey> useful_;  ///< in some scene
};

}  // namespace cdb::checks
