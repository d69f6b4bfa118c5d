// Numbers of a scene that predict whether Bullet can simulate it, before anything runs.
// Source: measured on Bullet 3.24. `cdb doc lints` prints the table, and
// tests/runtime/engine/lints_test.cc compares it with the outcome of runs.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
};

/// One row of THE table of lints.
struct LintInfo {
  Lint lint;
  dsl::DiagnosticKind kind;    ///< its id is the lint's name
  std::string_view number;     ///< the formula, in words
  std::string_view threshold;  ///< from where on it goes wrong
  std::string_view predicts;   ///< a sentence with {} for `will` or `may`
  std::string_view remedy;     ///< what to write, with {} for a number
  std::string_view about;      ///< the parameters it is made of, the first to blame first
};
std::span<const LintInfo> Lints();
const LintInfo& InfoOf(Lint lint);
/// It is the kind of one of the table's rows.
bool IsLint(const dsl::DiagnosticKind& kind);

/// One number of one scene.
struct LintNumber {
  Lint lint;
  double value = 0;
  double threshold = 1;
  std::size_t group = 0;  ///< index into Scene::groups of the objects that it is about
  double remedy = 0;      ///< what fills LintInfo::remedy: with it the number would be harmless
  bool open = false;      ///< beyond the threshold too it goes well as often as not

  double Severity() const { return value / threshold; }
  /// Wrong as a rule from the threshold on, and now and then from a third of it.
  bool IsBad() const { return !open && Severity() >= 1; }
  bool IsDoubtful() const { return Severity() >= kDoubtful; }
  bool IsWorseThan(const LintNumber& other) const {
    return IsBad() != other.IsBad() ? IsBad() : Severity() > other.Severity();
  }
  static constexpr double kDoubtful = 1.0 / 3;
};

/// The worst number of each lint that has something to say about the scene, in the order of the
/// table. By the bounds of what is drawn (compiler/lints/bounds.h); nothing is drawn or placed.
/// Any thread; about two microseconds a group.
std::vector<LintNumber> LintScene(const plan::Scene& scene);

/// `the stack will fall: ... is 0.2, the limit is 0.015`, and what to write instead.
std::string LintMessage(const LintNumber& number);
std::string LintRemedy(const LintNumber& number);

}  // namespace cdb::lints
