#include "runtime/printers/show.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "runtime/figures/bootstrap.h"
#include "runtime/terminal/table.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

TEST(Percentile, LiesBetweenNeighboursInProportion) {
  const std::vector<double> values = {1, 2, 3, 4, 5};
  EXPECT_EQ(figures::Percentile(values, 0.5), 3);
  EXPECT_EQ(figures::Percentile(values, 0), 1);
  EXPECT_EQ(figures::Percentile(values, 1), 5);
  EXPECT_DOUBLE_EQ(figures::Percentile(values, 0.05), 1.2);
  EXPECT_EQ(figures::Percentile({7}, 0.95), 7);
  EXPECT_TRUE(std::isnan(figures::Percentile({}, 0.5)));
}

TEST(Table, LinesUp) {
  terminal::Table table;
  table.AddColumn("name", false);
  table.AddColumn("time", true);
  table.AddRow({"a", "1.5"});
  table.AddRow({"\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4", "12"});
  EXPECT_EQ(table.Text(),
            "  name   time\n  -----------\n  a       1.5\n  "
            "\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4    12\n");
}

TEST(ShortNumber, HasThreeOrFourDigits) {
  EXPECT_EQ(terminal::ShortNumber(0.012345), "0.0123");
  EXPECT_EQ(terminal::ShortNumber(1.2345), "1.23");
  EXPECT_EQ(terminal::ShortNumber(123.45), "123");
  EXPECT_EQ(terminal::ShortNumber(1234.5), "1234");
  EXPECT_EQ(terminal::ShortNumber(12345.6), "12350");
  EXPECT_EQ(terminal::ShortNumber(9.999), "10.0");
  EXPECT_EQ(terminal::ShortNumber(999.9), "1000");
  EXPECT_EQ(terminal::ShortNumber(1.2345e7), "1.23e+07");
  EXPECT_EQ(terminal::ShortNumber(0.000012345), "1.23e-05");
  EXPECT_EQ(terminal::ShortNumber(0), "0");
  EXPECT_EQ(terminal::ShortNumber(NAN), "-");
}

TEST(CoordinateText, IsAsWrittenOrShort) {
  EXPECT_EQ(terminal::CoordinateText(NumberAxis("dt", {1.0 / 60, 1.0 / 120}), 0), "0.01667");
  EXPECT_EQ(terminal::CoordinateText(NumberAxis("x", {0.123456, 0.123467}), 1), "0.123467");
  EXPECT_EQ(terminal::CoordinateText(NumberAxis("quantity", {16384, 2}), 0), "16384");
  EXPECT_EQ(terminal::CoordinateText(NumberAxis("x", {0.5, 0.5}), 0), "0.5");
}

TEST(Show, BeginsWithTheAnswersAndOneTable) {
  const Program program;
  program.Write("s.cdb",
                "benchmark s \"The title\" { cycles 10; detector sweep(sap, dbvt, simple)\n"
                "objects.quantity sweep(2, 4) }");
  const Finished run = program.Run({"run", "s.cdb"});
  ASSERT_EQ(run.status, 0);
  const Finished shown = program.Run({"show", "s.h5"});
  for (const std::string& text : {run.out, shown.out}) {
    for (const char* part :
         {"The title\n  6 runs", "Which detector takes the least time for a step?\n",
          "`repeats 5` gives one",
          "Is the simulation sound?\n    Yes: all 6 configurations are stable.", "Mean of a cycle",
          "cdb show s.h5 --all", "cdb report s.h5"})
      EXPECT_NE(text.find(part), std::string::npos) << part << " in:\n" << text;
    for (const char* rest : {"percentile", "Measurement overhead", "Omitted", "Mean step over"})
      EXPECT_EQ(text.find(rest), std::string::npos) << rest << " in:\n" << text;
    EXPECT_LE(std::ranges::count(text, '\n'), 30) << text;
  }
  const Finished all = program.Run({"show", "s.h5", "--all"});
  for (const char* rest : {"percentile", "Measurement overhead", "Mean step over"})
    EXPECT_NE(all.out.find(rest), std::string::npos) << rest << " in:\n" << all.out;
  EXPECT_EQ(program.Run({"show", "s.h5", "--all", "--csv"}).status, 2);
}

TEST(Show, HasAxesPhasesCountsAndRatios) {
  const Program program;
  program.Write(
      "s.cdb",
      "benchmark s \"The title\" { cycles 10; repeats 2; detector sweep(sap, dbvt, simple)\n"
      "objects.quantity sweep(2, 4) }");
  ASSERT_EQ(program.Run({"run", "s.cdb", "-q"}).status, 0);
  const Finished shown = program.Run({"show", "s.h5", "--all"});
  EXPECT_EQ(shown.status, 0);
  for (const char* part :
       {"The title", "12 runs (3 values of detector x 2 of quantity x 2 repeats), 10 cycles",
        "broad", "integrate", "pairs", "contacts", "5th .. 95th percentile",
        "Mean step over that of sap", "mean"})
    EXPECT_NE(shown.out.find(part), std::string::npos) << part << " in:\n" << shown.out;
  // One row for each of the six points, in the order of the grid.
  EXPECT_NE(shown.out.find("\n  sap              2"), std::string::npos) << shown.out;
  const Finished by = program.Run({"show", "s.h5", "--by", "quantity"});
  EXPECT_EQ(by.status, 0);
  EXPECT_EQ(by.out.find("\n  sap              2"), std::string::npos) << by.out;
  const Finished to_simple = program.Run({"show", "s.h5", "--baseline", "simple"});
  EXPECT_EQ(to_simple.status, 0);
  EXPECT_NE(to_simple.out.find("Mean step over that of simple"), std::string::npos)
      << to_simple.out;
  const Finished misspelt = program.Run({"show", "s.h5", "--baseline", "simpel"});
  EXPECT_EQ(misspelt.status, 2);
  EXPECT_NE(misspelt.err.find("there is no detector 'simpel' in this file; there are sap, dbvt, "
                              "simple"),
            std::string::npos)
      << misspelt.err;
  const Finished wrong = program.Run({"show", "s.h5", "--by", "size"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_NE(wrong.err.find("detector, quantity"), std::string::npos) << wrong.err;
}

/// The output of `show` for a grid of detectors and quantities, whose runs omitted what `settle`
/// sets.
std::string Shown(
    const std::function<void(std::size_t, std::size_t, results::RunResult&)>& settle) {
  const plan::Plan plan =
      MakePlan({TextAxis("detector", {"sap", "dbvt"}), NumberAxis("quantity", {10, 20})}, 1,
               {.record = {"timing", "counts"}});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs) {
    FakeResult fake(run);
    fake.result.omitted = fake.result.decisions = "";
    settle(run.at[0], run.at[1], fake.result);
    WriteRun(plan, run, fake.result, TestProvenance(), folder.path());
  }
  journal::Merge(plan, TestProvenance(), folder.path(), folder / "out.h5");
  return printers::Show(results::ResultFile(folder / "out.h5")).text;
}

/// The output of `show` for 4 cycles with these counts of each phase, in the order of
/// schema::kCounters.
std::string ShownCounts(const std::vector<std::vector<double>>& counts) {
  const plan::Plan plan =
      MakePlan({NumberAxis("quantity", {10})}, 1, {.cycles = 4, .record = {"timing", "counters"}});
  std::vector<double> values;
  for (const std::vector<double>& of_counter : counts)
    for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase)
      values.insert(values.end(), of_counter.begin(), of_counter.end());
  const TemporaryFolder folder;
  FakeResult fake(plan.runs[0]);
  for (auto& [series, bytes] : fake.result.series)
    if (series->name == "counters") bytes = std::as_bytes(std::span(values));
  WriteRun(plan, plan.runs[0], fake.result, TestProvenance(), folder.path());
  journal::Merge(plan, TestProvenance(), folder.path(), folder / "out.h5");
  return printers::Show(results::ResultFile(folder / "out.h5")).text;
}

TEST(Show, SaysWhichCountersAreMissing) {
  const std::vector<double> none(4, NAN), zeros(4, 0);
  const std::string hidden = ShownCounts({none, none, none, none, zeros});
  EXPECT_NE(hidden.find("instructions, cpu_cycles, cache_misses, branch_misses: not counted by the "
                        "machine of these runs; most virtual machines hide these counters"),
            std::string::npos)
      << hidden;
  const std::string denied = ShownCounts({none, none, none, none, none});
  EXPECT_NE(denied.find("page_faults: not counted by the machine of these runs, which does not "
                        "permit it"),
            std::string::npos)
      << denied;
  const std::string some =
      ShownCounts({{1000, 1000, 1000, 1000}, {500, 1500, 3000, 3000}, none, {7, NAN, 7, 7}, zeros});
  for (const char* part : {"instructions  cpu_cycles  page_faults  per cpu_cycle",
                           "cache_misses: not counted by the machine of these runs (cdb doc",
                           "branch_misses: without a mean, since only some of the cycles were"})
    EXPECT_NE(some.find(part), std::string::npos) << part << " in:\n" << some;
  EXPECT_EQ(some.find("virtual"), std::string::npos) << some;
}

TEST(Show, NamesThePaddingOfRunsOfDifferentLength) {
  const auto shown = [](std::uint64_t cycles) {
    plan::Plan plan = MakePlan({NumberAxis("hz", {15, 30})}, 1, {.cycles = 100});
    Resize(plan.runs[0], {.cycles = cycles});
    const TemporaryFolder folder;
    for (const plan::Run& run : plan.runs)
      WriteRun(plan, run, FakeResult(run).result, TestProvenance(), folder.path());
    journal::Merge(plan, TestProvenance(), folder.path(), folder / "out.h5");
    return printers::Show(results::ResultFile(folder / "out.h5")).text;
  };
  const std::string half = shown(16);
  EXPECT_NE(half.find("\n  2 runs (2 values of hz), 16 to 100 cycles\n  42 % of the arrays over "
                      "cycles in the file is padding of shorter runs.\n"),
            std::string::npos)
      << half;
  EXPECT_EQ(shown(98).find("padding"), std::string::npos);
  EXPECT_EQ(shown(100).find("padding"), std::string::npos);
}

TEST(Show, ReadsResultsOfVersion1) {
  const Program program;
  const std::string file =
      (SourceFolder() / "tests" / "golden" / "results" / "version1.h5").string();
  const Finished shown = program.Run({"show", file, "--all"});
  EXPECT_EQ(shown.status, 0) << shown.err;
  for (const char* part :
       {"4 runs (2 values of load x 2 of hz)", "Omitted in all 4 runs: solver", "calm", "storm"})
    EXPECT_NE(shown.out.find(part), std::string::npos) << part << " in:\n" << shown.out;
  const Finished errors = program.Run({"show", file, "--error", "position"});
  EXPECT_EQ(errors.status, 0) << errors.err;
  EXPECT_NE(errors.out.find("storm"), std::string::npos) << errors.out;
}

TEST(Show, SaysWhatRunsDidWithout) {
  const std::string none = Shown([](std::size_t, std::size_t, results::RunResult&) {});
  EXPECT_EQ(none.find("Omitted"), std::string::npos) << none;
  const std::string silent = Shown([](std::size_t, std::size_t, results::RunResult& result) {
    result.omitted = "swept_contacts motion_states pools a_part_of_tomorrow";
  });
  EXPECT_EQ(silent.find("Omitted"), std::string::npos) << "it changes no figure:\n" << silent;

  const std::string some = Shown([](std::size_t detector, std::size_t, results::RunResult& result) {
    result.omitted = detector == 0 ? "walls raycast_tree solver pools" : "walls solver";
  });
  EXPECT_NE(
      some.find(
          "\n  Omitted in all 4 runs: walls (pairs and the broad phase exclude them), solver "
          "(solve only applies forces to velocities).\n  Omitted in 2 of 4 runs: raycast_tree (the "
          "broad phase has no tree for ray casts). omit none times everything.\n"),
      std::string::npos)
      << some;
}

TEST(Show, SaysWhereDetectorsDidNotOmitTheSame) {
  const auto shown = [](const char* of_sap, const char* of_dbvt) {
    return Shown([&](std::size_t detector, std::size_t quantity, results::RunResult& result) {
      const std::string decision = detector == 0 ? of_sap : quantity == 0 ? of_dbvt : of_sap;
      if (decision == "left out") result.omitted = "walls";
      result.decisions = "gravity: kept: always\nwalls: " + decision + ": a test\n";
    });
  };
  const std::string line =
      "\nAt 1 of 2 points, some detectors ran without walls and others with it: ";
  EXPECT_NE(shown("left out", "kept").find(line), std::string::npos);
  EXPECT_NE(shown("kept", "left out").find(line), std::string::npos);
  // If there are no walls, none were left out.
  EXPECT_EQ(shown("left out", "none").find("points, some"), std::string::npos);
  EXPECT_EQ(shown("left out", "left out").find("points, some"), std::string::npos);
  EXPECT_EQ(shown("kept", "kept").find("points, some"), std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
