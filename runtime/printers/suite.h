// The figures of the standard suite: tables for a terminal, and JSON for `suite.json` and the page.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/figures/suite.h"

namespace cdb::printers {

/// A table for each kind: score, memory, and the speedup in each scene; then the reasons why
/// configurations have no score.
std::string ScoreText(const std::vector<figures::KindFigures>& kinds);

/// The configuration to choose for each scene and time budget.
std::string RecommendationText(const std::vector<figures::SceneFigures>& scenes);

/// One or two sentences: the scenes in which Bullet's default is wrong, or in which another of
/// Bullet's own configurations is at least 5 % faster, beyond the interval, and no less accurate.
std::string DefaultsText(const std::vector<figures::SceneFigures>& scenes);

/// The best configuration for a scene, and its advantage:
/// `skin: 1.5 ms a step, 1.9 times as fast as dbvt (95 % interval 1.8 .. 2.0). …`
std::string AnswerText(const figures::SceneFigures& scene);

/// Scenes with their results, then the disagreements.
std::string VerificationText(const std::vector<figures::SceneVerification>& scenes);

/// Facts about a folder of results, other than its figures.
struct SuiteFacts {
  bool is_long = false;
  std::optional<std::uint64_t> seed;          ///< a fresh seed in place of the published ones
  std::vector<std::string> missing;           ///< ids of scenes without results
  std::map<std::string, std::string> sha256;  ///< of each results file, by its name
};

/// UTF-8, with a newline. `files`: the results of `scenes`, in the same order. Throws StoreError.
std::string SuiteJson(const std::vector<figures::SceneFigures>& scenes,
                      const std::vector<const results::ResultFile*>& files,
                      const SuiteFacts& facts);

}  // namespace cdb::printers
