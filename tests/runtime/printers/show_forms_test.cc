// Other outputs of `cdb show` than its tables: CSV, parts of a file, other statistics, plots.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "runtime/figures/points.h"
#include "runtime/printers/results_document.h"
#include "runtime/printers/show.h"
#include "tests/runtime/figures/made_up_file.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

/// 1000 ns in the first detector and 1200 in the second, times 1, 2, 3 along the axis; the first
/// cycle takes 400 ns more.
MadeUp FormTimes(const plan::Run& run) {
  return {.ns = 1000.0 * static_cast<double>(run.at[1] + 1) * (run.at[0] == 0 ? 1 : 1.2),
          .stall = 400};
}

plan::Plan FormPlan(std::uint64_t repeats = 1) {
  return MakePlan({TextAxis("detector", {"a,b", "dbvt"}), NumberAxis("x", {0.5, 2, 30})}, repeats,
                  {.cycles = kMadeUpCycles, .record = {"timing"}});
}

template <typename Use>
auto WithForm(const std::vector<std::string>& selections, Use use) {
  return WithMadeUpFile(FormPlan(), FormTimes, [&](results::ResultFile file) {
    figures::SelectPart(file, selections);
    return use(file);
  });
}

std::string CsvOf(const std::vector<std::string>& selections, figures::CycleStatistic statistic) {
  return WithForm(selections, [&](const results::ResultFile& file) {
    return printers::CsvText(file, {{protocol::Phase::kStep}, statistic}).text;
  });
}

TEST(Csv, QuotesFields) {
  EXPECT_EQ(printers::CsvField("plain text"), "plain text");
  EXPECT_EQ(printers::CsvField("a,b"), "\"a,b\"");
  EXPECT_EQ(printers::CsvField("say \"it\""), "\"say \"\"it\"\"\"");
  EXPECT_EQ(printers::CsvField("two\nlines"), "\"two\nlines\"");
}

TEST(Csv, HasALineForEachPoint) {
  EXPECT_EQ(CsvOf({}, figures::CycleStatistic::kMean),
            "detector,x,verdict,mark,repeats,step_mean_ns,step_low_ns,step_high_ns,peak_rss_bytes\n"
            "\"a,b\",0.5,stable,,1,1100,,,5e+06\n"
            "\"a,b\",2,stable,,1,2100,,,5e+06\n"
            "\"a,b\",30,stable,,1,3100,,,5e+06\n"
            "dbvt,0.5,stable,,1,1300,,,5e+06\n"
            "dbvt,2,stable,,1,2500,,,5e+06\n"
            "dbvt,30,stable,,1,3700,,,5e+06\n");
}

TEST(Csv, HasTheWorstVerdictOfTheRepeatsThatRan) {
  const std::string csv = WithMadeUpFile(
      FormPlan(3),
      [](const plan::Run& run) {
        MadeUp made = FormTimes(run);
        if (run.rep == 2 || run.at[1] == 0) made.status = results::Status::kMissing;
        if (run.at[1] == 2) made.verdict = protocol::Verdict::kTunnelled;
        return made;
      },
      [](const results::ResultFile& file) {
        return printers::CsvText(file, {{protocol::Phase::kStep}}).text;
      });
  EXPECT_NE(csv.find("\n\"a,b\",2,stable,,2,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\ndbvt,30,tunnelled,,2,"), std::string::npos) << csv;
  EXPECT_EQ(csv.find("missing"), std::string::npos) << csv;
}

TEST(Csv, HasTheStatisticThatIsAskedFor) {
  const auto first = [](figures::CycleStatistic statistic) {
    const std::string text = CsvOf({"x=0.5", "detector=dbvt"}, statistic);
    return text.substr(text.find('\n') + 1);
  };
  EXPECT_EQ(first(figures::CycleStatistic::kMedian), "dbvt,0.5,stable,,1,1200,,,5e+06\n");
  EXPECT_EQ(first(figures::CycleStatistic::kMax), "dbvt,0.5,stable,,1,1600,,,5e+06\n");
  EXPECT_EQ(first(figures::CycleStatistic::kMin), "dbvt,0.5,stable,,1,1200,,,5e+06\n");
  EXPECT_EQ(first(figures::CycleStatistic::kP95), "dbvt,0.5,stable,,1,1540,,,5e+06\n");
}

TEST(CycleStatistic, HasTheWorstCycleOfAnyRepeat) {
  const figures::Bootstrap bootstrap(5);
  const std::vector<std::vector<double>> repeats = {{1, 2}, {1, 2}, {1, 90}, {1, 2}, {1, 2}};
  EXPECT_EQ(figures::TimesOver(repeats, bootstrap, figures::CycleStatistic::kMax).other.value, 2);
  const figures::Estimate worst =
      figures::TimesOver(repeats, bootstrap, figures::CycleStatistic::kWorst).other;
  EXPECT_EQ(worst.value, 90);
  EXPECT_EQ(bootstrap.IntervalOf(worst).high, 90);
  EXPECT_EQ(bootstrap.IntervalOf(worst).low, 2);
}

TEST(Select, TakesValuesListsAndRanges) {
  const auto points = [](const std::vector<std::string>& selections) {
    const std::string text = CsvOf(selections, figures::CycleStatistic::kMean);
    std::string places;
    for (std::size_t at = text.find('\n') + 1; at < text.size(); at = text.find('\n', at) + 1)
      places += text.substr(at, text.find(",stable", at) - at) + " ";
    return places;
  };
  EXPECT_EQ(points({"x=2"}), "\"a,b\",2 dbvt,2 ");
  EXPECT_EQ(points({"x=2,30", "detector=dbvt"}), "dbvt,2 dbvt,30 ");
  EXPECT_EQ(points({"x=0.5..2", "detector=dbvt"}), "dbvt,0.5 dbvt,2 ");
  EXPECT_EQ(points({"x=30,0.5", "detector=dbvt"}), "dbvt,0.5 dbvt,30 ");
}

TEST(Select, NamesAxesAndValuesOfTheFile) {
  const auto error_of = [](const std::vector<std::string>& selections) -> std::string {
    try {
      CsvOf(selections, figures::CycleStatistic::kMean);
    } catch (const files::StoreError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(error_of({"y=1"}), "there is no axis 'y'; there are detector, x");
  EXPECT_EQ(error_of({"x=7"}), "the axis 'x' has no value 7; it has 0.5, 2, 30");
  EXPECT_EQ(error_of({"x=3..9"}), "the axis 'x' has no value 3..9; it has 0.5, 2, 30");
  EXPECT_EQ(error_of({"x"}), "'x' selects nothing; write AXIS=VALUE, such as detector=dbvt");
  EXPECT_EQ(error_of({"x=2", "x=30"}),
            "--select names the axis 'x' twice: list its values in one, as x=A,B");
}

TEST(Select, ReadsTheValuesOfTheWholeFile) {
  WithMadeUpFile(FormPlan(2), FormTimes, [&](results::ResultFile file) {
    const auto duration = file.ReadDuration(protocol::Phase::kStep, {{1, 2}, 1});
    const double host_number = file.ReadReal("load_average", {{1, 2}, 1});
    figures::SelectPart(file, {"detector=dbvt"});
    figures::SelectPart(file, {"x=2,30"});
    EXPECT_EQ(file.ReadDuration(protocol::Phase::kStep, {{0, 1}, 1}), duration);
    EXPECT_EQ(file.ReadReal("load_average", {{0, 1}, 1}), host_number);
    EXPECT_EQ(file.SelectedPoint({1, 2}), (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(file.SelectedPoint({0, 2}), std::nullopt);
    return 0;
  });
}

TEST(Select, MakesTablesOfThePart) {
  const std::string text =
      WithForm({"x=2"}, [](const results::ResultFile& file) { return printers::Show(file).text; });
  EXPECT_NE(text.find("2 runs (2 values of detector x 1 of x), 4 cycles"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("3.10"), std::string::npos) << text;
}

TEST(Show, HasOnlyThePhasesAndTheStatisticThatAreAskedFor) {
  const std::string text = WithForm({}, [](const results::ResultFile& file) {
    return printers::Show(file, {.phases = {protocol::Phase::kSolve},
                                 .statistic = figures::CycleStatistic::kMax})
        .text;
  });
  EXPECT_NE(text.find("\nMaximum of a cycle, us\n  detector    x  solve\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("\n  a,b       0.5   1.40\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n  Max over cycles; no interval: one repeat.\n"), std::string::npos);
  EXPECT_NE(text.find("\nMaximum solve over that of a,b"), std::string::npos);
  EXPECT_EQ(text.find("broad"), std::string::npos);
}

TEST(Sparkline, IsAveragedInBins) {
  EXPECT_EQ(printers::Sparkline({0, 7}, 10), "\u2581\u2588");
  EXPECT_EQ(printers::Sparkline({0, 0, 7, 7}, 2), "\u2581\u2588");
  EXPECT_EQ(printers::Sparkline({1, 1}, 10), "\u2581\u2581");
  EXPECT_EQ(printers::Sparkline({}, 10), "");
}

TEST(Show, PlotsTimesOverCyclesAndOverNumbers) {
  const std::string text = WithForm({}, [](const results::ResultFile& file) {
    return printers::Show(file, {.plots = true}).text;
  });
  EXPECT_NE(text.find("\n  dbvt        2  \u2588\u2581\u2581\u2581             2.40 us  2.80 us\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("\nMean step over x, ns: a a,b, b dbvt\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nMean step over x, ns: a a,b, b dbvt\n"), std::string::npos) << text;
}

TEST(ShowCommand, RefusesWhatDoesNotGoTogether) {
  const Program program;
  const auto error_of = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"show", "no.h5"});
    const Finished shown = program.Run(arguments);
    EXPECT_EQ(shown.status, 2);
    return shown.err;
  };
  EXPECT_EQ(error_of({"--csv", "--json"}), "cdb: choose either --json or --csv\n");
  EXPECT_EQ(error_of({"--json", "--stat", "p95"}),
            "cdb: --json has all statistics; --stat is for tables and --csv\n");
  EXPECT_EQ(error_of({"--csv", "--plot"}), "cdb: --csv has no plots; remove --plot\n");
  EXPECT_EQ(error_of({"--error", "position", "--stat", "max"}),
            "cdb: --stat is for a summary; --error uses the mean, as a simulated second consists "
            "of all of its cycles\n");
}

}  // namespace
}  // namespace cdb::tests
