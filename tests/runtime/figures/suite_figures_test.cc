// Scores of the standard suite, from results files with made-up times, errors and verdicts.
#include "runtime/figures/suite.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "runtime/printers/suite.h"
#include "tests/runtime/figures/suite_results.h"
#include "tests/support/compile_text.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using figures::SceneFigures;
using figures::StandardScene;

constexpr StandardScene kFirst = {"games", "debris", "debris", "pairs_missed", 0};
constexpr StandardScene kSecond = {"games", "rubble", "rubble", "pairs_missed", 0};

/// The detectors are dbvt, sap32 and skin.
using Made = SuiteRun;
using Make = std::function<Made(std::size_t detector, std::uint64_t rep)>;

plan::Plan MakeSuitePlan() {
  const auto compiled = CompileText(
      "benchmark standard_debris \"A scene\" { cycles 6; repeats 5; timestep 1 / 60\n"
      "  detector sweep(dbvt, sap32, skin); world.side 1000; accuracy { metrics pairs } }\n");
  if (compiled.plans.size() != 1) throw std::runtime_error("the fixture has errors");
  return compiled.plans[0];
}

/// The results of a scene.
class Scene {
 public:
  Scene(const StandardScene& scene, const Make& make) {
    WriteSuiteResults(
        MakeSuitePlan(), "pairs_missed",
        [&](const plan::Run& run, SuiteRun& made) {
          made = make(run.at[0], run.rep);
          // Repeats differ, so that there are intervals.
          made.ns *= 1 + 0.01 * static_cast<double>(run.rep);
        },
        folder_ / "out.h5");
    const results::ResultFile file(folder_ / "out.h5");
    figures = figures::CollectScene(scene, figures::Model(file));
  }
  SceneFigures figures;

 private:
  const TemporaryFolder folder_;
};

/// sap32 takes half of the baseline's time, skin an eighth.
Made Usual(std::size_t detector, std::uint64_t) {
  constexpr double kNs[] = {8e5, 4e5, 1e5};
  return {.ns = kNs[detector]};
}

const figures::KindScore& ScoreOf(const figures::KindFigures& kind, const std::string& name) {
  for (const figures::KindScore& score : kind.scores)
    if (score.name == name) return score;
  throw std::runtime_error("no score of " + name);
}

TEST(SuiteScore, IsTheGeometricMeanOfTheSpeedupsWithAnInterval) {
  const Scene first(kFirst, Usual), second(kSecond, [](std::size_t detector, std::uint64_t) {
    return Made{.ns = detector == 2 ? 4e5 : 8e5};
  });
  const std::vector<SceneFigures> scenes = {first.figures, second.figures};
  const auto kinds = figures::ScoreKinds(scenes);
  ASSERT_EQ(kinds.size(), 1u);
  EXPECT_EQ(kinds[0].baseline, "dbvt");
  EXPECT_EQ(kinds[0].scores[0].name, "skin");
  EXPECT_NEAR(ScoreOf(kinds[0], "skin").score, 4, 1e-9);  // 8 and 2
  EXPECT_NEAR(ScoreOf(kinds[0], "sap32").score, 1.41421356, 1e-8);
  EXPECT_NEAR(ScoreOf(kinds[0], "dbvt").score, 1, 1e-12);
  EXPECT_LE(ScoreOf(kinds[0], "skin").interval.low, 4.0000001);
  EXPECT_GE(ScoreOf(kinds[0], "skin").interval.high, 3.9999999);
  EXPECT_EQ(ScoreOf(kinds[0], "skin").memory_bytes, 5e6);
  EXPECT_EQ(first.figures.configurations[0].repeats, 5u);
  EXPECT_NEAR(first.figures.configurations[0].ms_per_s.value, 0.8 * 60 * 1.02, 1e-6);
}

TEST(SuiteScore, ConfigurationsAreNamedByWhereTheyDifferFromTheBaseline) {
  const auto compiled = CompileText(
      "benchmark standard_debris \"A scene\" { cycles 6; repeats 2; timestep 1 / 60\n"
      "  detector sweep(dbvt, auto); narrow_phase sweep(own, batch)\n"
      "  coordinates sweep(maximal, reduced); skip when narrow_phase == batch and detector == "
      "dbvt\n"
      "  world.side 1000; accuracy { metrics pairs } }\n");
  ASSERT_EQ(compiled.plans.size(), 1u);
  const TemporaryFolder folder;
  WriteSuiteResults(
      compiled.plans[0], "pairs_missed",
      [](const plan::Run& run, SuiteRun& made) { made.ns = run.at[1] == 1 ? 2e5 : 4e5; },
      folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  const SceneFigures scene = figures::CollectScene(kFirst, figures::Model(file));
  std::vector<std::string> names, own;
  for (const figures::ConfigurationFigures& of : scene.configurations) {
    names.push_back(of.name);
    if (of.is_bullets_own) own.push_back(of.name);
    EXPECT_EQ(of.fault, "") << of.name;
  }
  EXPECT_EQ(names, (std::vector<std::string>{"dbvt", "dbvt + reduced", "auto", "auto + reduced",
                                             "auto + batch", "auto + batch + reduced"}));
  EXPECT_EQ(own, (std::vector<std::string>{"dbvt", "dbvt + reduced"}));
  EXPECT_NEAR(scene.Find("auto + batch")->speedup.value, 2, 1e-9);
  EXPECT_EQ(figures::ScoreKinds({scene})[0].baseline, "dbvt");
}

/// The scores if skin is by far the fastest, and has `change` applied in one of two scenes.
figures::KindScore SkinWith(const std::function<void(std::uint64_t, Made&)>& change) {
  static const Scene first(kFirst, Usual);
  const Scene second(kSecond, [&](std::size_t detector, std::uint64_t rep) {
    Made made = Usual(detector, rep);
    if (detector == 2) change(rep, made);
    return made;
  });
  const std::vector<SceneFigures> scenes = {first.figures, second.figures};
  const auto kinds = figures::ScoreKinds(scenes);
  EXPECT_NEAR(ScoreOf(kinds[0], "sap32").score, 2, 1e-9);
  EXPECT_EQ(kinds[0].scores.back().name, "skin");  // not first, although it is the fastest
  const std::string text = printers::ScoreText(kinds);
  EXPECT_NE(text.find("No score: skin: rubble: "), std::string::npos) << text;
  return ScoreOf(kinds[0], "skin");
}

TEST(SuiteScore, NothingThatIsWrongInOneSceneHasAScore) {
  const auto fault = [](const std::function<void(std::uint64_t, Made&)>& change) {
    const figures::KindScore skin = SkinWith(change);
    EXPECT_TRUE(std::isnan(skin.score));
    EXPECT_TRUE(std::isnan(skin.interval.low));
    EXPECT_EQ(skin.faults.size(), 1u);
    return skin.faults.empty() ? "" : skin.faults[0];
  };
  EXPECT_EQ(fault([](std::uint64_t, Made& made) { made.error = 1e-6; }),
            "rubble: pairs_missed 1.00e-06");
  // One repeat is enough: the others do not make up for it.
  EXPECT_EQ(fault([](std::uint64_t rep, Made& made) {
              if (rep == 4) made.verdict = protocol::Verdict::kTunnelled;
            }),
            "rubble: tunnelled from cycle 3");
  EXPECT_EQ(fault([](std::uint64_t rep, Made& made) {
              if (rep == 2) made.status = results::Status::kCrashed;
            }),
            "rubble: crashed");
  EXPECT_EQ(fault([](std::uint64_t, Made& made) { made.verdict = protocol::Verdict::kFrozen; }),
            "rubble: frozen from cycle 3");
  EXPECT_EQ(fault([](std::uint64_t, Made& made) { made.error = NAN; }),
            "rubble: its error (pairs_missed) is not known");
  EXPECT_EQ(fault([](std::uint64_t, Made& made) { made.omitted = "solver"; }),
            "rubble: ran without solver, which others kept");
  EXPECT_EQ(fault([](std::uint64_t rep, Made& made) {
              if (rep < 3) made.noise = machine::Noise::kNoisy;
            }),
            "rubble: noisy in 3 of 5 runs");
}

TEST(SuiteScore, AKindWithoutOneOfItsScenesHasNone) {
  const Scene scene(kFirst, Usual);
  const std::vector<SceneFigures> scenes = {scene.figures};
  const auto kinds = figures::ScoreKinds(scenes);
  for (const figures::KindScore& score : kinds[0].scores) {
    EXPECT_TRUE(std::isnan(score.score));
    EXPECT_EQ(score.faults, std::vector<std::string>{"rubble: not run"});
  }
  const std::string text = printers::ScoreText(kinds);
  EXPECT_NE(text.find("8.00"), std::string::npos) << text;  // the ratio in the scene
}

TEST(SuiteScore, FewNoisyRepeatsAreOutvoted) {
  const Scene scene(kFirst, [](std::size_t detector, std::uint64_t rep) {
    Made made = Usual(detector, rep);
    if (rep < 2) made.noise = machine::Noise::kNoisy;
    return made;
  });
  for (const auto& of : scene.figures.configurations) {
    EXPECT_TRUE(of.HasScore()) << of.fault;
    EXPECT_EQ(of.noisy, 2u);
  }
}

TEST(SuiteScore, ADisturbedBaselineDisturbsAllAndAWrongOneStaysTheMeasure) {
  const auto with_baseline = [](const Made& baseline) {
    return [baseline](std::size_t detector, std::uint64_t rep) {
      return detector == 0 ? baseline : Usual(detector, rep);
    };
  };
  const Scene noisy(kFirst, with_baseline({.ns = 8e5, .noise = machine::Noise::kNoisy}));
  EXPECT_EQ(noisy.figures.Find("skin")->fault, "the baseline dbvt is noisy");
  EXPECT_TRUE(noisy.figures.Find("skin")->is_disturbed);
  const std::vector<SceneFigures> scenes = {noisy.figures};
  const std::string text = printers::ScoreText(figures::ScoreKinds(scenes));
  EXPECT_NE(text.find("(8.00)"), std::string::npos) << text;
  EXPECT_NE(text.find("none"), std::string::npos) << text;

  const Scene drifting(kFirst, with_baseline({.ns = 8e5, .verdict = protocol::Verdict::kDrifting}));
  EXPECT_EQ(drifting.figures.Find("dbvt")->fault, "drifting from cycle 3");
  EXPECT_TRUE(drifting.figures.Find("skin")->HasScore());
  EXPECT_NEAR(drifting.figures.Find("skin")->speedup.value, 8, 1e-9);

  const Scene frozen(kFirst, with_baseline({.ns = 8e5, .verdict = protocol::Verdict::kFrozen}));
  EXPECT_EQ(frozen.figures.Find("skin")->fault, "the baseline dbvt has no valid time");
}

TEST(SuiteScore, VerdictsThatAViewerAcceptsAreAllowedByTheScene) {
  StandardScene allowing = kFirst;
  allowing.worst_verdict = protocol::Verdict::kPenetrating;
  const Make make = [](std::size_t detector, std::uint64_t rep) {
    Made made = Usual(detector, rep);
    made.verdict = detector == 2 ? protocol::Verdict::kCollapsed : protocol::Verdict::kPenetrating;
    return made;
  };
  const Scene scene(allowing, make);
  EXPECT_TRUE(scene.figures.Find("sap32")->HasScore());
  EXPECT_FALSE(scene.figures.Find("skin")->HasScore());
}

TEST(SuiteRecommendation, SaysWhereBulletsDefaultIsNotTheBestOfItsOwn) {
  const Scene faster(kFirst, Usual), slower(kSecond, [](std::size_t detector, std::uint64_t) {
    return Made{.ns = detector == 0 ? 1e5 : 8e5};
  });
  const auto text = [](const Scene& scene) { return printers::DefaultsText({scene.figures}); };
  // skin is not one of Bullet's detectors.
  EXPECT_EQ(text(faster),
            "Another of Bullet's configurations is at least 5 % faster than its default in 1 of 1 "
            "scenes (95 % interval above 1): games/debris (sap32 2.00).");
  const Scene hardly(kFirst, [](std::size_t detector, std::uint64_t) {
    return Made{.ns = detector == 1 ? 0.96e6 : 1e6};
  });
  EXPECT_TRUE(text(hardly).starts_with("In none of 1 scenes")) << text(hardly);
  EXPECT_TRUE(text(slower).starts_with("In none of 1 scenes")) << text(slower);
  const Scene wrong(kFirst, [](std::size_t detector, std::uint64_t rep) {
    Made made = Usual(detector, rep);
    if (detector == 0) made.error = 1;
    return made;
  });
  EXPECT_NE(text(wrong).find("It is wrong in games/debris (pairs_missed 1.00)"), std::string::npos)
      << text(wrong);
  EXPECT_TRUE(faster.figures.IsOnFront(*faster.figures.Find("skin")));
  EXPECT_FALSE(faster.figures.IsOnFront(*faster.figures.Find("sap32")));
}

TEST(SuiteRecommendation, IsTheMostAccurateThatFitsAndThenTheFastest) {
  StandardScene loose = kFirst;
  loose.bound = 1;
  constexpr double kNs[] = {2e7, 5e5, 1e5};
  const Scene scene(loose, [&](std::size_t detector, std::uint64_t) {
    return Made{.ns = kNs[detector], .error = detector == 0 ? 0 : 0.5};
  });
  const auto pick = [&](double period_s, bool only_own) {
    std::string names;
    for (const auto* of : figures::Recommend(scene.figures, period_s, only_own)) names += of->name;
    return names;
  };
  EXPECT_EQ(pick(INFINITY, false), "dbvt");
  // Two steps of 20 ms do not fit.
  EXPECT_EQ(pick(1.0 / 30, false), "skin");
  EXPECT_EQ(pick(1.0 / 30, true), "sap32");
  EXPECT_EQ(pick(2e-4, true), "");
  // Times that are indistinguishable.
  const Scene alike(kFirst, [](std::size_t detector, std::uint64_t rep) {
    return Made{.ns = detector == 0 ? 2e6 : detector == 1 && rep % 2 == 0 ? 0.99e6 : 1e6};
  });
  EXPECT_EQ(figures::Recommend(alike.figures, 1, false).size(), 2u);
  const std::string answer = printers::AnswerText(alike.figures);
  EXPECT_NE(answer.find("ties with it."), std::string::npos) << answer;
  const std::string table = printers::RecommendationText({alike.figures});
  EXPECT_NE(table.find("any but dbvt  sap32 "), std::string::npos) << table;
}

}  // namespace
}  // namespace cdb::tests
