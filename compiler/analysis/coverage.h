// The questions about soundness that the verdict of a run answers for its scene, and those that it
// leaves open. A verdict is no stronger than these: `stable` says that no question that was checked
// had a bad answer.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

enum class Question {
  kEnergy,
  kLosses,
  kRest,
  kPassing,
  kEdges,
  kFriction,
  kImpacts,
  kJoints,
  kSprings,
  kSleep,
  kStretch,
};

/// One row of the table of questions. Pure functions of a scene with at least one object that can
/// move.
struct QuestionInfo {
  Question question;
  std::string_view name;  ///< `losses`
  std::string_view doc;   ///< in one line
  /// A bad answer is worse than `drifting`: while it is open, no run is called sound.
  bool is_vital;
  /// True if the question arises in this scene.
  bool (*arises)(const plan::Scene& scene);
  /// The reason why it is not checked; nullopt if it is.
  std::optional<std::string> (*why_not)(const plan::Scene& scene);
};
std::span<const QuestionInfo> Questions();

/// The questions that arise in a scene, in the order of the table.
struct Coverage {
  struct Open {
    const QuestionInfo* question;
    std::string why;
  };
  std::vector<const QuestionInfo*> checked;
  std::vector<Open> unchecked;
};
/// All questions are open if the scene does not record stability; none arises if nothing can move,
/// or nothing is simulated.
Coverage CoverageOf(const plan::Scene& scene);

/// True if objects of this type may roll on their round side, which Bullet does not support well.
bool MayRoll(const schema::Value& type);

/// True if the question arises in the scene and is checked.
bool IsChecked(Question question, const plan::Scene& scene);

/// True if energy is checked and no contact can store any, as soft ones do: gains are judged.
bool AreGainsJudged(const plan::Scene& scene);

/// `energy, losses, passing`; empty if none is checked.
std::string CheckedText(const Coverage& coverage);
/// `rest: group top is placed by at; losses: group box has damping`; empty if none is open.
std::string UncheckedText(const Coverage& coverage);

}  // namespace cdb::analysis
