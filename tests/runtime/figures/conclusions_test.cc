// Conclusions from files whose times, errors and verdicts follow a formula.
#include "runtime/figures/conclusions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "compiler/evaluate/samples.h"
#include "runtime/figures/errors.h"
#include "runtime/figures/model.h"
#include "runtime/figures/requirements.h"
#include "tests/runtime/figures/made_up_file.h"

namespace cdb::tests {
namespace {

using figures::Certainty;
using figures::Conclusion;

std::vector<Conclusion> ConclusionsOf(const plan::Plan& plan, const MakeUp& make_up) {
  return WithMadeUpFile(plan, make_up, [](const results::ResultFile& file) {
    return figures::Conclusions(figures::Model(file));
  });
}

/// The first conclusion of a kind, or an empty one.
Conclusion FindConclusion(const std::vector<Conclusion>& all, std::string_view kind) {
  for (const Conclusion& of : all)
    if (of.kind == kind) return of;
  return {"", "", kind, Certainty::kUnknown};
}

plan::Plan DetectorPlan(std::uint64_t repeats) {
  return MakePlan(
      {TextAxis("detector", {"simple", "dbvt", "sap"}), NumberAxis("quantity", {10, 20, 40})},
      repeats, {.cycles = kMadeUpCycles, .record = {"timing"}});
}

/// 100 ns per object, times a factor for the detector, plus 1 % in each repeat.
MadeUp FactorTimes(const plan::Run& run, const std::vector<double>& factors) {
  constexpr double kObjects[] = {10, 20, 40};
  return {.ns = 100 * kObjects[run.at[1]] * factors[run.at[0]] *
                (1 + 0.01 * static_cast<double>(run.rep))};
}

TEST(Conclusions, NameTheFastestDetectorWithItsInterval) {
  const auto all = ConclusionsOf(DetectorPlan(5), [](const plan::Run& run) {
    return FactorTimes(run, {2, 1, 1.2});
  });
  const Conclusion step = FindConclusion(all, "fastest");
  EXPECT_EQ(step.question, "Which detector takes the least time for a step?");
  // The repeats of all detectors are slowed equally, so that the ratios are known.
  EXPECT_EQ(step.answer,
            "dbvt. Next is sap, with 1.20 times the time of dbvt (95 % interval 1.20 .. 1.20). "
            "Last is simple, with 2.00 times the time of dbvt (95 % interval 2.00 .. 2.00). These "
            "are geometric means over 3 cells. The broad phase is 100 % of a step.");
  EXPECT_EQ(step.certainty, Certainty::kClear);
}

TEST(Conclusions, SayThatAPlugInWasNotChecked) {
  plan::Plan plan = DetectorPlan(5);
  plan.axes[0].values[1] = "mine";
  const auto all = ConclusionsOf(plan, [](const plan::Run& run) {
    return FactorTimes(run, {2, 1, 1.2});
  });
  const std::string answer = FindConclusion(all, "fastest").answer;
  EXPECT_TRUE(answer.starts_with("mine. Next is sap")) << answer;
  EXPECT_TRUE(
      answer.ends_with("The pairs of mine, a plug-in, were not compared with exact ones: "
                       "`record pairs` says whether it misses any."))
      << answer;
}

TEST(Conclusions, BeginWithWhatTheSweepAsks) {
  const auto kinds = [](const plan::Plan& plan) {
    std::string text;
    for (const Conclusion& of : ConclusionsOf(plan, [](const plan::Run& run) {
           return FactorTimes(run, {2, 1, 1.2});
         }))
      text += std::string(of.kind) + " ";
    return text;
  };
  EXPECT_EQ(kinds(DetectorPlan(5)), "fastest detect broad stability scaling worst_cycle ");
  plan::Plan with_errors =
      MakePlan({TextAxis("detector", {"simple", "dbvt", "sap"}), NumberAxis("quantity", {10, 20})},
               5, {.cycles = kMadeUpCycles, .record = {"timing"}, .metrics = {"position"}});
  EXPECT_TRUE(kinds(with_errors).starts_with("error error fastest detect "));
}

/// The answer on a budget of 5 us, of detectors that take 1 us, 2 us and 1 ms per 10 objects.
Conclusion BudgetConclusion(const std::function<void(const plan::Run&, MadeUp&)>& change) {
  plan::Plan plan = DetectorPlan(5);
  plan.budget_s = 5e-6;
  return ConclusionsOf(plan,
                       [&](const plan::Run& run) {
                         MadeUp made = FactorTimes(run, {1, 2, 1000});
                         change(run, made);
                         return made;
                       })
      .front();
}

TEST(Conclusions, BeginWithTheBudget) {
  const Conclusion budget = BudgetConclusion([](const plan::Run&, MadeUp&) {});
  EXPECT_EQ(budget.question, "Which configurations stay within 5 us a step?");
  EXPECT_EQ(
      budget.answer,
      "5 of 9 configurations fit. Along the number of objects, simple: fits everywhere; dbvt: "
      "fits up to 20, does not fit from 40; sap: fits nowhere.");
  EXPECT_EQ(budget.certainty, Certainty::kClear);
  plan::Plan one = MakePlan({}, 5, {.cycles = kMadeUpCycles, .record = {"timing"}});
  one.budget_s = 2e-6;
  const Conclusion of_one =
      ConclusionsOf(one, [](const plan::Run&) { return MadeUp{.ns = 2500}; }).front();
  EXPECT_EQ(of_one.question, "Does the simulation stay within 2 us a step?");
  EXPECT_EQ(of_one.answer, "No: the 99th percentile is 2.50 us (95 % interval 2.50 .. 2.50).");
}

TEST(Conclusions, DivideTheBudgetOfAFrameAmongItsSteps) {
  const figures::Budget budget = {4e6, 1.0 / 60};
  EXPECT_EQ(budget.Text(), "4 ms a frame of 1/60 s");
  EXPECT_EQ(budget.OfStep(1.0 / 60), 4e6);
  EXPECT_EQ(budget.OfStep(1.0 / 120), 2e6);
  EXPECT_EQ(budget.OfStep(1.0 / 30), 4e6);  // a step of two frames
  EXPECT_EQ(figures::Budget{4e6}.OfStep(1.0 / 120), 4e6);
  EXPECT_TRUE(std::isnan(budget.OfStep(NAN)));
  // Steps of 1 ms.
  plan::Plan plan =
      MakePlan({}, 5, {.cycles = kMadeUpCycles, .record = {"timing"}, .metrics = {"position"}});
  plan.budget_s = 5e-6;
  const auto answer = [&] {
    return ConclusionsOf(plan, [](const plan::Run&) { return MadeUp{.ns = 3000}; }).front();
  };
  EXPECT_TRUE(answer().answer.starts_with("Yes: ")) << answer().answer;
  plan.frame_s = 0.002;
  EXPECT_EQ(answer().question, "Does the simulation stay within 5 us a frame of 1/500 s?");
  EXPECT_TRUE(answer().answer.starts_with("No: ")) << answer().answer;
}

TEST(Conclusions, DoNotBlameConfigurationsForNoise) {
  // With simple, a cycle is disturbed in all but one repeat; the others cannot fit.
  const auto disturb = [](const plan::Run& run, MadeUp& made) {
    made.noise = machine::Noise::kNoisy;
    if (run.at[0] == 0 && run.rep > 0) made.stall = 1e5;
  };
  const Conclusion noisy = BudgetConclusion(disturb);
  EXPECT_EQ(noisy.answer,
            "2 of 9 configurations fit, 3 cannot be told (the machine was noisy). Along the number "
            "of objects, simple: cannot tell anywhere; dbvt: fits up to 20, does not fit from 40; "
            "sap: fits nowhere.");
  EXPECT_EQ(noisy.certainty, Certainty::kUnknown);
  const Conclusion quiet = BudgetConclusion([&](const plan::Run& run, MadeUp& made) {
    disturb(run, made);
    if (run.rep >= 2) made.noise = machine::Noise::kQuiet;
  });
  EXPECT_NE(quiet.answer.find("simple and sap: fits nowhere"), std::string::npos) << quiet.answer;
}

TEST(Conclusions, SayWhichOfTheFittingAreUnsound) {
  const auto unsound = [](std::size_t detectors) {
    return BudgetConclusion([=](const plan::Run& run, MadeUp& made) {
             if (run.at[0] < detectors) made.verdict = protocol::Verdict::kTunnelled;
           })
        .answer;
  };
  EXPECT_NE(unsound(1).find("sap: fits nowhere. 3 of these 5 are not stable."), std::string::npos)
      << unsound(1);
  EXPECT_NE(unsound(2).find(" None of these 5 is stable."), std::string::npos) << unsound(2);
}

TEST(Conclusions, AreNotClearOnTimesOfANoisyMachine) {
  const auto of = [](std::uint64_t noisy_repeats) {
    return FindConclusion(ConclusionsOf(DetectorPlan(5),
                                        [=](const plan::Run& run) {
                                          MadeUp made = FactorTimes(run, {2, 1, 1.2});
                                          if (run.rep < noisy_repeats)
                                            made.noise = machine::Noise::kNoisy;
                                          return made;
                                        }),
                          "fastest");
  };
  EXPECT_EQ(of(2).certainty, Certainty::kClear);
  EXPECT_EQ(of(5).certainty, Certainty::kUnknown);
  EXPECT_TRUE(of(5).answer.ends_with(
      " The machine was noisy in all runs: the order is more certain than the factors."))
      << of(5).answer;
  EXPECT_TRUE(
      of(3).answer.ends_with("noisy in 27 of 45 runs: the order is more certain than the "
                             "factors."))
      << of(3).answer;
  const plan::Plan one = MakePlan({}, 5, {.cycles = kMadeUpCycles, .record = {"timing"}});
  const Conclusion step = FindConclusion(
      ConclusionsOf(one, [](const plan::Run&) { return MadeUp{.noise = machine::Noise::kNoisy}; }),
      "fastest");
  EXPECT_EQ(step.certainty, Certainty::kUnknown);
  EXPECT_TRUE(step.answer.ends_with(
      " The machine was noisy in all runs: without disturbances, a step takes less."))
      << step.answer;
}

TEST(Conclusions, CallWhatCannotBeToldApartATie) {
  const auto all = ConclusionsOf(DetectorPlan(5), [](const plan::Run& run) {
    MadeUp made = FactorTimes(run, {2, 1, 1.001});
    // The repeats of one detector are slow when those of the other are fast.
    if (run.at[0] == 1) made.ns *= 1 + 0.02 * static_cast<double>(run.rep % 2);
    return made;
  });
  const Conclusion step = FindConclusion(all, "fastest");
  EXPECT_TRUE(step.answer.starts_with("sap and dbvt cannot be told apart: dbvt takes 1.0") ||
              step.answer.starts_with("dbvt and sap cannot be told apart: sap takes 1.0"))
      << step.answer;
  EXPECT_EQ(step.certainty, Certainty::kTie);
}

TEST(Conclusions, KnowNothingFromOneRepeat) {
  const auto all = ConclusionsOf(DetectorPlan(1), [](const plan::Run& run) {
    return FactorTimes(run, {2, 1, 1.2});
  });
  const Conclusion step = FindConclusion(all, "fastest");
  EXPECT_EQ(
      step.answer,
      "dbvt. Next is sap, with 1.20 times the time of dbvt. Last is simple, with 2.00 times the "
      "time of dbvt. These are geometric means over 3 cells. One repeat: there is no interval; "
      "`repeats 5` gives one. The broad phase is 100 % of a step.");
  EXPECT_EQ(step.certainty, Certainty::kUnknown);
}

TEST(Conclusions, SayWhereAnotherDetectorIsFaster) {
  const auto conclusion = [](std::uint64_t repeats) {
    return FindConclusion(ConclusionsOf(DetectorPlan(repeats),
                                        [](const plan::Run& run) {
                                          // n^2 compared with 15 n: faster at 10, slower at 20
                                          // and 40.
                                          constexpr double kObjects[] = {10, 20, 40};
                                          const double n = kObjects[run.at[1]];
                                          return MadeUp{.ns = run.at[0] == 0
                                                                  ? n * n
                                                                  : (run.at[0] == 1 ? 15 : 30) * n};
                                        }),
                          "fastest");
  };
  const Conclusion step = conclusion(5);
  EXPECT_NE(step.answer.find("dbvt. Next is simple, with 1.33 times the time of dbvt"),
            std::string::npos)
      << step.answer;
  EXPECT_NE(step.answer.find("It is not the best everywhere: simple at quantity 10."),
            std::string::npos)
      << step.answer;
  // Without a 95 % interval, it is not certain.
  for (const std::uint64_t repeats : {1, 4})
    EXPECT_EQ(conclusion(repeats).answer.find("not the best"), std::string::npos);
}

TEST(Conclusions, RankOverTheCellsThatAllHave) {
  const auto all = ConclusionsOf(DetectorPlan(5), [](const plan::Run& run) {
    MadeUp made = FactorTimes(run, {2, 1, 1.2});
    if (run.at[0] == 1 && run.at[1] == 2) made = {.ns = 1, .verdict = protocol::Verdict::kFrozen};
    return made;
  });
  EXPECT_NE(FindConclusion(all, "fastest")
                .answer.find("geometric means over 2 of 3 cells (those that all detectors have)"),
            std::string::npos);
  const Conclusion sound = FindConclusion(all, "stability");
  EXPECT_EQ(sound.answer,
            "8 of 9 configurations are stable, as far as was checked (1 frozen). Along the number "
            "of objects, simple and "
            "sap: stable everywhere; dbvt: stable up to 20, frozen from 40." +
                kNothingChecked);
}

/// The sentence on the boundary of a sweep over mass ratios, time steps and, for each of them, some
/// iterations, where `is_stable` holds.
std::string BoundaryOf(
    const std::function<bool(double ratio, std::size_t hz, std::size_t n)>& is_stable) {
  const std::vector<double> ratios = {1, 10, 100, 1000};
  const plan::Plan plan =
      MakePlan({NumberAxis("ratio", ratios), NumberAxis("hz", {30, 60, 120, 240, 480}),
                NumberAxis("iterations", {5, 10})},
               1, {.cycles = kMadeUpCycles, .record = {"timing"}});
  const std::string answer =
      FindConclusion(
          ConclusionsOf(plan,
                        [&](const plan::Run& run) {
                          return MadeUp{.verdict =
                                            is_stable(ratios[run.at[0]], run.at[1], run.at[2])
                                                ? protocol::Verdict::kStable
                                                : protocol::Verdict::kPenetrating};
                        }),
          "stability")
          .answer;
  const auto begin = answer.find(" Along "), end = answer.find(" Not checked");
  return begin == answer.npos ? answer : answer.substr(begin + 1, end - begin - 1);
}

TEST(Conclusions, StateTheBoundaryOfSoundSimulation) {
  // One other axis moves it.
  EXPECT_EQ(BoundaryOf([](double ratio, std::size_t hz, std::size_t) {
              return hz > 0 && ratio < std::pow(10.0, static_cast<double>(hz));
            }),
            "Along hz: stable from 60 on with ratio 1, from 120 on with ratio 10, from 240 on with "
            "ratio 100 and from 480 on with ratio 1000.");
  EXPECT_EQ(
      BoundaryOf([](double ratio, std::size_t hz, std::size_t) {
        return ratio * std::pow(10.0, static_cast<double>(hz)) >= 100;
      }),
      "Along hz: stable from 120 on with ratio 1, from 60 on with ratio 10 and everywhere with "
      "ratio 100 .. 1000.");
  // Several do.
  EXPECT_EQ(
      BoundaryOf([](double ratio, std::size_t hz, std::size_t n) {
        return std::log10(ratio) <= static_cast<double>((hz + n) / 2);
      }),
      "Along ratio: stable up to 1 in the worst case, up to 100 in the best; it depends on hz "
      "and iterations. One case at a time: `cdb show FILE --select hz=480 --select "
      "iterations=10`.");
  // There is none.
  EXPECT_EQ(BoundaryOf([](double ratio, std::size_t hz, std::size_t n) {
              return (static_cast<std::size_t>(std::log10(ratio)) + hz + n) % 3 != 0;
            }).substr(0, 34),
            "Along hz there is no boundary: 8 o");
}

TEST(Conclusions, NameTheCasesOfEachLine) {
  EXPECT_EQ(BoundaryOf([](double ratio, std::size_t hz, std::size_t n) {
              return hz == 4 && n == 1 && ratio < 500;
            }),
            "Along hz, 5 of the 8 combinations of ratio and iterations: penetrating everywhere; "
            "ratio 1 .. 100 and iterations 10: penetrating up to 240, stable from 480.");
  EXPECT_EQ(BoundaryOf([](double ratio, std::size_t hz, std::size_t n) {
              return n == 1 && (ratio < 2 ? hz > 0 : ratio < 20 ? hz > 1 : hz > 2);
            }),
            "Along hz: stable nowhere in the worst case, from 60 on in the best (4 of the 8 "
            "combinations of ratio and iterations are stable nowhere); it depends on ratio and "
            "iterations. One case at a time: `cdb show FILE --select ratio=1000 --select "
            "iterations=10`.");
}

TEST(Conclusions, NameTheValueThatExplainsTheVerdicts) {
  const plan::Plan plan =
      MakePlan({NumberAxis("hz", {30, 60, 120}), TextAxis("contact", {"bullet", "faithful"})}, 1,
               {.cycles = kMadeUpCycles, .record = {"timing"}});
  const auto all = ConclusionsOf(plan, [](const plan::Run& run) {
    return MadeUp{.verdict =
                      run.at[1] == 0 ? protocol::Verdict::kDrifting : protocol::Verdict::kStable};
  });
  const std::string answer = FindConclusion(all, "stability").answer;
  EXPECT_NE(answer.find("(3 drifting). That is: drifting with contact bullet and stable with "
                        "contact faithful."),
            answer.npos)
      << answer;
}

/// Not in the template below, which GCC 12 does not compile with designated initialisers.
plan::Plan ErrorPlan(const std::vector<double>& frictions, const std::vector<double>& rates) {
  return MakePlan({NumberAxis("friction", frictions), NumberAxis("hz", rates)}, 1,
                  {.cycles = kMadeUpCycles, .record = {"timing"}, .metrics = {"position"}});
}

using IsSound = std::function<bool(std::size_t friction, std::size_t step)>;

/// `use(plan, make_up)` of a sweep over `friction` and three or more time steps.
template <typename Use>
auto WithErrors(const std::vector<std::vector<double>>& errors, const IsSound& is_sound, Use use) {
  std::vector<double> frictions(errors.size()), rates(errors[0].size());
  for (std::size_t i = 0; i < frictions.size(); ++i) frictions[i] = 0.1 * static_cast<double>(i);
  for (std::size_t i = 0; i < rates.size(); ++i) rates[i] = 60.0 * std::pow(2, i);
  return use(ErrorPlan(frictions, rates), [&](const plan::Run& run) {
    MadeUp made;
    if (!is_sound(run.at[0], run.at[1])) made.verdict = protocol::Verdict::kDrifting;
    made.errors = {{"position", errors[run.at[0]][run.at[1]]}, {"timestep", 1 / rates[run.at[1]]}};
    return made;
  });
}

/// The conclusion on the order.
Conclusion OrderOf(const std::vector<std::vector<double>>& errors, const IsSound& is_sound) {
  return WithErrors(errors, is_sound, [](const plan::Plan& plan, const MakeUp& make_up) {
    return FindConclusion(ConclusionsOf(plan, make_up), "order");
  });
}

constexpr auto kAllSound = [](std::size_t, std::size_t) { return true; };

TEST(ErrorOrder, IsJudgedInEachCase) {
  const Conclusion falls = OrderOf({{0.4, 0.1, 0.025}, {0.04, 0.02, 0.01}}, kAllSound);
  EXPECT_EQ(
      falls.answer,
      "Yes: as the time step to the power 1.00 to 2.00 (95 % intervals within 1.00 .. 2.00).");
  EXPECT_EQ(falls.certainty, Certainty::kClear);
  const Conclusion one = OrderOf({{0.4, 0.1, 0.025}, {0.02, 0.02, 0.04}}, kAllSound);
  EXPECT_TRUE(one.answer.starts_with(
      "Yes for 1 of 2 values of friction (friction 0): as the time step to the power 2.00 (95 % "
      "interval 2.00 .. 2.00). No for 1 of 2 values of friction (friction 0.1): as the time step "
      "to the power -0.50 (95 % interval -4.17 .. 3.17). Where it does not fall, "))
      << one.answer;
  EXPECT_TRUE(one.answer.ends_with(
      " The error rises from 0.0200 at hz 60 to 0.0400 at hz 240 with friction 0.1."))
      << one.answer;
  EXPECT_EQ(one.certainty, Certainty::kUnknown);
}

TEST(ErrorOrder, IsNotToldFromAnIntervalThatHasAnySign) {
  const Conclusion few = OrderOf({{0.4, 0.1, 0.09}}, kAllSound);
  EXPECT_EQ(few.answer,
            "It falls with each shorter time step, but the order cannot be told from so few or "
            "such scattered errors: as the time step to the power 1.08 (95 % interval -5.70 .. "
            "7.85).");
  EXPECT_EQ(few.certainty, Certainty::kUnknown);
}

TEST(ErrorOrder, IsInTheFigureOfTheError) {
  const std::string orders = WithErrors(
      {{0.4, 0.1, 0.025}, {0.04, 0.02, 0.01}, {0.4, 0.2, 0.1}},
      [](std::size_t friction, std::size_t step) { return friction < 2 || step > 0; },
      [](const plan::Plan& plan, const MakeUp& make_up) {
        return WithMadeUpFile(plan, make_up, [](const results::ResultFile& file) {
          const figures::Model model(file);
          std::string text;
          for (const auto& [error, errors] : figures::CollectAllErrors(model))
            for (const figures::ErrorOrder& order : figures::OrdersOf(model, *error, errors))
              text += fmt::format("{} {}{}: {:.2f} {:.2f} {:.2f}; ", error->name,
                                  figures::PlaceText(file, errors.each, order.scene),
                                  figures::PlaceText(file, order.axes, order.at), order.fit.p,
                                  order.fit.interval.low, order.fit.interval.high);
          return text;
        });
      });
  // Two sound time steps have no order.
  EXPECT_EQ(orders, "position friction 0: 2.00 2.00 2.00; position friction 0.1: 1.00 1.00 1.00; ");
}

TEST(ErrorOrder, HidesNoUnsoundTimeStep) {
  const Conclusion rises =
      OrderOf({{0.4, 0.1, 0.025}, {0.4, 0.02, 0.2}},
              [](std::size_t friction, std::size_t step) { return friction == 0 || step < 2; });
  EXPECT_EQ(
      rises.answer,
      "Yes for 1 of 2 values of friction (friction 0): as the time step to the power 2.00 "
      "(95 % interval 2.00 .. 2.00). Not judged for 1 of 2 values of friction (friction 0.1): "
      "fewer than three time steps are sound. The error rises from 0.0200 at hz 120 to 0.200 "
      "at hz 240 (drifting) with friction 0.1.");
  EXPECT_EQ(rises.certainty, Certainty::kUnknown);
  const Conclusion left_out =
      OrderOf({{0.8, 0.4, 0.2, 0.1}}, [](std::size_t, std::size_t step) { return step > 0; });
  EXPECT_EQ(left_out.answer,
            "Yes: as the time step to the power 1.00 (95 % interval 1.00 .. 1.00). 1 unsound time "
            "step is left out of the fits.");
  EXPECT_EQ(OrderOf({{0.4, 0.1}}, kAllSound).answer, "");  // not swept enough to ask
}

TEST(ErrorOrder, IsNotClearWithoutMonotony) {
  // The order is certain, and one step is not.
  const Conclusion wavy = OrderOf({{1, 0.5, 0.25, 0.126, 0.135, 0.03, 0.015}}, kAllSound);
  EXPECT_TRUE(wavy.answer.starts_with("Yes: as the time step to the power 0.97 (")) << wavy.answer;
  EXPECT_TRUE(
      wavy.answer.ends_with(" The error rises from 0.126 at hz 480 to 0.135 at hz 960 with "
                            "friction 0."))
      << wavy.answer;
  EXPECT_EQ(wavy.certainty, Certainty::kUnknown);
  const Conclusion scattered = OrderOf({{0.4, 0.04, 0.3}}, kAllSound);
  EXPECT_TRUE(scattered.answer.starts_with("No: ") ||
              scattered.answer.starts_with("Not judged: the errors scatter."))
      << scattered.answer;
}

TEST(Conclusions, StateBoundariesByValueNotByOrder) {
  // Values in the order of the sweep: 40, 10, 20.
  const plan::Plan plan = MakePlan({NumberAxis("quantity", {40, 10, 20})}, 1,
                                   {.cycles = kMadeUpCycles, .record = {"timing"}});
  const auto all = ConclusionsOf(plan, [](const plan::Run& run) {
    return MadeUp{.verdict =
                      run.at[0] == 0 ? protocol::Verdict::kTunnelled : protocol::Verdict::kStable};
  });
  const std::string answer = FindConclusion(all, "stability").answer;
  EXPECT_NE(answer.find("Along the number of objects: stable up to 20, tunnelled from 40."),
            answer.npos)
      << answer;
}

TEST(Conclusions, SayThatNothingIsStableOnce) {
  const plan::Plan plan =
      MakePlan({NumberAxis("hz", {30, 60, 120}), NumberAxis("iterations", {5, 10, 20})}, 1,
               {.cycles = kMadeUpCycles, .record = {"timing"}});
  using enum protocol::Verdict;
  constexpr protocol::Verdict kVerdicts[] = {kTunnelled, kPenetrating, kDrifting};
  const auto all = ConclusionsOf(plan, [&](const plan::Run& run) {
    return MadeUp{.verdict = kVerdicts[(run.at[0] + run.at[1]) % 3]};
  });
  const std::string answer = FindConclusion(all, "stability").answer;
  EXPECT_NE(answer.find(" Along hz: stable nowhere."), answer.npos) << answer;
}

TEST(Conclusions, SayWhetherDetectorsMoveObjectsAlike) {
  const auto answer = [](const std::function<std::string(const plan::Run&)>& state,
                         std::size_t drifting) {
    return FindConclusion(ConclusionsOf(DetectorPlan(1),
                                        [&](const plan::Run& run) {
                                          MadeUp made{.state = state(run)};
                                          if (run.at[0] == 2 && run.at[1] < drifting)
                                            made.verdict = protocol::Verdict::kDrifting;
                                          return made;
                                        }),
                          "stability")
        .answer;
  };
  const std::string alike =
      answer([](const plan::Run& run) { return std::to_string(run.at[1]); }, 0);
  EXPECT_NE(alike.find(" All detectors moved every object alike, to the last bit."), alike.npos)
      << alike;
  const auto by_detector = [](const plan::Run& run) {
    return std::to_string(run.at[1] < 2 ? run.at[0] : 7);
  };
  const std::string differing = answer(by_detector, 0);
  EXPECT_NE(differing.find(" The motion differs between detectors at 2 of 3 points; `pair_order "
                           "sorted` keeps it alike."),
            differing.npos)
      << differing;
  const std::string verdicts = answer(by_detector, 1);
  EXPECT_NE(verdicts.find(" at 2 of 3 points, and the verdict at 1; `pair_order"), verdicts.npos)
      << verdicts;
}

TEST(Conclusions, CompareMemory) {
  const auto memory = [](double of_simple) {
    return FindConclusion(
        ConclusionsOf(DetectorPlan(5),
                      [&](const plan::Run& run) {
                        return MadeUp{.peak_rss = run.at[0] == 0 ? of_simple : 4e6};
                      }),
        "memory");
  };
  EXPECT_EQ(memory(4.02e6).answer, "");  // the same to within 2 %
  EXPECT_NE(memory(8e6).answer.find("Last is simple, with 2.00 times the memory of"),
            std::string::npos)
      << memory(8e6).answer;
}

TEST(Conclusions, TellHowAStepScales) {
  const auto all = ConclusionsOf(DetectorPlan(5), [](const plan::Run& run) {
    return FactorTimes(run, {2, 1, 1.2});
  });
  const Conclusion scaling = FindConclusion(all, "scaling");
  EXPECT_EQ(scaling.question, "How does the time of a step change with the number of objects?");
  EXPECT_EQ(scaling.answer,
            "A step takes 4.00 times as long with quantity 40 as with quantity 10 (95 % interval "
            "4.00 .. 4.00), the geometric mean over 3 cells.");
  EXPECT_EQ(scaling.certainty, Certainty::kClear);
}

/// n^1 times e^(bounce / 10), for each of two detectors.
TEST(Conclusions, StateTheEffectsOfSampledParameters) {
  constexpr std::size_t kPoints = 32;
  plan::Axis design = NumberAxis("design", {});
  design.sampled = {{"n", 10, 1000, true, {}}, {"bounce", 0, 1, false, {}}};
  for (std::size_t i = 0; i < kPoints; ++i) {
    design.values.emplace_back(static_cast<double>(i + 1));
    design.sampled[0].values.push_back(10 *
                                       std::pow(100, evaluate::SobolCoordinates(0, kPoints)[i]));
    design.sampled[1].values.push_back(evaluate::SobolCoordinates(1, kPoints)[i]);
  }
  const plan::Plan plan = MakePlan({TextAxis("detector", {"dbvt", "sap"}), design}, 1,
                                   {.cycles = kMadeUpCycles, .record = {"timing"}});
  const auto make_up = [&](const plan::Run& run) {
    const double n = design.sampled[0].values[run.at[1]],
                 bounce = design.sampled[1].values[run.at[1]];
    return MadeUp{.ns = 1000 * n * std::exp(bounce / 10)};
  };
  WithMadeUpFile(plan, make_up, [&](results::ResultFile&& file) {
    EXPECT_EQ(file.axes()[1].sampled, design.sampled);
    std::vector<Conclusion> effects;
    for (const Conclusion& of : figures::Conclusions(figures::Model(file))) {
      EXPECT_NE(of.kind, "scaling") << of.answer;
      if (of.kind == "effects") effects.push_back(of);
    }
    EXPECT_EQ(effects.size(), 2u);
    if (effects.size() < 2) return 0;
    EXPECT_EQ(effects[1].question, "What changes the time of a step of sap over design?");
    EXPECT_EQ(effects[1].answer,
              "n from 10.0 to 1000: 100 times (95 % interval 100 .. 100), 100 % of the variance; "
              "bounce from 0 to 1.00: 1.11 times (95 % interval 1.11 .. 1.11), less than 0.1 % of "
              "the variance. Not explained: less than 0.1 %; by a fit to 32 points.");
    EXPECT_EQ(effects[1].certainty, Certainty::kClear);
    file.Select(1, {3, 7});
    EXPECT_EQ(file.axes()[1].sampled[0].values,
              (std::vector{design.sampled[0].values[3], design.sampled[0].values[7]}));
    const auto of_two = figures::Conclusions(figures::Model(file));
    EXPECT_TRUE(FindConclusion(of_two, "effects")
                    .answer.starts_with("Unknown: of 2 points, too few are sound"));
    return 0;
  });
}

TEST(Conclusions, NameTheMostAccurateWithinRealTime) {
  plan::Plan plan =
      MakePlan({NumberAxis("iterations", {5, 10, 20, 40})}, 5,
               {.cycles = kMadeUpCycles, .record = {"timing"}, .metrics = {"position"}});
  plan.axes[0].parameter = "solver.iterations";
  const auto all = ConclusionsOf(plan, [](const plan::Run& run) {
    // A cycle of 1 ms takes 0.1, 0.2 or 0.4 ms, or, slower than real time, 2 ms.
    constexpr double kNs[] = {1e5, 2e5, 4e5, 2e6}, kErrors[] = {0.4, 0.2, 0.1, 0.01};
    return MadeUp{.ns = kNs[run.at[0]], .errors = {{"position", kErrors[run.at[0]]}}};
  });
  const Conclusion error = FindConclusion(all, "error");
  EXPECT_EQ(error.question,
            "Which configuration has the least error of position within real time?");
  EXPECT_EQ(error.answer,
            "iterations 20: 0.100, at 2.50 times real time (95 % interval 2.50 .. 2.50). The "
            "fastest is iterations 5: 0.400, at 10.0 times real time (95 % interval 10.0 .. "
            "10.0). All 4 configurations are on the front: accuracy costs time throughout.");
  EXPECT_EQ(error.certainty, Certainty::kClear);
}

TEST(Conclusions, TellWhatAStepTakesWithoutAxes) {
  const plan::Plan plan = MakePlan({}, 5, {.cycles = kMadeUpCycles, .record = {"timing"}});
  const auto all = ConclusionsOf(plan, [](const plan::Run&) { return MadeUp{.ns = 2500}; });
  EXPECT_EQ(FindConclusion(all, "fastest").answer,
            "2.50 us (95 % interval 2.50 .. 2.50). Its largest phase is broad: 2.50 us, 100 % of "
            "the step.");
  EXPECT_EQ(FindConclusion(all, "stability").answer,
            "Nothing wrong was found, as far as was checked." + kNothingChecked);
}

TEST(Conclusions, AreOfNoTimeWhereEveryRunIsVoid) {
  const auto all = ConclusionsOf(DetectorPlan(1), [](const plan::Run&) {
    return MadeUp{.verdict = protocol::Verdict::kFrozen};
  });
  ASSERT_EQ(all.size(), 1u) << all[0].answer;
  EXPECT_EQ(all[0].answer, "0 of 9 configurations are stable (9 frozen).");
}

TEST(Conclusions, AreNoneOfFailedRuns) {
  const auto all = ConclusionsOf(DetectorPlan(1), [](const plan::Run&) {
    return MadeUp{
        .verdict = protocol::Verdict::kUnknown, .status = results::Status::kFailed, .cycles = 0};
  });
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].answer, "0 of 9 configurations are stable (9 failed).");
}

}  // namespace
}  // namespace cdb::tests
