// The tables of the standard suite for a terminal.
#pragma once

#include <string>
#include <vector>

#include "runtime/suite/figures.h"

namespace cdb::suite {

/// A table for each kind: score, memory, and the speedup in each scene; then why configurations
/// have no score.
std::string ScoreText(const std::vector<KindFigures>& kinds);

/// For each scene and budget the configuration to take.
std::string RecommendationText(const std::vector<SceneFigures>& scenes);

/// In which scenes Bullet's default is wrong, or another choice that Bullet comes with is faster
/// and no less accurate, beyond the interval; a sentence or two.
std::string DefaultsText(const std::vector<SceneFigures>& scenes);

/// Which configuration serves a scene best, and by how much:
/// `skin: 1.5 ms a step, 1.9 times as fast as dbvt (95 % interval 1.8 .. 2.0). …`
std::string AnswerText(const SceneFigures& scene);

}  // namespace cdb::suite
