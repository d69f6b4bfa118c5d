// Results of the suite verified by those of another machine, both made up.
#include "runtime/figures/suite.h"

#include <gtest/gtest.h>

#include <string>

#include "runtime/printers/suite.h"
#include "tests/runtime/figures/suite_results.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using figures::SceneVerification;
using SceneOutcome = SceneVerification::Outcome;

const figures::StandardScene kRain = {"games", "rain", "a made-up rain", "position", 0.5};

/// grid takes half the time of dbvt, with 1 % of noise between repeats.
void Claimed(const plan::Run& run, SuiteRun& made) {
  made.ns = (run.at[0] == 0 ? 2000 : 1000) * (1 + 0.01 * static_cast<double>(run.rep % 3));
}

SceneVerification Verify(const SuiteChange& change, const std::string& cpu = "a µ-processor",
                         const plan::Plan& plan = SuitePlan({"dbvt", "grid"})) {
  const TemporaryFolder folder;
  WriteSuiteResults(SuitePlan({"dbvt", "grid"}), "position", Claimed, folder / "claimed.h5");
  results::Provenance provenance = kSuiteProvenance;
  provenance["cpu"] = cpu;
  WriteSuiteResults(
      plan, "position",
      [&](const plan::Run& run, SuiteRun& made) {
        Claimed(run, made);
        change(run, made);
      },
      folder / "here.h5", provenance);
  const figures::ComparedFile claimed(folder / "claimed.h5", "claimed"),
      here(folder / "here.h5", "here");
  const figures::SceneFigures claimed_figures = figures::CollectScene(kRain, claimed.model),
                              figures = figures::CollectScene(kRain, here.model);
  return figures::VerifyScene({claimed, claimed_figures}, {here, figures});
}

/// A change of the runs of grid.
SuiteChange Grid(const std::function<void(SuiteRun&)>& change) {
  return [=](const plan::Run& run, SuiteRun& made) {
    if (run.at[0] == 1) change(made);
  };
}

void ExpectDisagrees(const SceneVerification& of, const std::string& part) {
  EXPECT_EQ(of.outcome, SceneOutcome::kDisagrees);
  ASSERT_EQ(of.disagreements.size(), 1) << part;
  EXPECT_NE(of.disagreements[0].find(part), std::string::npos) << of.disagreements[0];
  EXPECT_NE(printers::VerificationText({of}).find("DISAGREES"), std::string::npos);
}

TEST(SuiteAgainst, SameStatesVerify) {
  const SceneVerification of = Verify([](const plan::Run&, SuiteRun&) {});
  EXPECT_EQ(of.outcome, SceneOutcome::kSameStates);
  EXPECT_TRUE(of.disagreements.empty());
}

TEST(SuiteAgainst, OtherStatesAgreeIfErrorsAndSpeedupsDo) {
  const SceneVerification of = Verify([](const plan::Run&, SuiteRun& made) {
    made.state = "fedcba9876543210";
    made.ns *= 3;  // another machine
  });
  EXPECT_EQ(of.outcome, SceneOutcome::kAgrees);
  EXPECT_TRUE(of.disagreements.empty());
}

TEST(SuiteAgainst, AScoreOfWhatIsWrongHereDisagrees) {
  ExpectDisagrees(Verify(Grid([](SuiteRun& made) { made.error = 0.7; })),
                  "grid: has a score, but here it is wrong: position error 0.700 over 0.5");
  ExpectDisagrees(
      Verify(Grid([](SuiteRun& made) { made.verdict = protocol::Verdict::kTunnelled; })),
      "grid: has a score, but here it is wrong: tunnelled from cycle 3");
}

TEST(SuiteAgainst, ALargerErrorBelowTheBoundDisagrees) {
  ExpectDisagrees(Verify(Grid([](SuiteRun& made) { made.error = 0.3; })),
                  "grid: position error 0, here 0.300");
  EXPECT_EQ(Verify(Grid([](SuiteRun& made) { made.error = 0.01; })).outcome,
            SceneOutcome::kSameStates);
}

TEST(SuiteAgainst, SpeedupsMayDifferMoreOnAnotherProcessor) {
  const SuiteChange slower = Grid([](SuiteRun& made) { made.ns *= 1.3; });
  ExpectDisagrees(Verify(slower), "grid: speedup 2.00 (");
  EXPECT_EQ(Verify(slower, "another processor").outcome, SceneOutcome::kSameStates);
  ExpectDisagrees(Verify(Grid([](SuiteRun& made) { made.ns *= 2; }), "another processor"),
                  "grid: speedup 2.00 (");
}

TEST(SuiteAgainst, NoiseHereDoesNotAccuse) {
  const SceneVerification of =
      Verify(Grid([](SuiteRun& made) { made.noise = machine::Noise::kNoisy; }));
  EXPECT_EQ(of.outcome, SceneOutcome::kSameStates);
  EXPECT_EQ(of.claimed, 2u);
  EXPECT_EQ(of.timed, 1u);
}

TEST(SuiteAgainst, RepeatsThatEndInDifferentStatesDisagree) {
  const SceneVerification of = Verify([](const plan::Run& run, SuiteRun& made) {
    if (run.rep == 2) made.state = "fedcba9876543210";
  });
  EXPECT_EQ(of.outcome, SceneOutcome::kDisagrees);
}

TEST(SuiteAgainst, ComparesFiguresAloneWhereThePlansDiffer) {
  const SceneVerification of = Verify([](const plan::Run&, SuiteRun&) {}, "a µ-processor",
                                      SuitePlan({"dbvt", "grid", "auto"}));
  EXPECT_EQ(of.outcome, SceneOutcome::kAgrees);
  EXPECT_EQ(of.states, "other seeds or detectors");
}

}  // namespace
}  // namespace cdb::tests
