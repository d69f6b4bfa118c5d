// The scenes of the standard suite (`cdb doc suite`).
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "runtime/measure/verdict.h"

namespace cdb::suite {

/// Increase it with every change of a scene, of a bound or of the score: results of different
/// versions are not comparable. tests/golden/suite/ has the plans of each version.
inline constexpr int kSuiteVersion = 2;

/// A kind of application. Its scenes sweep the same configurations.
struct Kind {
  std::string_view name;  ///< the folder below `standard/` in the library of scenarios
  std::string_view doc;
};
std::span<const Kind> Kinds();

struct StandardScene {
  std::string_view kind, name;
  std::string_view what;   ///< for people: `3000 pieces of debris in orbit`
  std::string_view error;  ///< name of its array in /accuracy
  double bound;            ///< a run with a larger error is wrong
  /// A run with a worse verdict is wrong too.
  measure::Verdict worst_verdict = measure::Verdict::kStable;

  /// `games/debris`
  std::string Id() const;
  /// Its name in the library of scenarios: `standard/games/debris`.
  std::string File() const;
  /// `standard_debris.h5`
  std::string ResultName() const;
};
/// Grouped by kind, in the order of Kinds.
std::span<const StandardScene> StandardScenes();

}  // namespace cdb::suite
