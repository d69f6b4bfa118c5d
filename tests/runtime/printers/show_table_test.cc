// One table for a paper (`cdb show --table`).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "runtime/printers/results_document.h"
#include "runtime/printers/show.h"
#include "tests/runtime/figures/made_up_file.h"
#include "tests/runtime/printers/generated_results.h"

namespace cdb::tests {
namespace {

using printers::MeasuredText;

TEST(MeasuredText, HasTheDigitsThatTheIntervalJustifies) {
  EXPECT_EQ(MeasuredText(146.234, {145.1, 147.93}), "146.2 [145.1, 147.9]");
  EXPECT_EQ(MeasuredText(146.234, {141.1, 151.1}), "146 [141, 151]");
  EXPECT_EQ(MeasuredText(1496.2, {1380, 1610}), "1500 [1380, 1610]");
  EXPECT_EQ(MeasuredText(0.98765, {0.9870, 0.9880}), "0.9877 [0.9870, 0.9880]");
  // At least two digits, and at most six.
  EXPECT_EQ(MeasuredText(147.2, {146.1, 950}), "150 [150, 950]");
  EXPECT_EQ(MeasuredText(147.23456789, {147.23456788, 147.2345679}), "147.235 [147.235, 147.235]");
  EXPECT_EQ(MeasuredText(1.234e-6, {1.19e-6, 1.28e-6}), "1.23e-06 [1.19e-06, 1.28e-06]");
  EXPECT_EQ(MeasuredText(9.97e-5, {9.5e-5, 1.04e-4}), "1.00e-04 [9.5e-05, 1.04e-04]");
}

TEST(MeasuredText, HasThreeDigitsWithoutAnInterval) {
  EXPECT_EQ(MeasuredText(146.234, {NAN, NAN}), "146");
  EXPECT_EQ(MeasuredText(146.234, {146.234, 146.234}), "146 [146, 146]");
  EXPECT_EQ(MeasuredText(NAN, {NAN, NAN}), "-");
}

/// Of three detectors at two numbers of objects, `dbvt` is unsound at the larger one, and `sap` is
/// missing there.
MadeUp CrowdTimes(const plan::Run& run) {
  const double ns = (run.at[0] == 0 ? 2000.0 : 8000.0) / (run.at[1] == 0 ? 1 : 2);
  MadeUp made = {.ns = ns * (1 + 0.01 * static_cast<double>(run.rep))};
  if (run.at[0] == 1 && run.at[1] == 1) made.verdict = protocol::Verdict::kTunnelled;
  if (run.at[0] == 1 && run.at[1] == 2) made.status = results::Status::kMissing;
  return made;
}

plan::Plan CrowdPlan() {
  return MakePlan({NumberAxis("n", {10, 200}), TextAxis("detector", {"simple", "dbvt", "sap"})}, 5,
                  {.cycles = kMadeUpCycles, .record = {"timing"}});
}

template <typename Use>
auto WithCrowd(Use use) {
  return WithMadeUpFile(CrowdPlan(), CrowdTimes, use);
}

std::string Shown(const printers::ShowTableOptions& options) {
  return WithCrowd(
      [&](const results::ResultFile& file) { return printers::ShowTable(file, options).text; });
}

/// Up to the caveats that `show` has as well.
std::string TableOf(const printers::ShowTableOptions& options) {
  const std::string text = Shown(options);
  return text.substr(0, text.find("\n\n"));
}

TEST(ShowTable, HasAColumnForEachDetectorAndItsSpeedUp) {
  EXPECT_EQ(TableOf({.metric = "step", .baseline = "simple"}), R"(A plan for tests – µ
                                 step, us                                      speed-up over simple
    n             simple                  dbvt                   sap                 dbvt                sap
  ----------------------------------------------------------------------------------------------------------
   10  2.04 [2.00, 2.08]  1.020 [1.000, 1.040]  1.020 [1.000, 1.040]    2.00 [2.00, 2.00]  2.00 [2.00, 2.00]
  200  8.16 [8.00, 8.32]   4.08 [4.00, 4.16] *                     -  2.00 [2.00, 2.00] *                  -
  Median over 5 repeats per cycle, then mean over cycles.
  In brackets: 95 % interval, by bootstrap over the 5 repeats, whole runs at a time.
  * tunnelled: n 200, detector dbvt)");
}

TEST(ShowTable, HasTheGroupsOfItsColumnsInLatex) {
  EXPECT_EQ(TableOf({.metric = "step", .baseline = "simple", .format = printers::Format::kLatex}),
            R"(% A plan for tests – µ
\begin{tabular}{rrrrrr}
\toprule
 & \multicolumn{3}{c}{step, µs} & \multicolumn{2}{c}{speed-up over simple} \\
\cmidrule(lr){2-4}
\cmidrule(lr){5-6}
n & simple & dbvt & sap & dbvt & sap \\
\midrule
10 & 2.04 [2.00, 2.08] & 1.020 [1.000, 1.040] & 1.020 [1.000, 1.040] & 2.00 [2.00, 2.00] & 2.00 [2.00, 2.00] \\
200 & 8.16 [8.00, 8.32] & 4.08 [4.00, 4.16] * & - & 2.00 [2.00, 2.00] * & - \\
\bottomrule
\end{tabular}
% Median over 5 repeats per cycle, then mean over cycles.
% In brackets: 95 % interval, by bootstrap over the 5 repeats, whole runs at a time.
% * tunnelled: n 200, detector dbvt)");
}

TEST(ShowTable, NamesTheGroupOfEachColumnInMarkdown) {
  const std::string text =
      Shown({.metric = "step", .baseline = "simple", .format = printers::Format::kMarkdown});
  EXPECT_NE(text.find("| n | simple (step, µs) | dbvt (step, µs) | sap (step, µs) | dbvt (speed-up "
                      "over simple) | sap (speed-up over simple) |\n"),
            std::string::npos)
      << text;
}

TEST(ShowTable, TakesOtherAxesAndFigures) {
  EXPECT_EQ(TableOf({.metric = "peak_rss", .by = {"detector"}}), R"(A plan for tests – µ
            peak rss, MB
  detector  n 10   n 200
  ----------------------
  simple    5.00    5.00
  dbvt      5.00  5.00 *
  sap       5.00       -
  The largest of the repeats.
  * tunnelled: detector dbvt, n 200)");
}

TEST(ShowTable, RefusesWhatIsNotInTheFile) {
  WithCrowd([](const results::ResultFile& file) {
    const auto error_of = [&](const printers::ShowTableOptions& options) -> std::string {
      try {
        printers::ShowTable(file, options);
      } catch (const files::StoreError& error) {
        return error.what();
      }
      return "none";
    };
    EXPECT_EQ(error_of({.metric = "energy"}),
              "--table takes a figure of the file, not 'energy'; there are broad, narrow, detect, "
              "solve, integrate, step, ms_per_s, peak_rss");
    EXPECT_EQ(error_of({.metric = "step", .baseline = "sap32"}),
              "the axis 'detector' of the columns has no value 'sap32'; it has simple, dbvt, sap");
    EXPECT_EQ(error_of({.metric = "step", .by = {"n"}, .columns = "n"}),
              "--by and --columns both name the axis 'n'");
    EXPECT_EQ(error_of({.metric = "peak_rss", .baseline = "simple"}),
              "--baseline is for times, of which there is a speed-up; peak_rss is none");
  });
}

using Strings = std::vector<std::string>;

Strings FieldsOf(const std::string& text, const std::string& by) {
  Strings parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(by, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == text.npos) return parts;
    begin = end + by.size();
  }
}

struct Shot {
  double value = NAN, low = NAN, high = NAN;
};

/// The step at each point, in ns, by the values on the axes `detector`, `x` and `case`.
std::map<Strings, Shot> InCsv(const std::string& csv) {
  std::map<Strings, Shot> found;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const Strings heads = FieldsOf(line, ",");
  while (std::getline(lines, line)) {
    std::map<std::string, std::string> cell;
    const Strings cells = FieldsOf(line, ",");
    for (std::size_t i = 0; i < heads.size(); ++i) cell[heads[i]] = cells[i];
    const auto number = [&](const char* head) {
      return cell[head].empty() ? NAN : std::atof(cell[head].c_str());
    };
    found[{cell["detector"], cell["x"], cell["case"]}] = {
        number("step_mean_ns"), number("step_low_ns"), number("step_high_ns")};
  }
  return found;
}

/// `1.23` and the unit of its last digit.
std::pair<double, double> RoundedIn(const std::string& text) {
  if (text.empty() || text == "-") return {NAN, NAN};
  const std::size_t dot = text.find('.');
  double unit = dot == text.npos ? 1 : std::pow(10, -static_cast<double>(text.size() - dot - 1));
  if (dot == text.npos)
    for (std::size_t i = text.size(); i-- > 1 && text[i] == '0';) unit *= 10;
  return {std::atof(text.c_str()), unit};
}

void ExpectSame(double exact, double scale, const std::string& text, const std::string& place) {
  const auto [rounded, unit] = RoundedIn(text);
  EXPECT_EQ(std::isnan(exact), std::isnan(rounded)) << place << ": " << exact << ", " << text;
  if (!std::isnan(exact)) {
    EXPECT_NEAR(exact / scale, rounded, 0.501 * unit) << place << ": " << text;
  }
}

/// Every time of `csv` is in the table, to its last digit.
void CompareTable(const std::string& markdown, std::map<Strings, Shot> csv) {
  Strings heads;
  double scale = 1;
  std::istringstream lines(markdown);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| ") || line.starts_with("| -")) continue;
    std::erase(line, '\\');
    Strings cells = FieldsOf(line.substr(2, line.size() - 4), " | ");
    if (heads.empty()) {
      heads = cells;
      scale = line.find("µs") != line.npos ? 1e3 : line.find("ms)") != line.npos ? 1e6 : 1;
      continue;
    }
    std::map<std::string, std::string> at;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::size_t group = heads[i].find(" (step");
      if (group == std::string::npos && !heads[i].starts_with("step")) {
        at[heads[i]] = cells[i];
        continue;
      }
      const std::string head = heads[i].substr(0, group);
      auto here = at;
      if (head.starts_with("x "))
        here["x"] = head.substr(2);
      else if (head == "calm" || head == "storm")
        here["case"] = head;
      else if (!head.starts_with("step"))
        here["detector"] = head;
      if (here["detector"].empty()) here["detector"] = "dbvt";
      const Strings key = {here["detector"], here["x"], here["case"]};
      const auto found = csv.find(key);
      std::string text = cells[i];
      if (text.ends_with(" *")) text.resize(text.size() - 2);
      const std::string place = key[0] + " " + key[1] + " " + key[2];
      if (found == csv.end()) {
        EXPECT_EQ(text, "-") << place;
        continue;
      }
      const Strings parts = FieldsOf(text, " [");
      ExpectSame(found->second.value, scale, parts[0], place);
      const Strings ends = parts.size() > 1
                               ? FieldsOf(parts[1].substr(0, parts[1].size() - 1), ", ")
                               : Strings{"-", "-"};
      ExpectSame(found->second.low, scale, ends[0], place);
      ExpectSame(found->second.high, scale, ends[1], place);
      csv.erase(found);
    }
  }
  for (const auto& [key, shot] : csv)
    EXPECT_TRUE(std::isnan(shot.value)) << "not in the table: " << key[0] << " " << key[1];
}

TEST(ShowTable, HasTheTimesOfTheCsv) {
  for (unsigned seed = 0; seed < 10 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const Generated generated(seed);
    WithMadeUpFile(
        generated.plan(), [&](const plan::Run& run) { return generated.Of(run); },
        [&](const results::ResultFile& file) {
          CompareTable(
              printers::ShowTable(file, {.metric = "step", .format = printers::Format::kMarkdown})
                  .text,
              InCsv(printers::CsvText(file, {}).text));
        });
  }
}

}  // namespace
}  // namespace cdb::tests
