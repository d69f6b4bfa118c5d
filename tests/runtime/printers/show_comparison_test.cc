// Summaries of results with made-up times, gaps, verdicts and omissions.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "runtime/printers/show.h"
#include "tests/runtime/figures/made_up_file.h"

namespace cdb::tests {
namespace {

std::string Shown(const plan::Plan& plan, const MakeUp& make_up,
                  const printers::ShowOptions& options = {}) {
  return WithMadeUpFile(plan, make_up, [&](const results::ResultFile& file) {
    return printers::Show(file, options).text;
  });
}

plan::Plan Grid(std::uint64_t repeats = 1, std::vector<std::vector<std::size_t>> skipped = {}) {
  return MakePlan(
      {TextAxis("detector", {"simple", "dbvt", "sap"}), NumberAxis("quantity", {10, 20, 40})},
      repeats, {.cycles = kMadeUpCycles, .record = {"timing"}}, std::move(skipped));
}

/// The text with single spaces, because columns are as wide as the table needs.
std::string Squeezed(const std::string& text) {
  std::string squeezed;
  for (const char c : text)
    if (c != ' ' || !squeezed.ends_with(' ')) squeezed += c;
  return squeezed;
}
void ExpectHas(const std::string& text, const std::string& part) {
  EXPECT_NE(Squeezed(text).find(Squeezed(part)), std::string::npos) << part << "\nis not in\n"
                                                                    << text;
}
void ExpectLacks(const std::string& text, const std::string& part) {
  EXPECT_EQ(Squeezed(text).find(Squeezed(part)), std::string::npos) << part << "\nis in\n" << text;
}

/// 100 ns per object; dbvt takes 1.2 times as long as simple, and sap twice.
MadeUp OfQuantity(const plan::Run& run) {
  constexpr double kObjects[] = {10, 20, 40}, kFactors[] = {1, 1.2, 2};
  return {.ns = 100 * kObjects[run.at[1]] * kFactors[run.at[0]]};
}

TEST(ShowComparison, PoolsTheCellsThatAllRowsHave) {
  const std::string text = Shown(Grid(1, {{0, 2}}), OfQuantity, {.by = {"detector"}});
  // Over 10 and 20 objects; with 40, dbvt would have 2.80 and sap 4.67.
  ExpectHas(text, "\n  simple         2   1.50 ");
  ExpectHas(text, "\n  dbvt      2 of 3   1.80 ");
  ExpectHas(text, "\n  sap       2 of 3   3.00 ");
  ExpectHas(text, "\n  A row pools only the cells that all rows of its kind have: k of its n.\n");
}

TEST(ShowComparison, SaysWhereNoCellIsInAllRows) {
  const std::string text = Shown(Grid(1, {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}}),
                                 OfQuantity, {.by = {"detector"}});
  // Each row has one cell, which no other row has.
  ExpectHas(text, "No cell is in all rows of a kind");
}

TEST(ShowComparison, TakesTheFirstDetectorThatHasAllCells) {
  const std::string text = Shown(Grid(1, {{0, 2}}), OfQuantity);
  ExpectHas(text, "\nMean detect over that of dbvt (geometric mean below)\n");
  ExpectHas(text, "\n        40               -         (1.00)       (1.67)\n");
  ExpectHas(text, "\n      mean           0.833           1.00         1.67\n");
  ExpectHas(text, "\n  Mean and range over 2 of 3 cells: those that all detectors have.\n");
}

TEST(ShowComparison, DividesByTheBaselineThatIsAskedFor) {
  const std::string text = Shown(Grid(), OfQuantity, {.baseline = "sap"});
  ExpectHas(text, "\nMean detect over that of sap (geometric mean below)\n");
  ExpectHas(text, "\n      mean           0.500           0.600           1.00\n");
  ExpectHas(text, "\n  Mean and range over 3 of 3 cells.\n");
  try {
    Shown(Grid(), OfQuantity, {.baseline = "sup"});
    FAIL();
  } catch (const files::StoreError& error) {
    EXPECT_STREQ(error.what(),
                 "there is no detector 'sup' in this file; there are simple, dbvt, sap");
  }
}

TEST(ShowComparison, PrintsWhatAVerdictVoidsWithItsMark) {
  const auto freeze_dbvt_20 = [](const plan::Run& run) {
    MadeUp made = OfQuantity(run);
    if (run.at[0] == 1 && run.at[1] == 1) made.verdict = protocol::Verdict::kFrozen;
    return made;
  };
  const std::string text = Shown(Grid(), freeze_dbvt_20);
  ExpectHas(text,
            "\n  1 did not end well (1 frozen), marked below, and not pooled with others in means "
            "and ratios:\n    detector dbvt, quantity 20, rep 0: frozen from cycle 3 on\n");
  ExpectHas(text,
            "\n  dbvt            20   2.40    2.40    2.40   2.40       2.40  2.40  frozen\n");
  ExpectHas(text, "\n        20          (1.00)          (1.20)       (2.00)\n");
  ExpectHas(text, "\n  Mean and range over 2 of 3 cells: those that all detectors have.\n");
  const std::string pooled = Shown(Grid(), freeze_dbvt_20, {.by = {"detector"}});
  ExpectHas(pooled, "\n  dbvt           2   3.00 ");
  ExpectHas(pooled, "\n  dbvt           1   2.40 ");
  const std::string sound = Shown(Grid(), freeze_dbvt_20, {.only_sound = true});
  ExpectHas(sound, "1 did not end well (1 frozen), excluded by --sound:");
  ExpectLacks(sound, "2.40");
}

TEST(ShowComparison, PrintsATableOfVoidRunsAlone) {
  const std::string text = Shown(Grid(), [](const plan::Run& run) {
    MadeUp made = OfQuantity(run);
    made.verdict = protocol::Verdict::kFrozen;
    return made;
  });
  ExpectHas(text, "9 did not end well (9 frozen)");
  ExpectHas(text,
            "\n  dbvt            20   2.40    2.40    2.40   2.40       2.40  2.40  frozen\n");
  ExpectHas(text, "\n      mean          (1.00)          (1.20)          (2.00)\n");
  ExpectHas(text, "\n  In parentheses: every run is void.\n");
}

TEST(ShowComparison, MarksRowsWithOtherOmissions) {
  const auto omit = [](const plan::Run& run) {
    MadeUp made = OfQuantity(run);
    const bool left_out = run.at[1] == 0;
    made.omitted = left_out ? "walls solver pools" : "walls";
    made.decisions = std::string("walls: left out: a test\nsolver: ") +
                     (left_out ? "left out" : "kept") + ": a test\n";
    return made;
  };
  const std::string text = Shown(Grid(), omit);
  ExpectHas(
      text,
      "\n  dbvt            10   1.20    1.20    1.20   1.20       1.20  1.20  without solver\n");
  ExpectHas(text, "\n  dbvt            20   2.40    2.40    2.40   2.40       2.40  2.40\n");
  // All detectors omitted the same components at each quantity.
  ExpectHas(text, "\n  Mean and range over 3 of 3 cells.\n");
  const std::string pooled = Shown(Grid(), omit, {.by = {"detector"}});
  ExpectHas(pooled, "  without solver\n");
  ExpectHas(pooled, "\n  dbvt          1   1.20 ");
  ExpectHas(pooled, "\n  dbvt          2   3.60 ");
}

TEST(ShowComparison, KeepsRatiosOfUnlikeOmissionsOutOfTheMean) {
  const std::string text = Shown(Grid(), [](const plan::Run& run) {
    MadeUp made = OfQuantity(run);
    const bool left_out = run.at[0] == 1 && run.at[1] == 0;
    made.omitted = left_out ? "solver" : "";
    made.decisions = std::string("solver: ") + (left_out ? "left out" : "kept") + ": a test\n";
    return made;
  });
  ExpectHas(text, "\n        10          (1.00)          (1.20)       (2.00)\n");
  ExpectHas(text, "\nAt 1 of 3 points, some detectors ran without solver and others with it: ");
  ExpectHas(text, "\n  Mean and range over 2 of 3 cells: those that all detectors have.\n");
}

TEST(ShowComparison, SaysHowItsIntervalsWereMade) {
  const auto vary = [](const plan::Run& run) {
    MadeUp made = OfQuantity(run);
    made.ns *= 1 + 0.01 * static_cast<double>(run.rep);
    return made;
  };
  const std::string one = Shown(Grid(1), vary);
  ExpectHas(one, "\n  Mean over cycles; no interval: one repeat.\n");
  const std::string three = Shown(Grid(3), vary);
  ExpectHas(three, "\nMean of a cycle, its range, us\n");
  ExpectHas(three, "\n  Range over all draws of 3 repeats; a 95 % interval needs 5 repeats.\n");
  ExpectHas(three, "1.00 .. 1.02");
  const std::string five = Shown(Grid(5), vary);
  ExpectHas(five, "\nMean of a cycle, its 95 % interval, us\n");
  ExpectHas(five, "\n  By bootstrap over the 5 repeats, whole runs at a time.\n");
  // The repeats of all detectors vary equally, so that their ratios are constant.
  ExpectHas(five, "1.20 .. 1.20");
}

TEST(ShowComparison, LeavesARepeatThatDidNotEndWellOutOfItsPoint) {
  const std::string text = Shown(Grid(5), [](const plan::Run& run) {
    MadeUp made = OfQuantity(run);
    if (run.at[0] == 1 && run.at[1] == 1 && run.rep == 4)
      made = {.ns = 1e9, .verdict = protocol::Verdict::kTimedOut};
    return made;
  });
  ExpectHas(text, "1 did not end well (1 timed_out)");
  ExpectHas(text, "\n  dbvt            20   2.40    2.40    2.40   2.40       2.40  2.40\n");
  ExpectHas(text, "\n  dbvt            20      -    -    -   -       -  -\n");
  ExpectHas(text,
            "\n  By bootstrap over the 5 repeats, whole runs at a time. -: a repeat is missing or "
            "void.\n");
}

TEST(ShowBudget, SaysWhichPointsFit) {
  const auto shown = [](std::size_t repeats, double budget_ns) {
    // dbvt with 20 objects takes 2.4 us, 1 % more in each repeat; the first cycle of one stalls.
    const auto make_up = [](const plan::Run& run) {
      MadeUp made = OfQuantity(run);
      made.ns *= 1 + 0.01 * static_cast<double>(run.rep);
      if (run.rep == 1) made.stall = 1e6;
      return made;
    };
    return WithMadeUpFile(Grid(repeats), make_up, [&](const results::ResultFile& file) {
      return printers::ShowBudget(file, {.budget = {budget_ns}}).text;
    });
  };
  const std::string five = shown(5, 2450);
  ExpectHas(five, "Cycles whose step takes more than 2.45 us\n");
  // The median of the repeats is 2.448 us; its interval ends above the budget.
  const std::size_t row = five.find("\n  dbvt            20 ");
  ASSERT_NE(row, std::string::npos) << five;
  const std::string dbvt = five.substr(row, five.find('\n', row + 1) - row);
  ExpectHas(dbvt, "cannot tell");
  ExpectHas(dbvt, "1002");  // the stall, in us
  ExpectHas(shown(5, 1e5), "9 of 9 configurations fit");
  ExpectHas(shown(5, 1), "0 of 9 configurations fit.");
  ExpectHas(shown(1, 1e5), "One repeat: there is no interval");
  ExpectLacks(shown(5, 2450), "at least");
}

TEST(ShowBudget, HasALowerBoundForNoisyRuns) {
  const auto shown = [](std::uint64_t repeats) {
    // A cycle of most repeats is disturbed.
    const auto make_up = [](const plan::Run& run) {
      MadeUp made = OfQuantity(run);
      made.noise = machine::Noise::kNoisy;
      if (run.rep != 1) made.stall = 1e6;
      return made;
    };
    return WithMadeUpFile(Grid(repeats), make_up, [&](const results::ResultFile& file) {
      return printers::ShowBudget(file, {.budget = {3000}}).text;
    });
  };
  const std::string five = shown(5);
  ExpectHas(five, "its 95 % interval  at least, us  worst, us");
  ExpectHas(five, "  2.40       1002  cannot tell: noisy\n");
  ExpectHas(five, "  8.00       1008                 no\n");
  ExpectHas(five, "\n  at least: on a noisy machine, ");
  // The median of the cycles of the only repeat.
  ExpectHas(shown(1), "  2.40       1002  cannot tell: noisy\n");
  ExpectHas(shown(1), "  8.00       1008                 no\n");
}

TEST(ShowBudget, IsAnsweredOnceInShow) {
  plan::Plan plan = Grid();
  plan.budget_s = 1e-6;
  for (const bool is_brief : {true, false}) {
    const std::string text = Shown(plan, OfQuantity, {.is_brief = is_brief});
    const std::string answer = "configurations fit";
    const std::size_t first = text.find(answer);
    ASSERT_NE(first, std::string::npos) << text;
    EXPECT_EQ(text.find(answer, first + 1), std::string::npos) << text;
  }
}

/// Both commands, for runs one of which stalled.
TEST(ShowComparison, HasOneStatisticInBothCommands) {
  const plan::Plan plan =
      MakePlan({NumberAxis("quantity", {10, 20})}, 5,
               {.cycles = kMadeUpCycles, .record = {"timing"}, .metrics = {"position"}});
  const auto stall = [](const plan::Run& run) {
    return MadeUp{.ns = run.at[0] == 0 ? 2e6 : 3e6, .stall = run.rep == 2 ? 1e9 : 0.0};
  };
  const std::string shown = Shown(plan, stall);
  ExpectHas(shown, "\n        10   2.00    2.00    2.00   2.00       2.00  2.00\n");
  const std::string error = WithMadeUpFile(plan, stall, [](const results::ResultFile& file) {
    return printers::ShowError(file, {{"position", {}, {}}}).text;
  });
  // A cycle of 1 ms takes 2 ms.
  ExpectHas(error, "\n        10        0.500      2000 ");
  ExpectHas(error,
            "\n  Median over 5 repeats per cycle, then mean over cycles; bootstrap over whole "
            "repeats.\n");
}

}  // namespace
}  // namespace cdb::tests
