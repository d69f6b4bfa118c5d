// `cdb check`: errors, JSON, results files; `cdb explain`, and standard input.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "runtime/results/files/seal.h"
#include "tests/runtime/cli/small_sweep.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Json = nlohmann::json;

std::vector<Json> Lines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(Json::parse(line));
  return lines;
}

TEST(Check, JsonHasTheFieldsOfRustc) {
  const Program program;
  program.Write("a.cdb",
                "\xEF\xBB\xBF# caf\xC3\xA9 \xF0\x9F\x98\x80\nbenchmark b {\n  cycles 5\n"
                "  objects.type cuboyd\n  cycles 6\n}\n");
  const Finished check = program.Run({"check", "--json", "a.cdb"});
  EXPECT_EQ(check.status, 1);
  EXPECT_EQ(check.err, "");
  const std::vector<Json> lines = Lines(check.out);
  ASSERT_EQ(lines.size(), 2u) << check.out;
  const Json& first = lines[0];
  for (const char* field :
       {"$message_type", "message", "code", "level", "spans", "children", "rendered"})
    EXPECT_TRUE(first.contains(field)) << field;
  EXPECT_EQ(first["message"], "'type' cannot be 'cuboyd'");
  EXPECT_EQ(first["code"]["code"], "E0201");
  EXPECT_TRUE(first["code"]["explanation"].is_string());
  EXPECT_EQ(first["level"], "error");
  ASSERT_EQ(first["spans"].size(), 1u);
  const Json& span = first["spans"][0];
  EXPECT_EQ(span["file_name"], "a.cdb");
  const std::string file = program.Read("a.cdb");
  const std::size_t begin = span["byte_start"], end = span["byte_end"];
  EXPECT_EQ(file.substr(begin, end - begin), "cuboyd");
  EXPECT_EQ(span["line_start"], 4);
  EXPECT_EQ(span["line_end"], 4);
  EXPECT_EQ(span["column_start"], 16);
  EXPECT_EQ(span["column_end"], 22);
  EXPECT_EQ(span["is_primary"], true);
  EXPECT_EQ(span["text"][0]["text"], "  objects.type cuboyd");
  EXPECT_EQ(span["text"][0]["highlight_start"], 16);
  EXPECT_EQ(first["children"][0]["level"], "help");
  EXPECT_EQ(first["children"][0]["message"], "did you mean 'cuboid'?");
  EXPECT_EQ(first["rendered"].get<std::string>().find("a.cdb:4:16: error: "), 0u);
  EXPECT_EQ(lines[1]["code"]["code"], "E0204");
}

TEST(Check, JsonOfAGoodFileIsEmptyAndHasEveryErrorOfABadOne) {
  const Program program;
  program.Write("good.cdb", "benchmark b { }\n");
  program.Write("turned.cdb", "benchmark b { cycles \"\u202e\x7f\" }");
  const std::string turned = program.Run({"check", "--json", "turned.cdb"}).out;
  EXPECT_EQ(turned.find("\u202e"), std::string::npos) << turned;
  EXPECT_EQ(turned.find('\x7f'), std::string::npos) << turned;
  EXPECT_NE(turned.find("\\u202e"), std::string::npos) << turned;
  const Finished good = program.Run({"check", "--json", "good.cdb"});
  EXPECT_EQ(good.status, 0);
  EXPECT_EQ(good.out + good.err, "");
  std::string text = "benchmark b {\n";
  for (int i = 0; i < 50; ++i) text += "  colour red\n";
  program.Write("bad.cdb", text + "}\n");
  EXPECT_EQ(Lines(program.Run({"check", "--json", "bad.cdb"}).out).size(), 50u);
  program.Write("bytes.cdb", "benchmark b \"\xE9\" { colour red }\n");
  EXPECT_EQ(Lines(program.Run({"check", "--json", "bytes.cdb"}).out).size(), 1u);
}

TEST(StandardInput, IsReadByCheckFmtAndPlan) {
  const Program program;
  program.Write("good.cdb", "benchmark b{cycles   5}\n");
  program.Write("bad.cdb", "benchmark b { colour red }\n");
  EXPECT_EQ(program.Shell("$CDB check - < good.cdb").out, "<stdin>: b: 1 run\n");
  const Finished bad = program.Shell("cat bad.cdb | $CDB check -");
  EXPECT_EQ(bad.status, 1);
  EXPECT_EQ(bad.err.find("<stdin>:1:15: error: "), 0u) << bad.err;
  EXPECT_EQ(program.Shell("$CDB fmt - < good.cdb").out, "benchmark b { cycles 5 }\n");
  EXPECT_EQ(program.Shell("$CDB fmt --check - < good.cdb").status, 1);
  EXPECT_EQ(program.Shell("$CDB plan - < good.cdb").out.find("b: 1 run"), 0u);
  const Finished run = program.Shell("$CDB run - < good.cdb");
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.err.find("standard input"), std::string::npos) << run.err;
}

TEST(Explain, ShowsBothExamplesAndTheMessage) {
  const Program program;
  const Finished one = program.Run({"explain", "E0201"});
  EXPECT_EQ(one.status, 0);
  for (const char* part : {"E0201 unknown-name (error)", "WRONG", "RIGHT", "detector spa",
                           "detector sap", "wrong.cdb:1:24: error: "})
    EXPECT_NE(one.out.find(part), std::string::npos) << part << one.out;
  EXPECT_EQ(program.Run({"explain", "unknown-name"}).out, one.out);
  EXPECT_NE(program.Run({"explain"}).out.find("W0301  tall-stack"), std::string::npos);
  const Finished verdict = program.Run({"explain", "tunnelled"});
  EXPECT_EQ(verdict.status, 0) << verdict.err;
  for (const char* part :
       {"tunnelled (verdict on a run)\n", "passed through another", "\nUSUAL CAUSES\n",
        "\nREMEDIES\n", "ccd on", "More: cdb doc verdicts\n"})
    EXPECT_NE(verdict.out.find(part), std::string::npos) << part << verdict.out;
  EXPECT_NE(program.Run({"explain", "noisy"}).out.find("--retry-noisy"), std::string::npos);
  const Finished unknown = program.Run({"explain", "unknown-nme"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find("did you mean 'unknown-name'?"), std::string::npos) << unknown.err;
}

TEST(Check, AResultsFileOfAnotherPlanThanItHoldsIsDamaged) {
  const Program program;
  program.Write("a.cdb", "benchmark b {\n  cycles 5\n  repeats 2\n  objects.quantity 0\n}\n");
  ASSERT_EQ(program.Run({"run", "a.cdb", "-q", "-o", "a.h5"}).status, 0);
  std::string bytes = program.Read("a.h5");
  bytes.resize(bytes.size() - sizeof(files::Seal));
  const std::size_t place = bytes.find("\nrepeats: 2\n");
  ASSERT_NE(place, std::string::npos);
  bytes[place + 10] = '3';
  program.Write("a.h5", bytes);
  files::AppendSeal(program.folder() / "a.h5", "a.h5");
  for (const char* command : {"check", "show"}) {
    const Finished other = program.Run({command, "a.h5"});
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("its plan differs from its plan_sha256"), std::string::npos)
        << other.err;
  }
}

TEST(Check, EveryCommandSaysTheSameOfOtherRunsThanThePlanHas) {
  const Program program;
  program.Write("a.cdb", "benchmark b {\n  cycles 5\n  repeats 2\n  objects.quantity 0\n}\n");
  ASSERT_EQ(program.Run({"run", "a.cdb", "-q", "-o", "a.h5"}).status, 0);
  std::string id =
      program.Shell("\"$CDB\" plan a.cdb -o - | sed -n 's/.*\\bid: *\"*//p' | tr -d '\\n'").out;
  id.resize(16);
  std::string bytes = program.Read("a.h5");
  bytes.resize(bytes.size() - sizeof(files::Seal));
  int replaced = 0;
  for (std::size_t at = bytes.find(id); at != std::string::npos; at = bytes.find(id, at + 1)) {
    if (bytes.substr(at - 5, 5) == "id: \"") continue;  // in the plan
    bytes.replace(at, id.size(), "0123456789abcdef");
    ++replaced;
  }
  ASSERT_GT(replaced, 0);
  program.Write("a.h5", bytes);
  files::AppendSeal(program.folder() / "a.h5", "a.h5");
  for (const char* command : {"check", "show", "report"}) {
    const Finished other = program.Run({command, "a.h5"});
    EXPECT_EQ(other.status, 2) << command;
    EXPECT_NE(other.err.find("the run 0123456789abcdef where its plan has " + id),
              std::string::npos)
        << command << ": " << other.err;
  }
}

TEST(Check, AJournalHoldsReferenceRunsToo) {
  const Program program;
  program.Write("a.cdb",
                "benchmark b { cycles 5; timestep 1/60; world.side 100; objects.quantity 2\n"
                "  accuracy { metrics position; interval 1/60; reference { timestep 1/120 } } }\n");
  ASSERT_EQ(program.Run({"run", "a.cdb", "-q", "-o", "part.h5", "--shard", "1/2"}).status, 0);
  const Finished check = program.Run({"check", "part.runs/runs.journal"});
  EXPECT_EQ(check.status, 0) << check.err;
  EXPECT_NE(check.out.find("whole: a journal of "), std::string::npos) << check.out;
}

TEST(Check, AGridThatIsTooLargeIsRefusedBeforeItsValuesAreMade) {
  const Program program;
  const auto refuses = [&](const std::string& settings, const std::string& why) {
    program.Write("a.cdb", "benchmark b { " + settings + " }\n");
    // 400 MB, where the values would take more; sanitizers reserve far more for themselves.
    const std::string limit = kAnySanitizer ? "" : "ulimit -v 400000; ";
    const Finished check = program.Shell(limit + "\"$CDB\" check a.cdb");
    EXPECT_EQ(check.status, 1) << check.err;
    EXPECT_NE(check.err.find(why), std::string::npos) << check.err;
  };
  refuses("seed sweep(1 .. 1000001)", "this range has 1000001 values");
  refuses("seed sweep(1 .. 1000000, 1000001)", "this sweep has 1000001 values");
  refuses("objects.quantity sweep(1 .. 101); seed sweep(1 .. 1000000)",
          "with this sweep there are 101000000 points");
}

TEST(Check, AResultsFileIsKnownByItsContents) {
  const Program program;
  program.Write(
      "a.cdb",
      "benchmark b {\n  cycles 5\n  repeats 2\n  objects.quantity 2\n  world.side 500\n}\n");
  ASSERT_EQ(program.Run({"run", "a.cdb", "-q", "-o", "results"}).status, 0);
  const Finished whole = program.Run({"check", "a.cdb", "results"});
  EXPECT_EQ(whole.status, 0) << whole.err;
  EXPECT_NE(whole.out.find("results: whole: 2 of 2 runs, of plan "), std::string::npos)
      << whole.out;
  EXPECT_NE(whole.out.find("; every byte is as it was written\n"), std::string::npos);
  EXPECT_EQ(program.Run({"check", "--json", "results"}).status, 2);

  const std::string bytes = program.Read("results");
  for (const std::size_t place : {std::size_t{0}, bytes.size() / 2, bytes.size() - 24}) {
    std::string bent = bytes;
    bent[place] = static_cast<char>(bent[place] ^ 1);
    program.Write("results", bent);
    for (const char* command : {"check", "show", "report", "view"}) {
      const Finished damaged = program.Run({command, "results"});
      EXPECT_EQ(damaged.status, 2) << command << place;
      EXPECT_EQ(damaged.out, "") << command;
      EXPECT_NE(damaged.err.find("results"), std::string::npos) << damaged.err;
      EXPECT_NE(damaged.err.find("restore a copy"), std::string::npos) << damaged.err;
      EXPECT_EQ(std::ranges::count(damaged.err, '\n'), 1) << damaged.err;
    }
  }

  ASSERT_EQ(program.Run({"run", "a.cdb", "-q", "-o", "part.h5", "--shard", "1/2"}).status, 0);
  const Finished intact = program.Run({"check", "part.runs/runs.journal"});
  EXPECT_EQ(intact.status, 0) << intact.err;
  EXPECT_NE(intact.out.find("whole: a journal of 1 finished run of plan"), std::string::npos)
      << intact.out;
  const std::string journal = program.Read("part.runs/runs.journal");
  program.Write("cut.journal", journal.substr(0, journal.size() / 2));
  const Finished cut = program.Run({"check", "cut.journal"});
  EXPECT_EQ(cut.status, 2);
  EXPECT_NE(cut.err.find("cut.journal: is not a whole journal"), std::string::npos)
      << cut.err << cut.out;
  ASSERT_EQ(program.Run({"merge", "-o", "part.h5", "part.runs"}).status, 0);
  const Finished part = program.Run({"check", "part.h5"});
  EXPECT_EQ(part.status, 3) << part.err;
  EXPECT_NE(part.out.find("part.h5: incomplete: 1 of 2 runs"), std::string::npos) << part.out;
}

TEST(Check, SaysOnceWhatCannotBePlacedBeforeAnythingRuns) {
  const Program program;
  program.Write("out.cdb",
                "benchmark out { cycles 5; world.side 10; detector sweep(simple, sap, dbvt)\n"
                "  objects { quantity 1; size 1; location at(sweep(40, 50, 60), 0, 0) } }");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"check", "out.cdb"}, {"run", "out.cdb", "-q"}}) {
    const Finished refused = program.Run(command);
    EXPECT_EQ(refused.status, 1);
    EXPECT_EQ(refused.err,
              "out.cdb:2:42: error: object 1 of 1 (group `objects`) lies 34.5 m beyond the cube's "
              "wall +x; in 9 of 9 runs [E0223 cannot-place]\n"
              "  2 |   objects { quantity 1; size 1; location at(sweep(40, 50, 60), 0, 0) } }\n"
              "    |                                          ^^^^^^^^^^^^^^^^^^^^^^^^^^^ move it "
              "inwards or make world.side larger\n");
  }
  // If other runs can be executed, it is a warning, and failures are reported with -q as well.
  program.Write(
      "some.cdb",
      "benchmark some { cycles 5; world.side 100; objects { size 60; quantity sweep(1, 40) } }");
  const Finished checked = program.Run({"check", "some.cdb"});
  EXPECT_EQ(checked.status, 0);
  EXPECT_NE(checked.err.find(
                "warning: runs will fail: all objects together would fill 452.4 % of the cube"),
            std::string::npos)
      << checked.err;
  const Finished run = program.Run({"run", "some.cdb", "-q"});
  EXPECT_EQ(run.status, 3);
  EXPECT_NE(run.err.find("runs will fail"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("`cdb show some.h5` names them"), std::string::npos) << run.err;
}

TEST(Check, LetsObjectsTouchTheFloor) {
  const Program program;
  program.Write(
      "touch.cdb",
      "benchmark touch { cycles 30; world.side 3; omit sweep(auto, none)\n"
      "  objects { quantity 1; type cuboid; size 0.7; location at(0, -1.15, 0) }\n"
      "  objects upper { quantity 1; type cuboid; size 0.3; location at(0.2, -0.65, 0) } }");
  const Finished run = program.Run({"run", "touch.cdb", "-q"});
  EXPECT_EQ(run.status, 0) << run.err;
  const auto hashes = Hashes(program.folder() / "touch.h5");
  ASSERT_EQ(hashes.size(), 2u);
  EXPECT_EQ(hashes.begin()->second, hashes.rbegin()->second);
}

TEST(Check, RefusesWhatThisMachineCannotRun) {
  const Program program;
  program.Write("many.cdb", "benchmark many { world.side 1e9; objects.quantity 2000000000 }");
  program.Write("long.cdb",
                "benchmark long { cycles 2000000000; world.side 1e6; record pairs; "
                "objects.quantity 1000000 }");
  for (const char* command : {"check", "run"}) {
    const Finished many = program.Run({command, "many.cdb"});
    EXPECT_EQ(many.status, 2) << many.err;
    EXPECT_NE(many.err.find("its 2e+09 objects need 2 TB or more"), std::string::npos) << many.err;
    // It lists no cycles, which alone would take 16 GB.
    const std::string limit = kAnySanitizer ? "" : "ulimit -d 2000000; ";
    const Finished far = program.Shell(limit + "$CDB " + command + " long.cdb");
    EXPECT_EQ(far.status, 2);
    EXPECT_NE(far.err.find("one run records up to"), std::string::npos) << far.err;
  }
  EXPECT_FALSE(program.Exists("many.runs"));
}

TEST(Check, FindsEveryErrorAndLeavesNoFile) {
  const Program program;
  program.Write("bad.cdb", "benchmark a { cycles 0; colour red; objects.type cuboyd }\n");
  for (const char* command : {"check", "plan", "run"}) {
    const Finished finished = program.Run({command, "bad.cdb"});
    EXPECT_EQ(finished.status, 1) << command;
    EXPECT_EQ(finished.out, "") << command;
    for (const char* part : {"bad.cdb:1:22", "colour", "did you mean 'cuboid'?"})
      EXPECT_NE(finished.err.find(part), std::string::npos) << command << ": " << finished.err;
  }
  EXPECT_EQ(program.Run({"plan", "bad.cdb", "-o", "p.yaml"}).status, 1);
  EXPECT_FALSE(program.Exists("p.yaml") || program.Exists("a.h5") || program.Exists("a.runs"));
}

}  // namespace
}  // namespace cdb::tests
