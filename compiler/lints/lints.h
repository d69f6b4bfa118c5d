// Numbers of a scene that predict, before a run, whether Bullet can simulate it accurately.
// Source: measured on Bullet 3.24. `cdb doc lints` prints the table, and
// tests/runtime/engine/lints_test.cc compares it with the outcome of runs.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/model.h"
#include "compiler/analysis/trace.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"

namespace cdb::lints {

/// In the order of the table.
enum class Lint {
  kTallStack,
  kMassRatio,
  kHeavyEnd,
  kNarrowFoot,
  kOverlap,
  kLongStep,
  kThinWall,
  kFastHit,
  kSoftContact,
  kStiffSpring,
  kThinShape,
  kFastSpin,
  kSpinDrift,
  kHugeBox,
  kCoarsePlace,
  kLostMotion,
  kLostFall,
  kHeavyMass,
  kEarlySleep,
  kShortRun,
  kInternalEdges,
  kForeseenBounce,
  kLossyBounce,
  kLongChain,
  kSwingingJoint,
  kCrush,
  kCreep,
  kRollingGain,
  kLeaningStack,
  kSlidingBox,
  kTumblingTree,
};

/// One row of THE table of lints.
struct LintInfo {
  Lint lint;
  dsl::DiagnosticKind kind;    ///< its id is the name of the lint
  std::string_view number;     ///< the formula, in words
  std::string_view threshold;  ///< the value at which problems begin
  std::string_view predicts;   ///< a sentence with {} for `will` or `may`
  std::string_view remedy;     ///< the change to make, with {} for a number
  std::string_view about;      ///< the parameters it depends on, the most likely cause first
};
std::span<const LintInfo> Lints();
const LintInfo& InfoOf(Lint lint);
/// True if it is the kind of a row of the table.
bool IsLint(const dsl::DiagnosticKind& kind);

/// One number of one scene.
struct LintNumber {
  Lint lint;
  double value = 0;
  double threshold = 1;
  std::size_t group = 0;  ///< index into Scene::groups of the objects concerned
  double remedy = 0;      ///< the number in LintInfo::remedy: with it the value would be harmless
  bool open = false;      ///< about half of such runs succeed even beyond the threshold

  double Severity() const { return value / threshold; }
  /// Beyond the threshold, runs usually go wrong; from a third of it, occasionally.
  bool IsBad() const { return !open && Severity() >= 1; }
  bool IsDoubtful() const { return Severity() >= kDoubtful; }
  bool IsWorseThan(const LintNumber& other) const {
    return IsBad() != other.IsBad() ? IsBad() : Severity() > other.Severity();
  }
  static constexpr double kDoubtful = 1.0 / 3;
};

/// Reads facts from files; those that are empty leave the facts unknown.
struct FactReaders {
  analysis::ReadPoses poses = {};  ///< of paths
  analysis::ReadModel model = {};  ///< sides of meshes
};

/// The worst number of each lint that applies to the scene, in the order of the table. From the
/// bounds of drawn values (compiler/lints/lint_facts.h); nothing is drawn or placed. Any
/// thread that may call `read`; some microseconds per group.
std::vector<LintNumber> LintScene(const plan::Scene& scene, const FactReaders& read = {});

/// `the stack will slide or fall: 0.2 is above the limit of 0.025 for ...`, and the remedy.
std::string LintMessage(const LintNumber& number);
std::string LintRemedy(const LintNumber& number);

}  // namespace cdb::lints
