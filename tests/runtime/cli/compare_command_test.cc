// `cdb compare` as a program: files, folders, rejections and exit statuses.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/runtime/figures/compared_results.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

/// Writes results of 5 repeats, whose second detector takes `factor` times as long.
void WriteFactor(const Program& program, const std::string& name, double factor,
                 std::uint64_t seed) {
  std::filesystem::create_directories((program.folder() / name).parent_path());
  WriteCompared({.plan = ComparedPlan(5, {"10"}, {"simple", "sap"}),
                 .change = Slower(1, factor),
                 .noise = 0.001,
                 .seed = seed},
                program.folder() / name);
}

TEST(CompareCommand, ExitsByWhatIsWorse) {
  const Program program;
  WriteFactor(program, "a.h5", 1, 1);
  WriteFactor(program, "b.h5", 1.08, 2);
  const Finished worse = program.Run({"compare", "a.h5", "b.h5"});
  EXPECT_EQ(worse.status, 4) << worse.err;
  EXPECT_NE(worse.out.find("\n  FAIL (exit status 4): slower by more than 5 %: sap "),
            std::string::npos)
      << worse.out;
  EXPECT_EQ(program.Run({"compare", "b.h5", "a.h5"}).status, 0);
  EXPECT_EQ(program.Run({"compare", "a.h5", "b.h5", "--fail-above", "9 %"}).status, 0);
  EXPECT_EQ(program.Run({"compare", "--select", "detector=simple", "a.h5", "b.h5"}).status, 0);
  EXPECT_EQ(program.Run({"compare", "a.h5", "b.h5", "--select", "detector=sap"}).status, 4);
  EXPECT_EQ(program.Run({"compare", "a.h5", "a.h5", "b.h5", "--phase", "step"}).status, 4);
  EXPECT_EQ(program.Run({"compare", "a.h5", "b.h5", "a.h5", "--phase", "step"}).status, 0);
}

TEST(CompareCommand, PrintsAllOfIt) {
  const Program program;
  WriteFactor(program, "a.h5", 1, 1);
  WriteFactor(program, "b.h5", 1.08, 2);
  const Finished compared = program.Run({"compare", "a.h5", "b.h5", "--phase", "step"});
  EXPECT_EQ(compared.out,
            R"(A comparison: from a.h5 to b.h5
  The same machine, versions and kind of build
  2 points in both files
  The runs of both files were interleaved in time

Result
  SLOWER: sap: step +8.1 % (+7.8 .. +8.3 %)
  Same within 0.2 %: simple
  Physics: the same last state at 2 of 2 points, to the last bit
  Unchanged: verdicts, position error, missed pairs, false positive pairs, duplicate pairs, peak
      memory
  FAIL (exit status 4): slower by more than 5 %: sap step

Mean of a cycle
  detector  phase      a.h5      b.h5  ratio    95 % interval  verdict
  ------------------------------------------------------------------------------
  simple    step   998.2 ns  999.2 ns  1.001  0.9998 .. 1.002  same within 0.2 %
  sap       step   998.2 ns   1079 ns  1.081   1.078 .. 1.083  SLOWER
  Fastest of 4 repeats per cycle, averaged over all choices of that many (of 5 and 5), then mean
      over cycles. Below 1: b.h5 is faster.
  Intervals by bootstrap over the repeats of each file by itself. Slower, faster: by more than 1 %,
      with Holm's correction for all groups and phases (5 %): cdb doc compare.
)");
}

TEST(CompareCommand, ComparesCountsOfInstructions) {
  const Program program;
  const auto write = [&](const char* name, double factor) {
    WriteCompared({.plan = ComparedPlan(1, {"10"}, {"simple", "sap"}, "clock instructions"),
                   .change = Slower(1, factor),
                   .noise = 0},
                  program.folder() / name);
  };
  write("a.h5", 1);
  write("same.h5", 1.0003);
  write("more.h5", 1.01);
  const auto compare = [&](std::vector<std::string> files) {
    files.insert(files.begin(), {"compare", "--phase", "step", "--fail-above", "0.5%"});
    return program.Run(files);
  };
  const Finished same = compare({"a.h5", "same.h5"}), more = compare({"a.h5", "more.h5"});
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_NE(same.out.find("Same within 0.08 %: simple; sap\n"), std::string::npos) << same.out;
  EXPECT_EQ(more.status, 4) << more.err;
  EXPECT_NE(more.out.find("MORE INSTRUCTIONS: sap: step +1.00 % (+0.95 .. +1.05 %)\n"),
            std::string::npos)
      << more.out;
  EXPECT_EQ(more.out.find("interleaved"), std::string::npos) << more.out;
  EXPECT_EQ(more.out.find(" ns"), std::string::npos) << more.out;
  const auto times = nlohmann::json::parse(
      compare({"a.h5", "more.h5", "--json"}).out)["benchmarks"][0]["comparisons"][0]["times"];
  EXPECT_EQ(times["clock"], "instructions");
  EXPECT_NEAR(times["groups"][1]["phases"][0]["a_instructions"], 1000, 1e-9);
  EXPECT_EQ(compare({"a.h5", "more.h5", "--page"}).status, 4);
  // Times and counts have nothing in common.
  WriteCompared({.plan = ComparedPlan(1, {"10"}, {"simple", "sap"}), .noise = 0},
                program.folder() / "time.h5");
  const Finished unlike = compare({"a.h5", "time.h5"});
  EXPECT_NE(unlike.out.find("one of the files counts instructions"), std::string::npos)
      << unlike.out;
  EXPECT_EQ(program.Run({"report", "a.h5"}).status, 2);
}

TEST(CompareCommand, ComparesFoldersFileByFile) {
  const Program program;
  for (const char* name : {"one.h5", "two.h5"}) {
    WriteFactor(program, std::string("before/") + name, 1, 1);
    WriteFactor(program, std::string("after/") + name, name[0] == 't' ? 1.08 : 1, 2);
  }
  WriteFactor(program, "after/three.h5", 1, 3);
  const Finished compared = program.Run({"compare", "before", "after", "--phase", "step"});
  EXPECT_EQ(compared.status, 4) << compared.err;
  EXPECT_NE(compared.out.find("Not compared, because not in all folders\n  after/three.h5\n"),
            std::string::npos)
      << compared.out;
  EXPECT_NE(compared.out.find("A comparison: from before/one.h5 to after/one.h5\n"),
            std::string::npos);
  EXPECT_NE(compared.out.find("A comparison: from before/two.h5 to after/two.h5\n"),
            std::string::npos);
  const Finished history = program.Run({"compare", "before", "after", "before", "--phase", "step"});
  EXPECT_NE(history.out.find("\n  benchmark          before  after  before  "), std::string::npos)
      << history.out;
  const Finished json = program.Run({"compare", "before", "after", "--json"});
  EXPECT_EQ(json.status, 4);
  const auto parsed = nlohmann::json::parse(json.out);
  EXPECT_TRUE(parsed["is_worse"]);
  EXPECT_EQ(parsed["unmatched"], nlohmann::json({"after/three.h5"}));
  EXPECT_FALSE(parsed["benchmarks"][0]["comparisons"][0]["is_worse"]);
  EXPECT_TRUE(parsed["benchmarks"][1]["comparisons"][0]["is_worse"]);
}

TEST(CompareCommand, NamesEveryBenchmarkWithOtherScenes) {
  const Program program;
  for (const char* name : {"one.h5", "two.h5", "three.h5"}) {
    WriteFactor(program, std::string("before/") + name, 1, 1);
    if (name[1] == 'n') WriteFactor(program, std::string("after/") + name, 1, 1);
  }
  WriteCompared({ComparedPlan(5, {"10"}, {"simple", "sap"}, "timestep 1/30")},
                program.folder() / "after/two.h5");
  WriteCompared({ComparedPlan(5, {"20", "30"}, {"simple", "sap"})},
                program.folder() / "after/three.h5");
  const std::vector<std::string> compare = {"compare", "before", "after", "--phase", "step"};
  const Finished unlike = program.Run(compare);
  EXPECT_EQ(unlike.status, 5) << unlike.err;
  EXPECT_EQ(unlike.err, "");
  for (const char* part : {"A comparison: from before/one.h5 to after/one.h5\n",
                           "  fixture    timestep   1/60    1/30\n", "have no point in common",
                           "FAIL (exit status 5): fixture: other scenes"})
    EXPECT_NE(unlike.out.find(part), std::string::npos) << part << " is not in\n" << unlike.out;
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), compare.begin(), compare.end());
    return program.Run(more);
  };
  const Finished markdown = with({"--markdown"});
  EXPECT_EQ(markdown.status, 5);
  EXPECT_TRUE(markdown.out.starts_with("### FAIL (exit status 5): ")) << markdown.out;
  EXPECT_NE(markdown.out.find("<summary>fixture: all numbers</summary>"), std::string::npos);
  const auto json = nlohmann::json::parse(with({"--json"}).out);
  EXPECT_EQ(json["other_scenes"].size(), 2u);
  EXPECT_TRUE(json["is_worse"]);

  std::filesystem::remove(program.folder() / "after/three.h5");
  EXPECT_EQ(with({"--allow", "scenes"}).status, 4);
  EXPECT_NE(with({"--allow", "scenes"}).out.find("missing: before/three.h5"), std::string::npos);
  EXPECT_EQ(with({"--allow", "scenes,missing"}).status, 0);
}

/// The data of a page.
nlohmann::json DataOf(const std::string& page) {
  const std::string start = "id=\"data\">";
  const std::size_t at = page.find(start) + start.size();
  return nlohmann::json::parse(page.substr(at, page.find("</script>", at) - at));
}

TEST(CompareCommand, WritesAPageOfTheSameNumbers) {
  const Program program;
  WriteFactor(program, "a.h5", 1, 1);
  WriteFactor(program, "b.h5", 1.08, 2);
  const Finished written = program.Run({"compare", "a.h5", "b.h5", "--page"});
  if (written.err.find("built without pages") != std::string::npos)
    GTEST_SKIP() << "this build has no pages";
  EXPECT_EQ(written.status, 4) << written.err;
  EXPECT_TRUE(written.out.starts_with("compare.html: ")) << written.out;
  EXPECT_NE(written.out.find("\nFAIL (exit status 4): "), std::string::npos) << written.out;
  nlohmann::json data = DataOf(program.Read("compare.html"));
  EXPECT_EQ(data["documents"].size(), 2u);
  nlohmann::json comparison = data["comparison"];
  EXPECT_EQ(comparison["names"], nlohmann::json({"a.h5", "b.h5"}));
  const nlohmann::json sections = comparison["benchmarks"][0]["sections"];
  EXPECT_EQ(sections[1]["lines"],
            comparison["benchmarks"][0]["comparisons"][0]["result"]);  // as on the terminal
  comparison.erase("names");
  comparison.erase("sections");
  comparison["benchmarks"][0].erase("sections");
  EXPECT_EQ(comparison,
            nlohmann::json::parse(program.Run({"compare", "a.h5", "b.h5", "--json"}).out));
  EXPECT_EQ(comparison["benchmarks"][0]["comparisons"][0]["times"]["group"], "detector");

  // A history has the sections of all benchmarks.
  EXPECT_EQ(program.Run({"compare", "a.h5", "b.h5", "a.h5", "--page", "-o", "h.html"}).status, 0);
  data = DataOf(program.Read("h.html"));
  EXPECT_FALSE(data["comparison"]["sections"].empty());
  EXPECT_EQ(data["documents"].size(), 3u);
}

TEST(CompareCommand, RefusesByName) {
  const Program program;
  WriteFactor(program, "a.h5", 1, 1);
  WriteCompared({ComparedPlan(1, {"10"}, {"simple", "sap"}, "warmup 3")},
                program.folder() / "other.h5");
  std::filesystem::create_directories(program.folder() / "empty");
  program.Write("text.h5", "no HDF5");
  const struct {
    std::vector<std::string> arguments;
    const char* why;
  } kRefusals[] = {
      {{"a.h5"}, "compare takes two or more results files, or two or more folders of them"},
      {{"a.h5", "b.h5"}, "b.h5: there is no such file; `cdb run` makes one"},
      {{"a.h5", "text.h5"}, "text.h5: is not a whole result of cdb"},
      {{"a.h5", "empty"}, "compare takes files or folders, not both: name the file in each folder"},
      {{"empty", "empty"}, "no .h5 file is in all of the folders empty, empty"},
      {{"a.h5", "a.h5", "--fail-above", "0.1"},
       "--fail-above 0.1: write 0.1% for a limit of 0.1 %, or 10% for the fraction 0.1"},
      {{"a.h5", "a.h5", "--fail-above", "physics=2%"},
       "--fail-above physics=2%: only slower, memory, accuracy have a limit"},
      {{"a.h5", "a.h5", "--fail-if", "phisics"}, "--fail-if phisics: did you mean 'physics'?"},
      {{"a.h5", "a.h5", "--allow", "what"}, "--allow what: there are slower, memory, "},
      {{"a.h5", "a.h5", "--allow", "memory", "--fail-if", "memory"},
       "--fail-if and --allow both name memory"},
      {{"a.h5", "a.h5", "--phase", "brod"},
       "--phase brod: there is no such phase; there are broad"},
      {{"a.h5", "a.h5", "--fail-above", "-1"}, "--fail-above -1: not a percentage"},
      {{"a.h5", "a.h5", "--fail-above", "some"}, "--fail-above some: not a percentage"},
      {{"a.h5", "a.h5", "--json", "--markdown"}, "choose either --markdown or --json"},
      {{"a.h5", "a.h5", "--json", "--page"}, "choose either --json or --page"},
      {{"a.h5", "a.h5", "-o", "c.html"}, "-o names the page: it needs --page"},
      {{"a.h5", "a.h5", "--page", "-o", "a.h5"}, "a.h5 is the results file; name another file"},
      {{"a.h5", "a.h5", "--relative"}, "--relative needs 3 detectors or more"},
  };
  for (const auto& [arguments, why] : kRefusals) {
    std::vector<std::string> command = {"compare"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const Finished refused = program.Run(command);
    EXPECT_EQ(refused.status, 2) << why;
    EXPECT_EQ(refused.out, "") << why;
    EXPECT_NE(refused.err.find(why), std::string::npos) << refused.err;
  }
}

}  // namespace
}  // namespace cdb::tests
