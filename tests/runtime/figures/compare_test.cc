// Comparisons of results files whose times, states, verdicts and errors are made up.
#include "runtime/figures/compare.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/printers/compare.h"
#include "runtime/printers/show.h"
#include "tests/runtime/figures/compared_results.h"
#include "tests/support/compile_text.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using figures::ChangeVerdict;
using figures::CompareOptions;

/// Results in files a.h5, b.h5, ….
class ComparedFiles {
 public:
  explicit ComparedFiles(const std::vector<ComparedResult>& results) {
    for (const ComparedResult& result : results) {
      const auto letter = static_cast<char>('a' + paths_.size());
      paths_.push_back(folder_ / (std::string(1, letter) + ".h5"));
      WriteCompared(result, paths_.back());
    }
  }
  const std::vector<std::filesystem::path>& paths() const { return paths_; }

 private:
  const TemporaryFolder folder_;
  std::vector<std::filesystem::path> paths_;
};

/// The detector sap is 5 % slower in the second file. Written for the first test that needs it.
std::shared_ptr<const ComparedFiles> SlowerSap() {
  static const auto files = std::make_shared<const ComparedFiles>(std::vector<ComparedResult>{
      {ComparedPlan(6)}, {.plan = ComparedPlan(6), .change = Slower(2, 1.05), .seed = 2}});
  return files;
}

/// The comparison of the files of one command.
class Compared {
 public:
  explicit Compared(std::shared_ptr<const ComparedFiles> written, CompareOptions options = {},
                    bool is_reversed = false)
      : written_(std::move(written)), options_(std::move(options)) {
    std::vector<std::filesystem::path> paths = written_->paths();
    if (is_reversed) std::ranges::reverse(paths);
    std::vector<std::string> names;
    for (const std::filesystem::path& path : paths) names.push_back(path.filename().string());
    all_.names = names;
    all_.benchmarks.push_back(figures::MakeHistory(paths, names, options_));
    figures::JudgeHistories(all_.benchmarks, options_);
  }
  explicit Compared(const std::vector<ComparedResult>& results, CompareOptions options = {})
      : Compared(std::make_shared<const ComparedFiles>(results), std::move(options)) {}
  const figures::Comparisons& all() const { return all_; }
  const figures::FileComparison& comparison() const { return all_.benchmarks[0].steps[0]; }
  const CompareOptions& options() const { return options_; }
  printers::Document document() const { return printers::CompareDocument(comparison(), options_); }
  std::string Text() const { return printers::TextOf(document(), printers::Format::kWrapped); }
  bool IsWorse() const { return figures::IsFailed(comparison(), options_); }
  std::string Headline() const { return printers::Headline(all_, options_); }
  /// The change of a group, in the phase step.
  const figures::TimeChange& Group(const std::string& name) const {
    for (const figures::TimedGroup& group : comparison().times.groups)
      if (group.name == name) return group.phases.back();
    throw std::runtime_error("no group " + name);
  }

 private:
  const std::shared_ptr<const ComparedFiles> written_;
  const CompareOptions options_;
  figures::Comparisons all_;
};

/// The text with single spaces and joined lines.
std::string Words(const std::string& text) {
  std::string words;
  for (const char c : text) {
    const char space = c == '\n' ? ' ' : c;
    if (space != ' ' || !words.ends_with(' ')) words += space;
  }
  return words;
}
void ExpectSays(const std::string& text, const std::string& part) {
  EXPECT_NE(Words(text).find(Words(part)), std::string::npos) << part << "\nis not in\n" << text;
}
void ExpectSaysNot(const std::string& text, const std::string& part) {
  EXPECT_EQ(Words(text).find(Words(part)), std::string::npos) << part << "\nis in\n" << text;
}
std::string RefusalOf(const std::vector<ComparedResult>& results, CompareOptions options = {}) {
  try {
    Compared compared(results, std::move(options));
  } catch (const files::StoreError& error) {
    return error.what();
  }
  return "";
}

TEST(Compare, FindsOneSlowerDetectorAndNothingElse) {
  const Compared compared(SlowerSap());
  EXPECT_EQ(compared.Group("sap").absolute.verdict, ChangeVerdict::kSlower);
  EXPECT_NEAR(compared.Group("sap").absolute.tested.ratio, 1.05, 0.01);
  EXPECT_NEAR(compared.Group("sap").relative.tested.ratio, 1.05, 0.01);
  for (const char* name : {"simple", "dbvt", "grid"})
    EXPECT_EQ(compared.Group(name).absolute.verdict, ChangeVerdict::kSame) << name;
  const std::string text = compared.Text();
  ExpectSays(text, "The same machine, versions and kind of build");
  ExpectSays(text, "8 points in both files");
  ExpectSays(text, "SLOWER: sap: broad +");
  ExpectSaysNot(text, "FASTER");
  ExpectSaysNot(text, "EVERYTHING");
  ExpectSays(text, "Physics: the same last state at 8 of 8 points, to the last bit");
  ExpectSays(text, "Unchanged: verdicts, position error, missed pairs, ");
  // The interval includes changes below 5 %.
  EXPECT_FALSE(compared.IsWorse());
  ExpectSays(text, "PASS: nothing is significantly worse by more than 5 %");
}

TEST(Compare, FailsWhereTheWholeIntervalIsAbove) {
  const Compared slower(SlowerSap(), {.gate = figures::Gate(0.03)});
  EXPECT_TRUE(slower.IsWorse());
  ExpectSays(slower.Text(), "FAIL (exit status 4): slower by more than 3 %: sap broad; sap ");
  EXPECT_FALSE(Compared(SlowerSap(), {.gate = figures::Gate(0.03)}, true).IsWorse());
  ExpectSays(Compared(SlowerSap(), {}, true).Text(), "FASTER: sap: broad -4.");
}

TEST(Compare, NamesWhatAllHaveInCommon) {
  const auto machine = [](const plan::Run& run, ComparedRun& made) {
    made.factor = run.at[0] == 3 ? 1.10 * 1.05 : 1.05;
  };
  const auto files = std::make_shared<const ComparedFiles>(std::vector<ComparedResult>{
      {ComparedPlan(6)}, {.plan = ComparedPlan(6), .change = machine, .seed = 2}});
  const Compared compared(files);
  EXPECT_TRUE(compared.comparison().times.HasCommonShift());
  EXPECT_EQ(compared.Group("simple").absolute.verdict, ChangeVerdict::kSlower);
  EXPECT_EQ(compared.Group("simple").relative.verdict, ChangeVerdict::kSame);
  EXPECT_EQ(compared.Group("grid").relative.verdict, ChangeVerdict::kSlower);
  const std::string text = compared.Text();
  ExpectSays(text, "EVERYTHING is slower: the median step over all groups is +5.");
  ExpectSays(text, "the machine, or shared code; cdb's own overhead");
  const std::string relative = Compared(files, {.is_relative = true}).Text();
  ExpectSays(relative, "SLOWER: grid: broad +");
  ExpectSaysNot(relative, "SLOWER: simple");
  EXPECT_NE(RefusalOf({{ComparedPlan(6, {"10"}, {"sap"})}, {ComparedPlan(6, {"10"}, {"sap"})}},
                      {.is_relative = true})
                .find("--relative needs 3 detectors or more"),
            std::string::npos);
}

TEST(Compare, CannotTellFromOneRepeat) {
  const Compared compared(
      {{ComparedPlan(1)}, {.plan = ComparedPlan(1), .change = Slower(2, 1.5), .seed = 2}});
  EXPECT_EQ(compared.Group("sap").absolute.verdict, ChangeVerdict::kCannotTell);
  EXPECT_FALSE(compared.IsWorse());
  ExpectSays(compared.Text(),
             "Cannot tell, as there is 1 repeat, but an interval needs 5 in each file (facts below "
             "are exact): simple; dbvt; sap; grid");
}

TEST(Compare, CannotTellWhereNoiseIsLarger) {
  const Compared compared(
      {{.plan = ComparedPlan(6), .noise = 0.2},
       {.plan = ComparedPlan(6), .change = Slower(2, 1.05), .noise = 0.2, .seed = 2}});
  for (const char* name : {"simple", "dbvt", "sap", "grid"})
    EXPECT_EQ(compared.Group(name).absolute.verdict, ChangeVerdict::kCannotTell) << name;
  ExpectSays(compared.Text(), "Cannot tell, as the noise is larger than 5 %");
}

TEST(Compare, ComparesFactsExactly) {
  const auto other = [](const plan::Run& run, ComparedRun& made) {
    if (run.at != std::vector<std::size_t>{1, 1}) return;
    made.error = 0.6;
    made.missed = 2;
    made.verdict = protocol::Verdict::kTunnelled;
    made.state = "fedcba9876543210";
    made.peak_bytes = 6e6;
  };
  const std::vector<ComparedResult> results = {{ComparedPlan(2)},
                                               {.plan = ComparedPlan(2), .change = other}};
  const Compared compared(results);
  EXPECT_TRUE(compared.IsWorse());
  const std::string text = compared.Text();
  ExpectSays(text,
             "PHYSICS DIFFERS: another last state at 1 of 8 points, whose times are of another "
             "motion: detector dbvt, quantity 20");
  ExpectSays(text,
             "LESS STABLE: verdicts at 1 of 8 points: detector dbvt, quantity 20: stable -> "
             "tunnelled from cycle 3 on");
  ExpectSays(text,
             "LESS TRUE: position error at 1 of 8 points: detector dbvt, quantity 20: 0.5000 -> "
             "0.6000 (+20 %)");
  ExpectSays(text, "LESS TRUE: missed pairs at 1 of 8 points: detector dbvt, quantity 20: 0 -> 12");
  ExpectSays(text,
             "MORE MEMORY: peak memory at 1 of 8 points: detector dbvt, quantity 20: 5 MB -> 6 MB "
             "(+20 %)");
  const Compared back({results[1], results[0]});
  EXPECT_FALSE(back.IsWorse());
  ExpectSays(back.Text(), "MORE STABLE: verdicts");
  ExpectSays(back.Text(), "MORE TRUE: missed pairs");
}

TEST(Compare, TakesTheLargestPeakMemoryOfTheRepeatsAsShowDoes) {
  const auto peaks = [](double first, double second) {
    return [=](const plan::Run& run, ComparedRun& made) {
      made.peak_bytes = run.rep == 0 ? first : second;
    };
  };
  const Compared compared({{.plan = ComparedPlan(2), .change = peaks(5.8e6, 6e6)},
                           {.plan = ComparedPlan(2), .change = peaks(7e6, 6.6e6)}});
  ExpectSays(compared.Text(), "quantity 10: 6 MB -> 7 MB (+16.7 %)");
  const Compared within({{.plan = ComparedPlan(2), .change = peaks(5e6, 6e6)},
                         {.plan = ComparedPlan(2), .change = peaks(6.5e6, 6.9e6)}});
  ExpectSaysNot(within.Text(), "MORE MEMORY");
}

TEST(Compare, ComparesNoMemoryOfARunThatEndedEarly) {
  const auto late = [](const plan::Run&, ComparedRun& made) {
    made.status = results::Status::kTimedOut;
    made.peak_bytes = 3e6;
    made.missed = 1;
  };
  const std::string text =
      Compared({{ComparedPlan(2)}, {.plan = ComparedPlan(2), .change = late}}).Text();
  ExpectSays(text, "LESS STABLE: verdicts at 8 of 8 points");
  ExpectSaysNot(text, "MEMORY");
  ExpectSaysNot(text, "missed pairs at");
}

TEST(Compare, CallsAnErrorWithinItsFloorNeitherBetterNorWorse) {
  const auto other = [](const plan::Run&, ComparedRun& made) {
    made.error = 0.6;
    made.floor = 0.2;
  };
  const Compared compared({{ComparedPlan(1)}, {.plan = ComparedPlan(1), .change = other}});
  EXPECT_FALSE(compared.IsWorse());
  ExpectSaysNot(compared.Text(), "LESS TRUE");
  ExpectSays(compared.Text(), "\n  position error       0      0      8       8  ");
}

TEST(Compare, SaysThatRepeatsOfAFileDiffer) {
  const auto unsettled = [](const plan::Run& run, ComparedRun& made) {
    if (run.rep == 1) made.state = "another";
  };
  ExpectSays(Compared({{ComparedPlan(2)}, {.plan = ComparedPlan(2), .change = unsettled}}).Text(),
             "NOT REPEATABLE: repeats in one file end in different states: detector simple");
}

TEST(Compare, LeavesTimesOfUnlikeWorkOut) {
  const auto omit = [](const plan::Run& run, ComparedRun& made) {
    if (run.at[0] == 0) made.omitted = "solver";
    if (run.at[0] == 1) made.verdict = protocol::Verdict::kFrozen;
  };
  const Compared compared({{ComparedPlan(5)}, {.plan = ComparedPlan(5), .change = omit}});
  ASSERT_EQ(compared.comparison().times.groups.size(), 2u);
  const std::string text = compared.Text();
  ExpectSays(text,
             "Times not compared: detector simple, quantity 10 (one of the files omitted solver, "
             "so it did less work: run both with omit none); ");
  ExpectSays(text, "detector dbvt, quantity 10 (frozen in b.h5)");
}

TEST(Compare, MatchesPointsByTheirCoordinates) {
  const Compared compared({{ComparedPlan(1, {"10", "20"}, {"simple", "sap"})},
                           {ComparedPlan(1, {"20", "40"}, {"sap", "simple", "dbvt"})}});
  EXPECT_EQ(compared.comparison().match.points.size(), 2u);
  const std::string text = compared.Text();
  ExpectSays(text,
             "2 points in both files; 2 only in a.h5: detector simple, quantity 10; detector sap, "
             "quantity 10; 4 only in b.h5: ");
}

TEST(Compare, ComparesOnlyWhatIsSelected) {
  const std::vector<ComparedResult> results = {{ComparedPlan(1)}, {ComparedPlan(1)}};
  const Compared compared(results, {.select = {"detector=sap", "detector=grid", "quantity=10"}});
  EXPECT_EQ(compared.comparison().match.points.size(), 2u);
  EXPECT_EQ(RefusalOf(results, {.select = {"detektor=sap"}}),
            "--select: there is no axis 'detektor'; there are detector, quantity");
  EXPECT_EQ(RefusalOf(results, {.select = {"quantity=11"}}),
            "--select quantity: a.h5 has none of these values; it has 10, 20");
  EXPECT_EQ(RefusalOf(results, {.select = {"quantity"}}),
            "'quantity' selects nothing; write AXIS=VALUE, such as detector=dbvt");
}

TEST(Compare, IgnoresAnAxisOfOneValueAndRefusesOneOfSeveral) {
  const plan::Plan one = ComparedPlan(1, {"10", "20"}, {});
  ExpectSays(Compared({{one}, {ComparedPlan(1, {"10", "20"}, {"sap"})}}).Text(),
             "Axis ignored: only b.h5 has the axis detector, with the value sap");
  EXPECT_EQ(RefusalOf({{one}, {ComparedPlan(1)}}),
            "only b.h5 has the axis 'detector' (simple, dbvt, sap, grid): choose one of its "
            "values, such as --select detector=simple");
  ExpectSays(Compared({{ComparedPlan(1, {"10", "20"}, {"grid"})},
                       {ComparedPlan(1, {"10", "20"}, {"sap"})}})
                 .Text(),
             "Axis ignored: detector: grid in a.h5, sap in b.h5");
  EXPECT_NE(RefusalOf({{ComparedPlan(1, {"10", "20"})}, {ComparedPlan(1, {"30", "40"})}})
                .find("a.h5 and b.h5 have no point in common: a.h5 has detector simple, quantity "
                      "10, …; b.h5 has detector simple, quantity 30, …"),
            std::string::npos);
}

plan::Plan ReplayedPlan(const std::string& recorded) {
  const auto compiled = CompileText("benchmark replayed { trace \"crowd.trace.h5\"; record " +
                                    recorded + "\n  detector sweep(sap, grid) }");
  return compiled.plans.at(0);
}

TEST(Compare, ComparesThePairsOfDetectorsOnTraces) {
  const plan::Plan plan = ReplayedPlan("timing, pairs");
  ExpectSays(Compared({{plan}, {plan}}).Text(),
             "Pairs: the same in the last cycle at 2 of 2 points");
  const auto other = [](const plan::Run& run, ComparedRun& made) {
    if (run.at[0] == 1) made.state = "another";
  };
  const Compared exact({{plan}, {.plan = plan, .change = other}});
  ExpectSays(exact.Text(),
             "PAIRS DIFFER: other pairs in the last cycle at 1 of 2 points, whose times are of "
             "other pairs: detector grid");
  EXPECT_FALSE(exact.IsWorse());

  // Nobody knows which of the files misses some.
  const plan::Plan unchecked = ReplayedPlan("timing");
  const std::vector<ComparedResult> results = {{unchecked}, {.plan = unchecked, .change = other}};
  EXPECT_FALSE(Compared({results[0], results[0]}).IsWorse());
  const Compared failed(results);
  EXPECT_TRUE(failed.IsWorse());
  ExpectSays(failed.Text(), "Pairs not compared with exact ones, so a missed pair would not be");
  ExpectSays(failed.Headline(), "FAIL (exit status 4): replayed: other pairs: detector grid");
  figures::Gate tolerant;
  tolerant.SetFails(figures::Finding::kPairs, false);
  EXPECT_FALSE(Compared(results, {.gate = tolerant}).IsWorse());
}

TEST(Compare, ComparesOnlyStepsOnTraces) {
  const plan::Plan plan = ReplayedPlan("timing");
  const Compared compared({{plan}, {plan}});
  ASSERT_FALSE(compared.comparison().times.groups.empty());
  for (const figures::TimedGroup& group : compared.comparison().times.groups)
    EXPECT_EQ(group.phases.size(), 1u) << group.name;
}

TEST(Compare, SaysThatBenchmarksDiffer) {
  plan::Plan other = ComparedPlan(1, {"30"});
  other.benchmark = "another";
  EXPECT_EQ(RefusalOf({{ComparedPlan(1, {"10", "20"})}, {other}})
                .find("a.h5 has the benchmark 'fixture', but b.h5 has 'another': a.h5 and b.h5 "
                      "have no point in common"),
            0u);
}

TEST(Compare, RefusesUnlikeScenes) {
  const plan::Plan other =
      ComparedPlan(1, {"10", "20"}, {"simple", "dbvt", "sap", "grid"}, "warmup 7");
  EXPECT_EQ(RefusalOf({{ComparedPlan(1)}, {other}}),
            "a.h5 and b.h5 have different scenes: warmup (0 in a.h5, 7 in b.h5)");
  figures::Gate gate;
  gate.SetFails(figures::Finding::kScenes, false);
  const Compared allowed({{ComparedPlan(1)}, {other}}, {.gate = gate});
  EXPECT_FALSE(allowed.IsWorse());
  ExpectSays(allowed.Text(), "\n  warmup   0     7\n");
  ExpectSays(allowed.Text(), "Does not fail (--allow scenes): other scenes: warmup");
}

TEST(Compare, WritesDifferencesOfScenesAsAScenarioDoes) {
  const std::vector<std::string> sizes = {"10"}, detectors = {"sap", "dbvt"};
  const std::string why = RefusalOf({{ComparedPlan(1, sizes, detectors, "timestep 1/30")},
                                     {ComparedPlan(1, sizes, detectors, "seed 1")}});
  EXPECT_EQ(why,
            "a.h5 and b.h5 have different scenes: seed (0xAAAAAAAAAA in a.h5, 1 in b.h5); timestep "
            "(1/30 in a.h5, 1/60 in b.h5)");
}

TEST(Compare, FailsByTheFindingsOfTheGate) {
  const auto other = [](const plan::Run& run, ComparedRun& made) {
    if (run.at[1] == 1) made.state = "fedcba9876543210";
  };
  const std::vector<ComparedResult> results = {{ComparedPlan(2)},
                                               {.plan = ComparedPlan(2), .change = other}};
  const Compared by_default(results);
  EXPECT_FALSE(by_default.IsWorse());
  ExpectSays(by_default.Text(),
             "Does not fail (unless --fail-if physics): other physics: detector");
  EXPECT_NE(by_default.Headline().find("PASS: nothing is significantly worse by more than 5 %; "
                                       "other physics: fixture; cannot tell: fixture"),
            std::string::npos)
      << by_default.Headline();
  figures::Gate gate;
  gate.SetFails(figures::Finding::kPhysics, true);
  EXPECT_TRUE(Compared(results, {.gate = gate}).IsWorse());
  // 2 repeats are too few for an interval.
  figures::Gate sure;
  sure.SetFails(figures::Finding::kUnsure, true);
  EXPECT_TRUE(Compared({results[0], results[0]}, {.gate = sure}).IsWorse());

  const auto larger = [](const plan::Run&, ComparedRun& made) { made.peak_bytes *= 1.08; };
  const std::vector<ComparedResult> memory = {{ComparedPlan(2)},
                                              {.plan = ComparedPlan(2), .change = larger}};
  EXPECT_TRUE(Compared(memory).IsWorse());
  figures::Gate tolerant;
  tolerant.SetLimit(figures::Finding::kMemory, 0.1);
  EXPECT_FALSE(Compared(memory, {.gate = tolerant}).IsWorse());
}

TEST(Compare, FailsIfTheSecondFileLacksAPoint) {
  const ComparedResult two = {ComparedPlan(1, {"10", "20"}, {"sap"})},
                       one = {ComparedPlan(1, {"10"}, {"sap"})};
  EXPECT_TRUE(Compared({two, one}).IsWorse());
  EXPECT_FALSE(Compared({one, two}).IsWorse());
}

TEST(Compare, DoesNotFailByTheMachineIfRunsWereNotInterleaved) {
  const auto later = [](double factor) {
    return Compared({{ComparedPlan(6)},
                     {.plan = ComparedPlan(6), .change = Slower(2, factor), .started = 3600}});
  };
  const Compared drift = later(1.2);
  EXPECT_FALSE(drift.IsWorse());
  ExpectSays(drift.Text(), "SLOWER, but the runs were not interleaved: sap: broad +20");
  ExpectSays(drift.Headline(), "cannot tell: fixture (the runs were not interleaved)");
  EXPECT_TRUE(later(1.8).IsWorse());
}

TEST(Compare, SaysHowManyRepeatsWouldTell) {
  const Compared compared({{.plan = ComparedPlan(6), .noise = 0.1},
                           {.plan = ComparedPlan(6), .noise = 0.1, .seed = 2}});
  ExpectSays(compared.Text(), " repeats would tell, in place of 6: ");
}

TEST(Compare, SaysFirstWhatDiffers) {
  const plan::Plan precise =
      ComparedPlan(5, {"10", "20"}, {"simple", "dbvt", "sap", "grid"}, "precision double");
  const Compared compared(
      {{ComparedPlan(5)},
       {.plan = precise,
        .provenance = {{"build_type", "Debug"}, {"cpu", "another"}, {"compiler", "GNU 14"}},
        .started = 3600}});
  const std::string text = compared.Text();
  ExpectSays(text, "\n  differs    a.h5           b.h5\n");
  ExpectSays(text, "\n  build      Release        Debug\n");
  ExpectSays(text, "\n  CPU        a µ-processor  another\n");
  ExpectSays(text, "\n  precision  single         double\n");
  ExpectSays(text, "b.h5 was timed with a Debug build of cdb: do not quote its timings");
  ExpectSays(text, "b.h5 ran after a.h5, 60 min later: a change of the machine in between");
  EXPECT_LT(text.find("Debug"), text.find("Result"));
}

TEST(Compare, PrintsMarkdownAndJson) {
  const Compared compared(SlowerSap(), {.phase = protocol::Phase::kStep});
  const std::string markdown = printers::TextOf(compared.document(), printers::Format::kMarkdown);
  EXPECT_NE(markdown.find("\n- SLOWER: sap: step +"), std::string::npos) << markdown;
  EXPECT_NE(markdown.find("\n| detector | points | phase | a.h5 | b.h5 | ratio | 95 % interval | "
                          "verdict |\n| --- | ---: | --- | ---: | ---: | ---: | ---: | --- |\n"),
            std::string::npos)
      << markdown;
  const auto json =
      nlohmann::json::parse(printers::CompareJson(compared.all(), compared.options()));
  EXPECT_FALSE(json["is_worse"]);
  const auto& comparison = json["benchmarks"][0]["comparisons"][0];
  EXPECT_EQ(comparison["states"]["same"], 8);
  const auto& sap = comparison["times"]["groups"][2];
  EXPECT_EQ(sap["name"], "sap");
  EXPECT_EQ(sap["phases"][0]["verdict"], "slower");
  EXPECT_NEAR(sap["phases"][0]["ratio"].get<double>(), 1.05, 0.01);
  EXPECT_LT(sap["phases"][0]["interval"][0].get<double>(), sap["phases"][0]["ratio"]);
}

TEST(Compare, ShowsAHistoryWithItsSteps) {
  std::vector<ComparedResult> results;
  for (std::uint64_t i = 0; i < 4; ++i)
    results.push_back({.plan = ComparedPlan(6),
                       .change = i >= 2 ? Slower(2, 1.08) : ComparedResult().change,
                       .seed = i + 1});
  const Compared compared(results, {.phase = protocol::Phase::kStep});
  const std::string text = printers::TextOf(
      printers::HistoryDocument(compared.all(), compared.options()), printers::Format::kWrapped);
  ExpectSays(text, "From file to file The same machine, versions and facts");
  ExpectSays(text, "fixture sap 1.000 0.9995 1.079 1.080 ▁▁██ c.h5 +8.0 %");
  ExpectSays(text, "SLOWER: fixture, from b.h5 to c.h5: sap +8.0 % (+7.6 .. +8.4 %)");
  ExpectSays(text, "▄▄▄▄ none");
  ExpectSays(text,
             "The last file relative to the first: FAIL (exit status 4): fixture: slower by more "
             "than 5 %: sap step");
  EXPECT_EQ(printers::Sparkline({1, NAN, 2}, 3), "▁ █");
}

}  // namespace
}  // namespace cdb::tests
