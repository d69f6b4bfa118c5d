#include "runtime/figures/requirements.h"
#include "runtime/figures/searches/searches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "runtime/printers/show.h"
#include "runtime/results/hdf5/file.h"
#include "tests/runtime/figures/made_up_file.h"

namespace cdb::tests {
namespace {

using figures::Answer;
using figures::CycleStatistic;
using plan::Comparison;

constexpr double kNone = figures::kNone;

plan::Requirement Of(const std::string& figure, Comparison comparison, double limit) {
  return {figure + std::string(" ") + std::string(plan::ComparisonText(comparison)) + " " +
              std::to_string(static_cast<int>(limit)),
          *plan::FindFigure(figure), comparison, limit};
}

TEST(Requirements, AreMetByTheWholeIntervalOnly) {
  const struct {
    double low, high;
    Comparison comparison;
    Answer answer;
  } cases[] = {
      {1, 2, Comparison::kLess, Answer::kMet},
      {1, 3, Comparison::kLess, Answer::kCannotTell},
      {3, 4, Comparison::kLess, Answer::kNotMet},
      {1, 3, Comparison::kAtMost, Answer::kMet},
      {3, 4, Comparison::kAtMost, Answer::kCannotTell},
      {4, 5, Comparison::kAtMost, Answer::kNotMet},
      {4, 5, Comparison::kGreater, Answer::kMet},
      {3, 5, Comparison::kGreater, Answer::kCannotTell},
      {1, 2, Comparison::kGreater, Answer::kNotMet},
      {3, 5, Comparison::kAtLeast, Answer::kMet},
      {3, 3, Comparison::kEqual, Answer::kMet},
      {2, 4, Comparison::kEqual, Answer::kCannotTell},
      {4, 5, Comparison::kEqual, Answer::kNotMet},
      {3, 3, Comparison::kNotEqual, Answer::kNotMet},
      {2, 4, Comparison::kNotEqual, Answer::kCannotTell},
      {1, 2, Comparison::kNotEqual, Answer::kMet},
      {kNone, kNone, Comparison::kLess, Answer::kCannotTell},
  };
  for (const auto& one : cases)
    EXPECT_EQ(figures::JudgeRange({one.low, one.high}, one.comparison, 3), one.answer)
        << one.low << " .. " << one.high << plan::ComparisonText(one.comparison);
}

TEST(Requirements, AreNotMissedByNoiseAlone) {
  EXPECT_EQ(figures::JudgeTime({4, 5}, 2.0, Comparison::kLess, 3), Answer::kCannotTell);
  EXPECT_EQ(figures::JudgeTime({4, 5}, 3.5, Comparison::kLess, 3), Answer::kNotMet);
  EXPECT_EQ(figures::JudgeTime({1, 2}, 0.5, Comparison::kLess, 3), Answer::kMet);
}

/// The fraction of made-up sweeps in which a statistic of the times is found to be below, and
/// above, `limit` times its true value: repeats and cycles differ by 2 % each.
struct Rates {
  double met = 0, not_met = 0;
};
Rates RatesAt(double limit, CycleStatistic statistic, std::size_t repeats) {
  constexpr int kSweeps = 300;
  constexpr std::size_t kCycles = 40;
  std::vector<double> truth;
  for (std::size_t c = 0; c < kCycles; ++c)
    truth.push_back(1000 + 500 * std::sin(static_cast<double>(c)));
  const double value = figures::StatisticOf(truth, statistic);
  const figures::Bootstrap bootstrap(repeats);
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0, 0.02);
  Rates rates;
  for (int i = 0; i < kSweeps; ++i) {
    std::vector<std::vector<double>> times;
    for (std::size_t r = 0; r < repeats; ++r) {
      const double speed = 1 + noise(random);
      times.emplace_back();
      for (const double time : truth) times.back().push_back(time * speed * (1 + noise(random)));
    }
    const figures::PhaseTimes found = figures::TimesOver(times, bootstrap, statistic);
    const figures::Estimate& estimate =
        statistic == CycleStatistic::kMean ? found.mean : found.other;
    switch (
        figures::JudgeTime(bootstrap.IntervalOf(estimate), {}, Comparison::kLess, limit * value)) {
      case Answer::kMet:
        rates.met += 1.0 / kSweeps;
        break;
      case Answer::kNotMet:
        rates.not_met += 1.0 / kSweeps;
        break;
      default:
        break;
    }
  }
  return rates;
}

TEST(Requirements, AtTheLimitAreRarelyJudged) {
  for (const std::size_t repeats : {5u, 9u}) {
    const Rates mean = RatesAt(1, CycleStatistic::kMean, repeats);
    EXPECT_LE(mean.met, 0.05) << repeats;
    EXPECT_LE(mean.not_met, 0.05) << repeats;
    // The highest of many noisy times is too high rather than too low.
    EXPECT_LE(RatesAt(1, CycleStatistic::kP99, repeats).met, 0.05) << repeats;
  }
  EXPECT_GE(RatesAt(1.1, CycleStatistic::kMean, 5).met, 0.9);
  EXPECT_GE(RatesAt(0.9, CycleStatistic::kMean, 5).not_met, 0.9);
  EXPECT_GE(RatesAt(1.2, CycleStatistic::kP99, 5).met, 0.9);
}

/// Three scenes that take 1, 2 and 4 us.
plan::Plan ScenesOf(std::size_t repeats, std::vector<plan::Requirement> requirements) {
  plan::Plan plan = MakePlan({NumberAxis("quantity", {10, 20, 40})}, repeats,
                             {.cycles = kMadeUpCycles, .record = {"timing"}});
  plan.requirements = std::move(requirements);
  return plan;
}
MadeUp OfScene(const plan::Run& run) {
  return {.ns = 1000.0 * static_cast<double>(1 << run.at[0])};
}

using AnswerList = std::vector<Answer>;

AnswerList AnswersOf(const plan::Plan& plan, const MakeUp& make_up,
                     std::vector<std::string>* why = nullptr) {
  return WithMadeUpFile(plan, make_up, [&](const results::ResultFile& file) {
    const figures::Model model(file);
    AnswerList answers;
    for (const figures::JudgedRequirement& of : model.requirements())
      for (const figures::JudgedPoint& point : of.points) {
        answers.push_back(point.answer);
        if (why != nullptr) why->push_back(figures::ReasonText(of, point, "95 % interval"));
      }
    return answers;
  });
}

TEST(Requirements, AreJudgedAtEachPoint) {
  const auto step = Of("p99(step)", Comparison::kLess, 3000);
  EXPECT_EQ(AnswersOf(ScenesOf(5, {step}), OfScene),
            (AnswerList{Answer::kMet, Answer::kMet, Answer::kNotMet}));
  std::vector<std::string> why;
  EXPECT_EQ(AnswersOf(ScenesOf(1, {step}), OfScene, &why), AnswerList(3, Answer::kCannotTell));
  EXPECT_EQ(why[0], "1.00 us: one repeat does not tell");
  why.clear();
  EXPECT_EQ(AnswersOf(ScenesOf(4, {step}), OfScene, &why), AnswerList(3, Answer::kCannotTell));
  EXPECT_EQ(why[0], "1.00 us: 4 repeats do not tell");
  // A repeat that is missing takes the interval with it.
  EXPECT_EQ(AnswersOf(ScenesOf(5, {step}),
                      [](const plan::Run& run) {
                        MadeUp made = OfScene(run);
                        if (run.at[0] == 0 && run.rep == 4) made.status = results::Status::kMissing;
                        return made;
                      }),
            (AnswerList{Answer::kCannotTell, Answer::kMet, Answer::kNotMet}));
}

TEST(Requirements, OnTimesOfVoidRunsCannotBeTold) {
  const auto with = [](protocol::Verdict verdict) {
    return [=](const plan::Run& run) {
      MadeUp made = OfScene(run);
      if (run.at[0] == 0) made.verdict = verdict;
      return made;
    };
  };
  const auto plan =
      ScenesOf(5, {Of("mean(step)", Comparison::kLess, 3000), Of("verdict", Comparison::kEqual, 1),
                   Of("verdict", Comparison::kAtMost, 6)});
  using enum Answer;
  EXPECT_EQ(AnswersOf(plan, with(protocol::Verdict::kFrozen)),
            (AnswerList{kCannotTell, kMet, kNotMet, kNotMet, kMet, kMet, kNotMet, kMet, kMet}));
  EXPECT_EQ(AnswersOf(plan, with(protocol::Verdict::kTunnelled)),
            (AnswerList{kMet, kMet, kNotMet, kNotMet, kMet, kMet, kMet, kMet, kMet}));
  EXPECT_EQ(AnswersOf(plan, with(protocol::Verdict::kUnknown))[3], kCannotTell);
}

TEST(Requirements, OfFactsHoldInEveryRepeat) {
  const auto plan = ScenesOf(5, {Of("peak_rss", Comparison::kLess, 6'000'000)});
  std::vector<std::string> why;
  const auto one_large = [](const plan::Run& run) {
    MadeUp made = OfScene(run);
    if (run.at[0] == 1 && run.rep == 3) made.peak_rss = 7e6;
    return made;
  };
  EXPECT_EQ(AnswersOf(plan, one_large, &why),
            (AnswerList{Answer::kMet, Answer::kNotMet, Answer::kMet}));
  EXPECT_EQ(why[1], "7.00 MB (repeats 5.00 .. 7.00)");
}

TEST(Requirements, OfErrorsKnowTheFloor) {
  plan::Plan plan =
      MakePlan({}, 1, {.cycles = kMadeUpCycles, .record = {"timing"}, .metrics = {"position"}});
  plan.requirements = {Of("error(position)", Comparison::kLess, 1)};
  const auto with = [](double error, double floor) {
    return [=](const plan::Run&) {
      return MadeUp{.errors = {{"position", error}, {"position_floor", floor}}};
    };
  };
  EXPECT_EQ(AnswersOf(plan, with(0.5, 0.1)), AnswerList{Answer::kMet});
  EXPECT_EQ(AnswersOf(plan, with(0.5, 0.6)), AnswerList{Answer::kCannotTell});
  EXPECT_EQ(AnswersOf(plan, with(1.5, 0.1)), AnswerList{Answer::kNotMet});
  EXPECT_EQ(AnswersOf(plan, with(NAN, 0.1)), AnswerList{Answer::kCannotTell});
}

TEST(Requirements, HoldTheBudget) {
  plan::Plan plan = ScenesOf(5, {});
  plan.budget_s = 3e-6;
  EXPECT_EQ(AnswersOf(plan, OfScene), (AnswerList{Answer::kMet, Answer::kMet, Answer::kNotMet}));
  const std::string text = WithMadeUpFile(plan, OfScene, [](const results::ResultFile& file) {
    const printers::Printed shown = printers::Show(file, {.is_brief = true});
    EXPECT_EQ(shown.not_met_count, 1u);
    return shown.text;
  });
  EXPECT_EQ(text.find("Requirements"), std::string::npos) << text;  // it has a table of its own
}

TEST(Requirements, AreShownWithTheFirstPointsThatFail) {
  const auto plan = ScenesOf(5, {Of("p99(step)", Comparison::kLess, 3000)});
  const std::string text = WithMadeUpFile(plan, OfScene, [](const results::ResultFile& file) {
    return printers::Show(file, {.is_brief = true}).text;
  });
  EXPECT_NE(text.find("p99(step) < 3000: not met at 1 of 3 points. Along the number of "
                      "objects: met up to 20, not met from 40."),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("quantity 40: 4.00 us"), std::string::npos) << text;
  const std::string junit = WithMadeUpFile(plan, OfScene, [](const results::ResultFile& file) {
    return printers::JunitText(file).text;
  });
  EXPECT_NE(junit.find("tests=\"3\" failures=\"1\" skipped=\"0\""), std::string::npos) << junit;
  EXPECT_NE(
      junit.find("p99(step) &lt; 3000\" name=\"quantity 40\">\n      <failure message=\"4.00 us"),
      std::string::npos)
      << junit;
}

TEST(Requirements, AreStoredWithTheirAnswers) {
  const auto plan =
      ScenesOf(5, {Of("p99(step)", Comparison::kLess, 3000), Of("verdict", Comparison::kEqual, 1)});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs) WriteMadeUp(plan, run, OfScene(run), folder.path());
  journal::Merge(plan, {{"build_type", "Release"}}, {folder.path()}, folder / "out.h5", {},
                 searches::AnswersToStore);
  EXPECT_EQ(results::ResultFile(folder / "out.h5").requirements(), plan.requirements);
  const hdf5::File file = hdf5::File::Open(folder / "out.h5");
  const auto read = [&](const char* name) {
    return file.OpenDataset(std::string("requirements/") + name).Read();
  };
  EXPECT_EQ(read("answer"), (std::vector<double>{3, 3, 3, 3, 2, 3}));
  EXPECT_EQ(read("value"), (std::vector<double>{1000, 1, 2000, 1, 4000, 1}));
  EXPECT_EQ(read("limit"), (std::vector<double>{3000, 1}));
  // Without a judge, nothing is claimed.
  journal::Merge(plan, {}, folder.path(), folder / "none.h5");
  EXPECT_EQ(hdf5::File::Open(folder / "none.h5").OpenDataset("requirements/answer").Read(),
            std::vector<double>(6, 0));
}

}  // namespace
}  // namespace cdb::tests
