// `cdb history` as a program, on folders of made-up results.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/runtime/figures/compared_results.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr double kDay = 86400;

/// The results of the commit `c00`, `c01`, …, a day after the one before, in `history`.
using MakeCommit = std::function<void(int commit, ComparedResult& result)>;

void WriteCommit(const Program& program, int commit, const MakeCommit& make) {
  ComparedResult result = {.plan = ComparedPlan(1, {"10"}, {"simple", "sap"}),
                           .noise = 0.01,
                           .seed = static_cast<std::uint64_t>(commit + 1),
                           .started = kDay * commit};
  make(commit, result);
  std::filesystem::create_directories(program.folder() / "history");
  WriteCompared(result, program.folder() / fmt::format("history/fixture-c{:02}.h5", commit));
}

void WriteCommits(const Program& program, int commits, const MakeCommit& make) {
  for (int commit = 0; commit < commits; ++commit) WriteCommit(program, commit, make);
}

/// The second detector is slower by 8 % from `commit` on.
MakeCommit SlowerFrom(int commit) {
  return [commit](int of, ComparedResult& result) {
    if (of >= commit) result.change = Slower(1, 1.08);
  };
}

json JsonOf(const Program& program, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"history", "history", "--json"});
  const Finished done = program.Run(more);
  EXPECT_EQ(done.err, "");
  return json::parse(done.out);
}

TEST(HistoryCommand, FindsAStep) {
  const Program program;
  WriteCommits(program, 24, SlowerFrom(14));
  const Finished done = program.Run({"history", "history"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.out,
              HasSubstr("A comparison (fixture)\n  a µ-processor, Release: 24 files, from "
                        "c00 (2023-11-14) to c23 (2023-12-07); 2 points, 10 series\n"));
  EXPECT_THAT(done.out, HasSubstr("SLOWER between c13 (2023-11-27) and c14 (2023-11-28): step +"));
  EXPECT_THAT(done.out, HasSubstr("\n  at 1 of 2 points: detector sap, quantity 10\n"));
  EXPECT_THAT(done.out, Not(HasSubstr("simple")));
  const json found = JsonOf(program)["histories"][0];
  ASSERT_EQ(found["changes"].size(), 1u) << found["changes"].dump(1);
  const json& change = found["changes"][0];
  EXPECT_EQ(change["kind"], "step");
  EXPECT_EQ(change["from"], "c13");
  EXPECT_EQ(change["to"], "c14");
  ASSERT_EQ(change["figures"].size(), 4u);
  for (const json& figure : change["figures"]) {
    EXPECT_NEAR(figure["ratio"], 1.08, 0.02);
    EXPECT_LT(figure["interval"][0], figure["ratio"]);
    EXPECT_GT(figure["interval"][1], figure["ratio"]);
    EXPECT_EQ(figure["points"].size(), 1u);
  }
}

/// A repository with `commits` commits; their hashes, the oldest first.
std::vector<std::string> MakeRepository(const Program& program, int commits) {
  const Finished made = program.Shell(fmt::format(
      "git init -q repo && cd repo && git config user.name a && git config user.email a@b &&"
      " for i in $(seq {}); do git commit -q --allow-empty -m \"Change $i\"; done;"
      " git log --reverse --format=%h --abbrev=9",
      commits));
  EXPECT_EQ(made.status, 0) << made.err;
  std::vector<std::string> hashes;
  for (std::size_t at = 0, end; (end = made.out.find('\n', at)) != made.out.npos; at = end + 1)
    hashes.push_back(made.out.substr(at, end - at));
  return hashes;
}

TEST(HistoryCommand, OrdersFilesByCommits) {
  const Program program;
  const std::vector<std::string> hashes = MakeRepository(program, 24);
  ASSERT_EQ(hashes.size(), 24u);
  std::filesystem::create_directories(program.folder() / "history");
  // Measured in another order, and every other commit only.
  for (std::size_t i = 0; i < hashes.size(); i += 2)
    WriteCompared({.plan = ComparedPlan(1, {"10"}, {"simple", "sap"}),
                   .change = Slower(1, i >= 12 ? 1.08 : 1),
                   .noise = 0.004,
                   .seed = i + 1,
                   .started = kDay * static_cast<double>((i * 7) % 24)},
                  program.folder() / fmt::format("history/fixture-{}.h5", hashes[i]));
  WriteCompared({.plan = ComparedPlan(1, {"10"}, {"simple", "sap"})},
                program.folder() / "history/fixture-other.h5");
  const json all = JsonOf(program, {"--git", "repo"});
  const json found = all["histories"][0];
  ASSERT_EQ(found["files"].size(), 12u);
  EXPECT_EQ(found["files"][0]["label"], hashes[0]);
  EXPECT_EQ(found["files"][11]["label"], hashes[22]);
  ASSERT_EQ(found["changes"].size(), 1u) << found["changes"].dump(1);
  EXPECT_EQ(found["changes"][0]["from"], hashes[10]);
  EXPECT_EQ(found["changes"][0]["to"], hashes[12]);
  ASSERT_EQ(found["changes"][0]["commits"].size(), 2u);
  EXPECT_EQ(found["changes"][0]["commits"][1]["subject"], "Change 13");
  ASSERT_EQ(all["left_out"].size(), 1u);
  EXPECT_THAT(all["left_out"][0]["why"].get<std::string>(), HasSubstr("no commit"));
  EXPECT_THAT(program.Run({"history", "history", "--git", "repo"}).out,
              HasSubstr(fmt::format("  in 2 commits: {} Change 12; {} Change 13\n", hashes[11],
                                    hashes[12])));
  // Without the repository, the order is another one.
  EXPECT_EQ(JsonOf(program)["histories"][0]["changes"].size(), 0u);
  EXPECT_EQ(program.Run({"history", "history", "--git", "history"}).status, 2);
}

TEST(HistoryCommand, LeavesOutCommitsOfBranches) {
  const Program program;
  MakeRepository(program, 8);
  const Finished made = program.Shell(
      "cd repo && main=$(git branch --show-current) && git checkout -q -b side HEAD~2 &&"
      " git commit -q --allow-empty -m Side && git checkout -q $main &&"
      " git merge -q --no-ff -m Merge side && git commit -q --allow-empty -m Last &&"
      " git rev-parse side HEAD~1 && git rev-list --reverse HEAD");
  ASSERT_EQ(made.status, 0) << made.err;
  std::vector<std::string> hashes;
  for (std::size_t at = 0; at < made.out.size(); at = made.out.find('\n', at) + 1)
    hashes.push_back(made.out.substr(at, 12));
  ASSERT_EQ(hashes.size(), 2u + 11u);
  std::filesystem::create_directories(program.folder() / "history");
  for (std::size_t i = 2; i < hashes.size(); ++i)
    WriteCompared({.plan = ComparedPlan(1, {"10"}, {"simple"}),
                   .change = Slower(1, hashes[i] == hashes[0] ? 1.5 : 1),
                   .noise = 0.004,
                   .seed = i},
                  program.folder() / fmt::format("history/fixture-{}.h5", hashes[i]));
  const json all = JsonOf(program, {"--git", "repo"});
  EXPECT_EQ(all["histories"][0]["files"].size(), 10u);
  ASSERT_EQ(all["left_out"].size(), 1u);
  EXPECT_THAT(all["left_out"][0]["file"].get<std::string>(), HasSubstr(hashes[0]));
  EXPECT_THAT(all["left_out"][0]["why"].get<std::string>(),
              HasSubstr("of a branch that " + hashes[1].substr(0, 9) + " merged"));
}

TEST(HistoryCommand, WritesAPage) {
  const Program program;
  WriteCommits(program, 24, SlowerFrom(14));
  const Finished done = program.Run({"history", "history", "--page"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.out, testing::StartsWith("history.html: "));
  const std::string page = program.Read("history.html");
  EXPECT_THAT(page, HasSubstr("<title>History of history</title>"));
  EXPECT_THAT(page, HasSubstr("\"changes\":[{\"kind\":\"step\",\"from\":13,\"to\":14,"));
  EXPECT_EQ(program.Run({"history", "history", "-o", "x.html"}).status, 2);
  EXPECT_EQ(program.Run({"history", "history", "--page", "--json"}).status, 2);
}

TEST(HistoryCommand, KeepsCountsOfInstructionsApart) {
  const Program program;
  WriteCommits(program, 16, [](int commit, ComparedResult& result) {
    result.plan = ComparedPlan(1, {"10"}, {"simple", "sap"}, "clock instructions");
    result.noise = 0.0001;
    if (commit >= 9) result.change = Slower(1, 1.004);
  });
  const json changes = JsonOf(program)["histories"][0]["changes"];
  ASSERT_EQ(changes.size(), 1u) << changes.dump(1);
  EXPECT_EQ(changes[0]["to"], "c09");
  EXPECT_EQ(changes[0]["figures"][0]["figure"], "step_instructions");
  EXPECT_THAT(program.Run({"history", "history"}).out, HasSubstr("MORE INSTRUCTIONS between c08"));
}

TEST(HistoryCommand, KeepsTimesWithCountersApart) {
  const Program program;
  WriteCommits(program, 16, [](int commit, ComparedResult& result) {
    const bool has_counters = commit >= 8;
    result.plan = ComparedPlan(1, {"10"}, {"simple"}, "",
                               has_counters ? "timing, pairs, counters" : "timing, pairs");
    result.change = Slower(0, has_counters ? 1.5 : 1);
  });
  const json found = JsonOf(program)["histories"][0];
  EXPECT_EQ(found["changes"].size(), 0u) << found["changes"].dump(1);
  std::size_t of_step = 0;
  for (const json& series : found["series"]) {
    if (series["figure"] != "step") continue;
    ++of_step;
    EXPECT_NE(series["values"][0].is_null(), series["values"][15].is_null());
  }
  EXPECT_EQ(of_step, 2u);
}

TEST(HistoryCommand, JoinsPointsThatChangeTogether) {
  const Program program;
  WriteCommits(program, 18, [](int commit, ComparedResult& result) {
    result.plan = ComparedPlan(1, {"10"});
    if (commit >= 10)
      result.change = [](const plan::Run& run, ComparedRun& made) {
        if (run.at[0] > 0) made.factor = 0.9;
        made.peak_bytes = 6e6;
      };
  });
  const json changes = JsonOf(program)["histories"][0]["changes"];
  ASSERT_EQ(changes.size(), 2u) << changes.dump(1);
  std::set<std::string> figures;
  for (const json& change : changes) {
    EXPECT_EQ(change["to"], "c10");
    for (const json& figure : change["figures"]) {
      figures.insert(figure["figure"]);
      const bool is_memory = figure["figure"] == "peak_rss";
      EXPECT_EQ(change["is_worse"], is_memory);
      EXPECT_EQ(figure["points"].size(), is_memory ? 4u : 3u);
      EXPECT_NEAR(figure["ratio"], is_memory ? 1.2 : 0.9, 0.01);
    }
  }
  EXPECT_EQ(figures, (std::set<std::string>{"broad", "detect", "narrow", "peak_rss", "step"}));
  const std::string text = program.Run({"history", "history"}).out;
  EXPECT_THAT(text, HasSubstr("faster between c09 (2023-11-23) and c10 (2023-11-24): step -9."));
  EXPECT_THAT(text, HasSubstr("MORE MEMORY between c09 (2023-11-23) and c10 (2023-11-24): peak "
                              "memory +20.0 % (+20.0 .. +20.0 %)\n  at 4 of 4 points: "));
}

TEST(HistoryCommand, FailsSinceAFileThatWasAccepted) {
  const Program program;
  WriteCommits(program, 24, SlowerFrom(14));
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"history", "history"});
    return program.Run(more);
  };
  const Finished failed = with({"--fail-above", "5%"});
  EXPECT_EQ(failed.status, 4);
  EXPECT_THAT(failed.out, HasSubstr("FAIL (exit status 4): worse by more than 5 % since c00: "));
  EXPECT_EQ(with({"--fail-above", "12%"}).status, 0);
  EXPECT_EQ(with({"--fail-above", "5%", "--since", "c13"}).status, 4);
  const Finished accepted = with({"--fail-above", "5%", "--since", "c14"});
  EXPECT_EQ(accepted.status, 0);
  EXPECT_THAT(accepted.out, HasSubstr("No change was found"));
  const Finished unknown = with({"--since", "c99"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err, HasSubstr("--since c99: there is no file with this label"));
  EXPECT_THAT(with({"--least", "20%"}).out, HasSubstr("No change was found"));
}

TEST(HistoryCommand, FindsADrift) {
  const Program program;
  WriteCommits(program, 30, [](int commit, ComparedResult& result) {
    result.change = Slower(0, std::exp(0.006 * commit));
  });
  const json found = JsonOf(program)["histories"][0]["changes"];
  ASSERT_EQ(found.size(), 1u) << found.dump(1);
  EXPECT_EQ(found[0]["kind"], "drift");
  EXPECT_TRUE(found[0]["is_worse"]);
  for (const json& figure : found[0]["figures"])
    EXPECT_NEAR(figure["ratio"], std::exp(0.006 * 29), 0.03);
  EXPECT_THAT(program.Run({"history", "history"}).out, HasSubstr("SLOWER little by little, over "));
}

TEST(HistoryCommand, KeepsMachinesAndScenesApart) {
  const Program program;
  WriteCommits(program, 20, [](int commit, ComparedResult& result) {
    // One machine is three times as fast as the other one, and one scene lasts longer.
    if (commit % 2 == 1) {
      result.provenance["cpu"] = "another";
      result.change = [](const plan::Run&, ComparedRun& made) { made.factor = 1.0 / 3; };
    } else if (commit >= 10) {
      result.plan = ComparedPlan(1, {"10"}, {"simple", "sap"}, "timestep 1/30");
      result.change = [](const plan::Run&, ComparedRun& made) { made.factor = 2; };
    }
  });
  const json histories = JsonOf(program)["histories"];
  ASSERT_EQ(histories.size(), 2u);
  for (const json& of : histories) {
    EXPECT_EQ(of["files"].size(), 10u);
    EXPECT_EQ(of["changes"].size(), 0u) << of["changes"].dump(1);
  }
  EXPECT_EQ(histories[0]["machine"], "a µ-processor, Release");
  EXPECT_EQ(histories[0]["series"].size(), 2 * histories[1]["series"].size());
}

TEST(HistoryCommand, NamesChangesOfTheMotion) {
  const Program program;
  WriteCommits(program, 8, [](int commit, ComparedResult& result) {
    result.change = [commit](const plan::Run& run, ComparedRun& made) {
      if (run.at[0] == 1) made.state = fmt::format("{:016x}", commit);
      if (run.at[0] == 0 && commit >= 5) made.state = "fedcba9876543210";
    };
  });
  const json motions = JsonOf(program)["histories"][0]["motions"];
  ASSERT_EQ(motions.size(), 1u) << motions.dump(1);
  EXPECT_EQ(motions[0]["from"], "c04");
  EXPECT_EQ(motions[0]["to"], "c05");
  EXPECT_EQ(motions[0]["states"].size(), 1u);
  EXPECT_EQ(motions[0]["states"][0], "detector simple, quantity 10");
  const std::string text = program.Run({"history", "history"}).out;
  EXPECT_THAT(text, HasSubstr("OTHER MOTION between c04 (2023-11-18) and c05 (2023-11-19): another "
                              "last state at 1 point\n"));
  EXPECT_THAT(text, HasSubstr("The motion of 1 point is another one in most files"));
}

TEST(HistoryCommand, ReadsOnlyNewFiles) {
  const Program program;
  const MakeCommit same = [](int, ComparedResult&) {};
  WriteCommits(program, 7, same);
  const json first = JsonOf(program);
  EXPECT_EQ(first["read"], 7);
  json second = JsonOf(program);
  EXPECT_EQ(second["read"], 0);
  EXPECT_EQ(second["histories"], first["histories"]);
  WriteCommit(program, 7, same);
  EXPECT_EQ(JsonOf(program)["read"], 1);
  // Another file under the same name is read again, and one that is gone is forgotten.
  WriteCommit(program, 3, SlowerFrom(0));
  std::filesystem::remove(program.folder() / "history/fixture-c00.h5");
  second = JsonOf(program);
  EXPECT_EQ(second["read"], 1);
  EXPECT_EQ(second["histories"][0]["files"].size(), 7u);
  // A damaged or foreign cache is made anew.
  std::string cache = program.Read("history/.history.json");
  cache[cache.size() / 2] ^= 1;
  for (const std::string& text : {cache, std::string("{}"), std::string()}) {
    program.Write("history/.history.json", text);
    const json again = JsonOf(program);
    EXPECT_EQ(again["read"], 7);
    EXPECT_EQ(again["histories"], second["histories"]);
  }
}

TEST(HistoryCommand, NamesDamagedFilesAndGoesOn) {
  const Program program;
  WriteCommits(program, 7, [](int, ComparedResult&) {});
  program.Write("history/fixture-c02.h5", "no results");
  std::filesystem::resize_file(program.folder() / "history/fixture-c04.h5", 3000);
  const json damaged = JsonOf(program);
  ASSERT_EQ(damaged["left_out"].size(), 2u);
  EXPECT_EQ(damaged["left_out"][0]["file"], "fixture-c02.h5");
  EXPECT_EQ(damaged["left_out"][1]["file"], "fixture-c04.h5");
  EXPECT_EQ(damaged["histories"][0]["files"].size(), 5u);
  EXPECT_THAT(program.Run({"history", "history"}).out, HasSubstr("Left out: fixture-c02.h5: "));
}

TEST(HistoryCommand, FindsFilesInFoldersOfCommits) {
  const Program program;
  for (const char* commit : {"one", "two"}) {
    std::filesystem::create_directories(program.folder() / "history" / commit);
    WriteCompared({.plan = ComparedPlan(1, {"10"}, {"simple", "sap"}),
                   .started = commit[0] == 'o' ? 0 : kDay},
                  program.folder() / "history" / commit / "fixture.h5");
  }
  const json files = JsonOf(program)["histories"][0]["files"];
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0]["label"], "one");
  EXPECT_EQ(files[1]["file"], "two/fixture.h5");
  EXPECT_THAT(program.Run({"history", "history"}).out,
              HasSubstr("Too few files for changes: 6 of a series are needed"));
}

TEST(HistoryCommand, RefusesWhatIsNoFolderOfResults) {
  const Program program;
  std::filesystem::create_directories(program.folder() / "empty");
  const Finished missing = program.Run({"history", "nowhere"});
  EXPECT_EQ(missing.status, 2);
  EXPECT_THAT(missing.err, HasSubstr("nowhere is not a folder"));
  const Finished empty = program.Run({"history", "empty"});
  EXPECT_EQ(empty.status, 2);
  EXPECT_THAT(empty.err, HasSubstr("there is no results file (.h5) in empty"));
}

}  // namespace
}  // namespace cdb::tests
