// The tables of the standard suite, for a terminal.
#pragma once

#include <string>
#include <vector>

#include "runtime/suite/figures.h"

namespace cdb::suite {

/// A table for each kind: score, memory, and the speedup in each scene; then the reasons why
/// configurations have no score.
std::string ScoreText(const std::vector<KindFigures>& kinds);

/// The configuration to choose for each scene and time budget.
std::string RecommendationText(const std::vector<SceneFigures>& scenes);

/// One or two sentences: the scenes in which Bullet's default is wrong, or in which another of
/// Bullet's own configurations is at least 5 % faster, beyond the interval, and no less accurate.
std::string DefaultsText(const std::vector<SceneFigures>& scenes);

/// The best configuration for a scene, and its advantage:
/// `skin: 1.5 ms a step, 1.9 times as fast as dbvt (95 % interval 1.8 .. 2.0). …`
std::string AnswerText(const SceneFigures& scene);

}  // namespace cdb::suite
