// The parts of a grid together are its list of runs.
#include "compiler/grid/part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "compiler/analysis/reference.h"
#include "compiler/compile.h"
#include "compiler/yaml/short_plan.h"
#include "dsl/diagnostics.h"

namespace cdb::tests {
namespace {

std::shared_ptr<const grid::Grid> SharedGridOf(const std::string& text) {
  const auto read = [&](const std::string&, std::string&) { return std::optional(text); };
  compiler::CompileOptions options;
  options.lists_runs = false;
  compiler::Compilation result = compiler::Compile("test.cdb", read, options);
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return std::make_shared<const grid::Grid>(result.grids.at(0));
}

const char* const kGrids[] = {
    "benchmark b { }", "benchmark b { seed sweep(1 .. 7) }",
    "benchmark b { detector sweep(dbvt, sap) }",
    "benchmark b { cycles sweep(5, 9, 7); detector sweep(dbvt, sap, simple); repeats 2\n"
    "seed sweep(1 .. 4); objects { size uniform(1, 2); quantity sweep(1, 30, 3) }\n"
    "cases { open { world.walls none } closed { record energy } }\n"
    "skip when quantity == 3 and seed > 2 }"};

TEST(GridPart, AllPartsAreTheWholeList) {
  for (const char* text : kGrids) {
    SCOPED_TRACE(text);
    const auto made = SharedGridOf(text);
    const auto whole = std::make_shared<const plan::WholePlan>(grid::MakeWhole(made));
    const plan::Plan list = grid::ListRuns(*made);
    EXPECT_EQ(whole->run_count, list.runs.size());
    for (const std::uint64_t count : {1, 2, 3, 7, 100}) {
      std::vector<plan::Run> runs;
      for (std::uint64_t index = 0; index < count; ++index) {
        const plan::Plan part = grid::ListPart(*made, whole, {index, count});
        EXPECT_EQ(part.Sha256(), whole->sha256);
        EXPECT_TRUE(std::ranges::is_sorted(part.runs, {}, &plan::Run::at)) << "in grid order";
        runs.insert(runs.end(), part.runs.begin(), part.runs.end());
      }
      std::ranges::stable_sort(runs, {}, &plan::Run::at);
      EXPECT_EQ(runs, list.runs) << count;
    }
  }
}

TEST(GridPart, DetectorsOfAPointAreInOnePartAndPartsAreEven) {
  const auto made = SharedGridOf(
      "benchmark b { detector sweep(dbvt, sap, simple); seed sweep(1 .. 8)\n"
      "objects { size 1; quantity sweep(1 .. 8) } }");
  const auto whole = std::make_shared<const plan::WholePlan>(grid::MakeWhole(made));
  for (std::uint64_t index = 0; index < 8; ++index) {
    const plan::Plan part = grid::ListPart(*made, whole, {index, 8});
    EXPECT_EQ(part.runs.size(), 8u * 3);
    std::map<std::pair<std::uint64_t, std::uint64_t>, int> detectors;
    std::set<std::uint64_t> quantities;
    for (const plan::Run& run : part.runs) {
      ++detectors[{run.scene.world.Count("seed"), run.scene.ObjectCount()}];
      quantities.insert(run.scene.ObjectCount());
    }
    for (const auto& [point, runs] : detectors) EXPECT_EQ(runs, 3);
    EXPECT_GE(quantities.size(), 6u) << "no part has all the large runs";
  }
}

TEST(GridPart, APartOfAPartIsAPart) {
  const auto made = SharedGridOf(kGrids[3]);
  const auto whole = std::make_shared<const plan::WholePlan>(grid::MakeWhole(made));
  for (std::uint64_t index = 0; index < 5; ++index) {
    std::vector<plan::Run> runs;
    for (std::uint64_t i = 0; i < 3; ++i) {
      const plan::Plan part = grid::ListPart(*made, whole, {index * 3 + i, 15});
      runs.insert(runs.end(), part.runs.begin(), part.runs.end());
    }
    std::ranges::stable_sort(runs, {}, &plan::Run::at);
    EXPECT_EQ(runs, grid::ListPart(*made, whole, {index, 5}).runs);
  }
}

TEST(GridPart, TheWholeKnowsWhatTheListSays) {
  for (const char* text : kGrids) {
    SCOPED_TRACE(text);
    const auto made = SharedGridOf(text);
    const plan::Plan list = grid::ListRuns(*made);
    plan::Plan part = made->head;
    part.whole = std::make_shared<const plan::WholePlan>(grid::MakeWhole(made));
    EXPECT_EQ(part.MaxCycles(), list.MaxCycles());
    EXPECT_EQ(part.MaxObjects(), list.MaxObjects());
    EXPECT_EQ(analysis::MaxBodyCount(part), analysis::MaxBodyCount(list));
    for (const char* word : {"timing", "energy", "poses"})
      EXPECT_EQ(part.Records(word), list.Records(word)) << word;
    std::size_t i = 0;
    part.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
      ASSERT_LT(i, list.runs.size());
      EXPECT_EQ(id, list.runs[i].id);
      EXPECT_EQ(at, list.runs[i].at);
      EXPECT_EQ(rep, list.runs[i++].rep);
    });
    EXPECT_EQ(i, list.runs.size());
    std::vector<std::vector<std::size_t>> skipped;
    part.ForEachSkipped([&](const auto& point) { skipped.push_back(point); });
    EXPECT_EQ(skipped, list.skipped);
  }
}

TEST(GridPart, TheHashIsOfWhatDecidesTheRuns) {
  const auto hash = [](const std::string& text) {
    return grid::MakeWhole(SharedGridOf(text)).sha256;
  };
  const std::string text = kGrids[3];
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    return changed;
  };
  std::set<std::string> all = {hash(text)};
  EXPECT_EQ(hash("# a comment\n" + text), hash(text));
  EXPECT_EQ(hash(with("seed > 2", "seed >= 3")), hash(text)) << "leaves out the same";
  for (const auto& [from, to] : {std::pair{"cycles sweep(5, 9, 7)", "cycles sweep(5, 9, 8)"},
                                 {"seed > 2", "seed > 3"},
                                 {"uniform(1, 2)", "uniform(1, 2.5)"},
                                 {"record energy", "record timing"},
                                 {"repeats 2", "repeats 3"},
                                 {"dbvt, sap, simple", "sap, dbvt, simple"}})
    EXPECT_TRUE(all.insert(hash(with(from, to))).second) << to;
}

TEST(ShortPlan, IsReadAsItWasWritten) {
  const yaml::ShortPlan form = {"b",
                                std::string(64, 'a'),
                                1'000'000,
                                "my scenario.cdb",
                                "/there/my scenario.cdb",
                                "/library",
                                {"a.so", "b c.so"},
                                {{"x.cdb", "benchmark b {\n\t\"quoted\" # µ\n}\n"}, {"y.cdb", ""}}};
  EXPECT_EQ(yaml::FindShortPlan(yaml::ToYaml(form), "p.yaml"), form);
  EXPECT_FALSE(yaml::FindShortPlan("cdb_plan: 5\n", "p.yaml"));
}

}  // namespace
}  // namespace cdb::tests
