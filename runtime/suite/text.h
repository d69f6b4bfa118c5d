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

/// `skin takes 1.5 ms a step, 1.9 times as fast as dbvt (95 % interval 1.8 .. 2.0). …`: the answer
/// to which configuration a scene is best served by.
std::string AnswerText(const SceneFigures& scene);

}  // namespace cdb::suite
