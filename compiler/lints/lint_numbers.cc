// The worst number of each lint in a scene.
#include <cmath>
#include <optional>

#include "compiler/lints/lint_facts.h"
#include "compiler/lints/lint_formulae.h"
#include "compiler/lints/lints.h"

namespace cdb::lints {
namespace {

struct Row {
  Lint lint;
  Formula* formula;
};

/// In the order of Lint.
constexpr Row kFormulae[] = {
    {Lint::kTallStack, TallStack},     {Lint::kMassRatio, MassRatio},
    {Lint::kHeavyEnd, HeavyEnd},       {Lint::kNarrowFoot, NarrowFoot},
    {Lint::kOverlap, Overlap},         {Lint::kLongStep, LongStep},
    {Lint::kThinWall, ThinWall},       {Lint::kFastHit, FastHit},
    {Lint::kSoftContact, SoftContact}, {Lint::kStiffSpring, StiffSpring},
    {Lint::kThinShape, ThinShape},     {Lint::kFastSpin, FastSpin},
    {Lint::kSpinDrift, SpinDrift},     {Lint::kHugeBox, HugeBox},
    {Lint::kCoarsePlace, CoarsePlace}, {Lint::kLostMotion, LostMotion},
    {Lint::kLostFall, LostFall},       {Lint::kHeavyMass, HeavyMass},
    {Lint::kEarlySleep, EarlySleep},   {Lint::kShortRun, ShortRun},
};

std::optional<LintNumber> WorstNumber(const Row& row, const SceneFacts& scene) {
  std::optional<LintNumber> worst;
  for (const GroupFacts& objects : scene.groups) {
    if (!objects.moves) continue;
    const auto estimate = row.formula(scene, objects);
    if (!estimate || !(estimate->value > 0)) continue;
    const LintNumber number{row.lint,      estimate->value,  estimate->threshold,
                            objects.index, estimate->remedy, estimate->open};
    if (!worst || number.IsWorseThan(*worst)) worst = number;
  }
  return worst;
}

}  // namespace

double ShorterStep(const SceneFacts& scene, double value, double threshold) {
  return scene.timestep / Excess(value, threshold);
}

double ShorterStepSquared(const SceneFacts& scene, double value, double threshold) {
  return scene.timestep / std::sqrt(Excess(value, threshold));
}

std::vector<LintNumber> LintScene(const plan::Scene& scene) {
  const SceneFacts facts = FactsOf(scene);
  std::vector<LintNumber> numbers;
  for (const Row& row : kFormulae)
    if (const auto worst = WorstNumber(row, facts)) numbers.push_back(*worst);
  return numbers;
}

}  // namespace cdb::lints
