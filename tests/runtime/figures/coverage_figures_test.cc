// The questions that the verdicts of a file leave open, in figures and conclusions.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "dsl/diagnostics.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/model.h"
#include "tests/runtime/figures/made_up_file.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using figures::Cell;

struct Answers {
  std::string open, bad, sleep, checked, conclusion;
};

/// Of a file in which all runs end as `made`.
Answers AnswersOf(const std::string& statements, const MadeUp& made) {
  const compiler::Compilation compiled =
      CompileText("benchmark b { cycles 4; " + statements + " }");
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  return WithMadeUpFile(
      compiled.plans.at(0), [&](const plan::Run&) { return made; },
      [](const results::ResultFile& file) {
        const std::vector<Cell> cells = figures::AllCells(file);
        Answers answers{figures::OpenQuestionsText(file, cells),
                        figures::BadObjectsText(file, cells[0]),
                        figures::SleepNote(file, cells),
                        fmt::format("{}", fmt::join(figures::CheckedQuestions(file, cells), " ")),
                        {}};
        for (const figures::Conclusion& of : figures::Conclusions(figures::Model(file)))
          if (of.kind == "stability") answers.conclusion = of.answer;
        return answers;
      });
}

TEST(OpenQuestions, AreNamedWithTheirReasons) {
  EXPECT_EQ(AnswersOf("objects { quantity 2 }", {}).open, "");
  const Answers driven = AnswersOf("objects { quantity 2; mass kinematic }", {});
  EXPECT_EQ(driven.open, "Not checked: energy, losses (group objects is kinematic).");
  EXPECT_EQ(driven.conclusion,
            "Nothing wrong was found, as far as was checked. Not checked: energy, losses (group "
            "objects is kinematic).");
  // Losses alone have the mildest verdict.
  EXPECT_EQ(AnswersOf("objects { quantity 2; linear_damping 0.1 }", {}).conclusion,
            "Yes: it is stable. Not checked: losses (group objects has damping).");
  EXPECT_EQ(
      AnswersOf("objects { quantity 2; mass kinematic; friction sweep(0, 1) }", {}).conclusion,
      "Nothing wrong was found in any of 2 configurations, as far as was checked. Not checked: "
      "energy, losses (group objects is kinematic).");
  EXPECT_EQ(
      AnswersOf("objects { quantity 2; linear_damping sweep(0, 0.1); rolling_friction 0.5 }", {})
          .open,
      "Not checked: losses (group objects has rolling friction) in 1 of 2 runs; impacts (only the "
      "direction is examined with rolling or spinning friction, as of group objects); losses "
      "(group "
      "objects has damping) in 1 of 2 runs.");
}

TEST(CheckedQuestions, AreThoseThatAllVerdictsAnswer) {
  EXPECT_EQ(AnswersOf("objects { quantity 2 }", {}).checked, "energy losses passing impacts sleep");
  EXPECT_EQ(AnswersOf("objects { quantity 2; linear_damping sweep(0, 0.1) }", {}).checked,
            "energy passing impacts sleep");
  EXPECT_EQ(AnswersOf("objects { quantity 2 } record timing", {}).checked, "");
}

TEST(OpenQuestions, AreAllOfThemWithoutStability) {
  EXPECT_EQ(AnswersOf("objects { quantity 2 } record timing", {}).open,
            "Not checked: energy, losses, passing, impacts, sleep (record lacks stability).");
}

TEST(BadObjects, AreCountedOfThoseThatMove) {
  MadeUp made{.verdict = protocol::Verdict::kTunnelled};
  EXPECT_EQ(AnswersOf("objects { quantity 2000 }", made).bad, "");
  made.bad_objects = 439;
  made.moving_objects = 2000;
  const Answers many = AnswersOf("objects { quantity 2000 }", made);
  EXPECT_EQ(many.bad, "439 of 2000 objects");
  EXPECT_EQ(many.conclusion, "No: the verdict is tunnelled (439 of 2000 objects).");
}

TEST(Sleep, IsSaidFromATenthOfTheObjectsOn) {
  MadeUp made{.moving_objects = 60, .mean_asleep = 5.5};
  EXPECT_EQ(AnswersOf("objects { quantity 60 }", made).sleep, "");
  made.mean_asleep = 51.25;
  EXPECT_EQ(
      AnswersOf("objects { quantity 60 }", made).sleep,
      "51.2 of 60 objects were asleep on average; a step over sleeping objects is less work.");
}

}  // namespace
}  // namespace cdb::tests
