// Results documents: the numbers equal those of the tables, and every file can be converted.
#include "runtime/printers/results_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "runtime/printers/json_points.h"
#include "tests/runtime/figures/made_up_file.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using nlohmann::json;

json DocumentOf(const plan::Plan& plan, const MakeUp& make_up, bool for_page = false) {
  return WithMadeUpFile(plan, make_up, [&](const results::ResultFile& file) {
    return json::parse(
        printers::ResultsDocument(file, {.file = "out.h5", .for_page = for_page}).text);
  });
}

/// dbvt takes 1.2 times as long as simple; each repeat takes 1 % more.
MadeUp MadeUpTimes(const plan::Run& run) {
  return {.ns = 1000.0 * static_cast<double>(run.at[1] + 1) * (run.at[0] == 0 ? 1 : 1.2) *
                (1 + 0.01 * static_cast<double>(run.rep))};
}

plan::Plan DocumentPlan(std::uint64_t repeats, std::vector<std::vector<std::size_t>> skipped = {}) {
  return MakePlan({TextAxis("detector", {"simple", "dbvt"}), NumberAxis("quantity", {10, 20, 40})},
                  repeats, {.cycles = kMadeUpCycles, .record = {"timing"}}, std::move(skipped));
}

TEST(JsonNumber, HasSixDigits) {
  EXPECT_EQ(printers::JsonNumber(1234567.8).dump(), "1234570");
  EXPECT_EQ(printers::JsonNumber(0.1 + 0.2).dump(), "0.3");
  EXPECT_EQ(printers::JsonNumber(100).dump(), "100");
  EXPECT_EQ(printers::JsonNumber(1.0 / 3, 4).dump(), "0.3333");
  EXPECT_EQ(printers::JsonNumber(NAN).dump(), "null");
  EXPECT_EQ(printers::JsonNumber(INFINITY).dump(), "null");
}

TEST(ResultsDocument, HasAColumnForEachFigure) {
  const json document = DocumentOf(DocumentPlan(5, {{0, 2}}), MadeUpTimes, true);
  EXPECT_EQ(document["document"], 1);
  EXPECT_EQ(document["sources"][0]["file"], "out.h5");
  EXPECT_EQ(document["runs"]["all"], 30);
  EXPECT_EQ(document["runs"]["skipped"], 5);
  EXPECT_EQ(document["detector_axis"], 0);
  EXPECT_EQ(document["axes"][1]["values"], json({10, 20, 40}));
  const json& points = document["points"];
  EXPECT_EQ(points["at"], json({{0, 0}, {0, 1}, {1, 0}, {1, 1}, {1, 2}}));
  // The median of the five repeats is the third.
  EXPECT_EQ(points["times"]["step"]["mean"], json({1020, 2040, 1224, 2448, 3672}));
  EXPECT_EQ(points["times"]["step"]["max"], points["times"]["step"]["mean"]);
  EXPECT_EQ(points["repeats"], json({5, 5, 5, 5, 5}));
  EXPECT_EQ(points["verdict"][0], "stable");
  EXPECT_LT(points["times"]["step"]["low"][0], 1020);
  EXPECT_GT(points["times"]["step"]["high"][0], 1020);
  const json& ratios = document["ratios"];
  EXPECT_EQ(ratios["baseline"], "dbvt");  // the detector that has all cells
  EXPECT_EQ(ratios["means"]["step"][0]["value"], 0.833333);
  EXPECT_EQ(ratios["phases"]["step"]["is_matched"], json({true, true, true, true, false}));
  EXPECT_EQ(document["cycles"]["step"][0], json({1020, 1020, 1020, 1020}));
  EXPECT_EQ(document["distributions"]["repeat_means"]["step"][0],
            json({1000, 1010, 1020, 1030, 1040}));
  EXPECT_EQ(document["interval"]["name"], "95 % interval");
}

TEST(ResultsDocument, HasPointsWithoutCyclesToo) {
  const json document = DocumentOf(DocumentPlan(1), [](const plan::Run& run) {
    if (run.at[1] == 1)
      return MadeUp{
          .verdict = protocol::Verdict::kUnknown, .status = results::Status::kFailed, .cycles = 0};
    return MadeUpTimes(run);
  });
  EXPECT_EQ(document["points"]["mark"], json({"", "failed", "", "", "failed", ""}));
  EXPECT_EQ(document["points"]["times"]["step"]["mean"][1], nullptr);
  EXPECT_EQ(document["points"]["is_void"], json({false, true, false, false, true, false}));
  EXPECT_EQ(document["failures"].size(), 2u);
  EXPECT_EQ(document["failures"][0]["place"], "detector simple, quantity 20, rep 0");
  EXPECT_EQ(document["failures"][0]["why"], "failed: made up");
  EXPECT_EQ(document["warnings"][0]["kind"], "failed");
  EXPECT_FALSE(document.contains("cycles"));
}

TEST(ResultsDocument, IsThereWhereEveryRunFailed) {
  const json document = DocumentOf(DocumentPlan(1), [](const plan::Run&) {
    return MadeUp{
        .verdict = protocol::Verdict::kUnknown, .status = results::Status::kFailed, .cycles = 0};
  });
  EXPECT_EQ(document["points"]["at"].size(), 6u);
  EXPECT_EQ(document["ratios"], nullptr);
  EXPECT_EQ(document["runs"]["failed"], 6);
}

TEST(ResultsDocument, HasErrorsAgainstRunTime) {
  const json document = DocumentOf(
      MakePlan({NumberAxis("quantity", {10, 20}), TextAxis("detector", {"simple", "dbvt"})}, 5,
               {.cycles = kMadeUpCycles, .record = {"timing"}, .metrics = {"position"}}),
      [](const plan::Run& run) {
        return MadeUp{.ns = run.at[1] == 0 ? 1e6 : 2e6,
                      .errors = {{"position", run.at[1] == 0 ? 0.25 : 0.125}}};
      });
  const json& points = document["points"];
  // A cycle simulates 1 ms.
  EXPECT_EQ(points["time_step"][0], 0.001);
  EXPECT_EQ(points["ms_per_s"], json({1000, 2000, 1000, 2000}));
  EXPECT_EQ(points["errors"]["position"]["value"], json({0.25, 0.125, 0.25, 0.125}));
  // Different numbers of objects are different scenes.
  const json& fronts = document["fronts"];
  ASSERT_EQ(fronts.size(), 2u);
  EXPECT_EQ(fronts[1]["each"], json({{"quantity", 20}}));
  EXPECT_EQ(fronts[1]["rows"][0]["at"], json({{"detector", "simple"}}));
  EXPECT_EQ(fronts[1]["rows"][1]["points"], json({3}));
  EXPECT_EQ(fronts[1]["rows"][1]["on_front"], true);
}

TEST(ResultsDocument, IsThereWithoutAxes) {
  const json document = DocumentOf(
      MakePlan({}, 1, {.cycles = kMadeUpCycles, .record = {"timing"}}),
      [](const plan::Run&) { return MadeUp{}; }, true);
  EXPECT_EQ(document["points"]["at"], json::array({json::array()}));
  EXPECT_EQ(document["axes"], json::array());
  EXPECT_EQ(document["points"]["times"]["step"]["mean"], json({1000}));
}

TEST(ResultsDocument, IsThereWhereNothingRanYet) {
  const plan::Plan plan = DocumentPlan(1);
  const TemporaryFolder folder;
  journal::Merge(plan, {{"build_type", "Release"}}, std::vector<std::filesystem::path>{},
                 folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  const json document =
      json::parse(printers::ResultsDocument(file, {.file = "x", .for_page = true}).text);
  EXPECT_EQ(document["points"]["at"], json::array());
  EXPECT_EQ(document["runs"]["missing"], 6);
  EXPECT_EQ(document["warnings"][0]["kind"], "partial");
  EXPECT_EQ(document["conclusions"], json::array());
}

/// Of ten repeats, those of `dbvt` are complete and the others begin with the second. From 20
/// objects on, an object tunnels in some of them, and in the fourth before the others.
MadeUp PartlyRun(const plan::Run& run) {
  if (run.at[0] == 0 && (run.rep == 0 || run.rep > 5)) return {.status = results::Status::kMissing};
  if (run.at[1] > 0 && run.rep >= 2)
    return {.verdict = protocol::Verdict::kTunnelled, .first_bad_cycle = run.rep == 3 ? 1 : 3};
  return {};
}

std::string StabilityIn(const json& document) {
  for (const json& conclusion : document["conclusions"])
    if (conclusion["kind"] == "stability") return conclusion["answer"];
  return "no conclusion";
}

TEST(ResultsDocument, HasTheWorstVerdictOfTheRepeatsThatRan) {
  const json document = DocumentOf(DocumentPlan(10), PartlyRun);
  const json& points = document["points"];
  EXPECT_EQ(points["verdict"],
            json({"stable", "tunnelled", "tunnelled", "stable", "tunnelled", "tunnelled"}));
  EXPECT_EQ(points["first_bad_cycle"], json({nullptr, 1, 1, nullptr, 1, 1}));
  EXPECT_EQ(
      StabilityIn(document),
      "2 of 6 configurations are stable, as far as was checked (4 tunnelled). Along the number "
      "of objects: stable up to 10, tunnelled from 20." +
          kNothingChecked);
}

TEST(ResultsDocument, JudgesTheSimulationByThePointsThatRan) {
  const json document = DocumentOf(DocumentPlan(10), [](const plan::Run& run) {
    return run.at[1] == 1 ? MadeUp{.status = results::Status::kMissing} : PartlyRun(run);
  });
  EXPECT_EQ(document["points"]["verdict"], json({"stable", "tunnelled", "stable", "tunnelled"}));
  EXPECT_EQ(
      StabilityIn(document),
      "2 of 4 configurations are stable, as far as was checked (2 tunnelled). Along the number of "
      "objects: stable up to 10, tunnelled from 40." +
          kNothingChecked);
}

TEST(ResultsDocument, HasBinsForTheCyclesThatRan) {
  const json document = DocumentOf(
      DocumentPlan(1),
      [](const plan::Run&) {
        return MadeUp{.verdict = protocol::Verdict::kTimedOut,
                      .status = results::Status::kTimedOut,
                      .cycles = 2};
      },
      true);
  EXPECT_EQ(document["cycles"]["bins"].size(), 2u);
}

TEST(ReportCommand, WritesOnePageOfAllFiles) {
  const Program program;
  const TemporaryFolder runs;
  const plan::Plan plan = DocumentPlan(1);
  for (const plan::Run& run : plan.runs) WriteMadeUp(plan, run, MadeUpTimes(run), runs.path());
  journal::Merge(plan, {{"build_type", "Release"}}, runs.path(), program.folder() / "out.h5");
  const Finished written = program.Run({"report", "out.h5", "out.h5"});
  if (written.status == 2 && written.err.find("without pages") != std::string::npos)
    GTEST_SKIP() << written.err;
  EXPECT_EQ(written.status, 0) << written.err;
  EXPECT_TRUE(written.out.starts_with("out.html: ")) << written.out;
  const std::string page = program.Read("out.html");
  EXPECT_NE(page.find("<title>A plan for tests"), std::string::npos);
  const std::size_t at = page.find("{\"documents\":[");
  ASSERT_NE(at, std::string::npos);
  const json data = json::parse(page.substr(at, page.find("</script>", at) - at));
  ASSERT_EQ(data["documents"].size(), 2u);
  EXPECT_EQ(data["documents"][1]["points"]["times"]["step"]["mean"][0], 1000);
  const std::string results = program.Read("out.h5");
  const Finished refused = program.Run({"report", "out.h5", "-o", "out.h5"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(refused.err,
            "cdb: out.h5 is the results file; name another file for the page with -o\n");
  EXPECT_EQ(program.Read("out.h5"), results);
}

/// A plan of `points` points. Equal runs have one record.
plan::Plan LargePlan(std::size_t points) {
  std::vector<double> values(points);
  for (std::size_t i = 0; i < points; ++i) values[i] = static_cast<double>(i);
  plan::Plan plan =
      MakePlan({NumberAxis("x", {0})}, 1, {.cycles = kMadeUpCycles, .record = {"timing"}});
  const plan::Run run = plan.runs[0];
  plan.runs.assign(points, run);
  plan.axes = {NumberAxis("x", values)};
  for (std::size_t i = 0; i < points; ++i) plan.runs[i].at = {i};
  return plan;
}

TEST(ResultsDocument, IsSmallForManyPoints) {
  const plan::Plan plan = LargePlan(6000);
  const TemporaryFolder folder;
  WriteMadeUp(plan, plan.runs[0], MadeUp{}, folder.path());
  journal::Merge(plan, {{"build_type", "Release"}}, folder.path(), folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  const std::string text = printers::ResultsDocument(file, {.file = "x", .for_page = true}).text;
  EXPECT_LT(text.size(), 200'000u);
  const json document = json::parse(text);
  EXPECT_EQ(document["points"]["at"]["grid"], json::array({json::array({0, 6000})}));
  EXPECT_EQ(document["points"]["times"]["step"]["mean"]["constant"], 1000);
  EXPECT_EQ(document["cycles"], nullptr);
}

}  // namespace
}  // namespace cdb::tests
