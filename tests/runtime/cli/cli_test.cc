// The command line as users see it: what is common to commands, and short commands.
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>

#include "compiler/schema/schema.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

/// Plans of format 5 listed every parameter, and their runs had other ids.
TEST(EarlierPlans, AreRead) {
  const Program program;
  const std::filesystem::path golden = SourceFolder() / "tests/golden/compiler";
  program.Write("plan.yaml", ReadFile(golden / "plans_of_format_5" / "default.b.yaml"));
  program.Write("default.cdb", ReadFile(golden / "plans" / "default.cdb"));
  // A plan, under the ids of today.
  EXPECT_EQ(program.Run({"plan", "plan.yaml"}).out, program.Run({"plan", "default.cdb"}).out);
  // Complete results.
  std::filesystem::copy_file(SourceFolder() / "library/scenarios/paper/results/paper_claims1.h5",
                             program.folder() / "old.h5");
  EXPECT_EQ(program.Run({"check", "old.h5"}).status, 0);
  EXPECT_NE(program.Run({"show", "old.h5"}).out.find("1000 cycles"), std::string::npos);
  const Finished done = program.Run({"run", "paper/claims", "-b", "paper_claims1", "-o", "old.h5"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.err.find("complete"), std::string::npos) << done.err;
  const Finished retried = program.Run(
      {"run", "paper/claims", "-b", "paper_claims1", "-o", "old.h5", "--retry", "noisy"});
  EXPECT_EQ(retried.status, 2);
  EXPECT_NE(retried.err.find("results of an earlier cdb"), std::string::npos) << retried.err;
}

TEST(EarlierPlans, AStartedSweepIsRefusedAndKept) {
  const Program program;
  const std::filesystem::path golden = SourceFolder() / "tests/golden/compiler";
  program.Write("default.cdb", ReadFile(golden / "plans" / "default.cdb"));
  std::filesystem::create_directory(program.folder() / "default.runs");
  const std::string plan = ReadFile(golden / "plans_of_format_5" / "default.b.yaml");
  program.Write("default.runs/plan.yaml", plan);
  program.Write("default.runs/1fb6691c8206a52a.h5", "finished by the earlier cdb");
  const Finished run = program.Run({"run", "default.cdb", "-o", "default.h5"});
  EXPECT_EQ(run.status, 2);
  for (const char* part : {"1fb6691c8206a52a.h5 was written by an earlier version of cdb",
                           "end the sweep with that version", "--fresh"})
    EXPECT_NE(run.err.find(part), std::string::npos) << part << "\n" << run.err;
  const Finished merged = program.Run({"merge", "-o", "default.h5", "default.runs"});
  EXPECT_EQ(merged.status, 2);
  EXPECT_NE(merged.err.find("merge the runs beside it with that cdb"), std::string::npos)
      << merged.err;
  EXPECT_EQ(program.Read("default.runs/plan.yaml"), plan);
  EXPECT_TRUE(program.Exists("default.runs/1fb6691c8206a52a.h5"));
}

TEST(Lints, AreWholeInCheckALineInPlanAndRunAndSilentInQuiet) {
  const Program program;
  program.Write("small.cdb", "benchmark b { cycles 3; objects.size 0.01 }\n");
  const Finished check = program.Run({"check", "small.cdb"});
  EXPECT_EQ(check.status, 0);
  EXPECT_NE(check.err.find("small.cdb:1:38: warning: "), std::string::npos) << check.err;
  const char* line =
      "small.cdb: Bullet may not simulate this accurately: long-step (line 1); `cdb check "
      "small.cdb` explains why\n";
  EXPECT_EQ(program.Run({"plan", "small.cdb"}).err, line);
  EXPECT_NE(program.Run({"run", "small.cdb"}).err.find(line), std::string::npos);
  EXPECT_EQ(program.Run({"run", "-q", "--fresh", "small.cdb"}).err, "");
}

TEST(Format, LaysOutInPlace) {
  const Program program;
  program.Write("x.cdb", "benchmark b{cycles 5;   objects.size 3 # s\n}");
  EXPECT_EQ(program.Run({"fmt", "--check", "x.cdb"}).status, 1);
  EXPECT_EQ(program.Run({"fmt", "x.cdb"}).status, 0);
  EXPECT_EQ(program.Run({"fmt", "--check", "x.cdb"}).status, 0);
  EXPECT_EQ(program.Run({"check", "x.cdb"}).status, 0);
}

TEST(Doc, KnowsEveryParameter) {
  const Program program;
  const Finished all = program.Run({"doc", "parameters"});
  EXPECT_EQ(all.status, 0);
  int commands = 0;
  for (const auto& parameter : schema::Schema()) {
    EXPECT_NE(all.out.find(parameter.FullName()), std::string::npos);
    if (kAnySanitizer && commands++ % 10 != 0) continue;  // they take the same path
    EXPECT_EQ(program.Run({"doc", parameter.FullName()}).status, 0) << parameter.name;
  }
  for (const char* topic :
       {"language", "omit", "accuracy", "results", "objects", "detectors", "layouts", "scenarios"})
    EXPECT_GT(program.Run({"doc", topic}).out.size(), 20u) << topic;
  const Finished omit = program.Run({"doc", "omit"});
  // The texts are wrapped in their columns.
  const auto beginning = [](std::string_view text) { return text.substr(0, text.find(' ')); };
  for (const auto& component : schema::Components())
    for (const std::string_view part :
         {component.name, beginning(component.doc), beginning(component.changes)})
      EXPECT_NE(omit.out.find(part), std::string::npos) << part;
  EXPECT_NE(omit.out.find("default  auto"), std::string::npos) << "the parameter as well";
  EXPECT_EQ(program.Run({"doc", "detecter"}).status, 2);
  EXPECT_EQ(program.Run({"list", "detectors"}).status, 0);
}

TEST(Examples, AreWellWrittenAndSayWhatTheyAre) {
  const Program program;
  const std::filesystem::path examples = SourceFolder() / "examples";
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(examples)) {
    if (entry.path().extension() != ".cdb") continue;
    ++count;
    const std::string file = entry.path().string();
    const Finished check = program.Run({"check", file});
    if (check.err.find("this build reads no ") != std::string::npos) {
      std::cout << "skipped: " << file << " needs a reader of robots (./setup --import)\n";
      continue;
    }
    EXPECT_EQ(check.status, 0) << check.err;
    EXPECT_EQ(check.err.find("error:"), std::string::npos) << check.err;  // lints may warn
    EXPECT_EQ(program.Run({"fmt", "--check", file}).status, 0) << file;
    const auto text = program.Shell("head -2 '" + file + "'").out;
    EXPECT_EQ(text.find("# "), 0u) << file;
    EXPECT_NE(text.find("\n# Look at "), std::string::npos) << file;
  }
  EXPECT_GE(count, 5);
}

TEST(CommandLine, RefusesByName) {
  const Program program;
  EXPECT_EQ(program.Run({}).status, 2);
  EXPECT_EQ(program.Run({"runn"}).status, 2);
  EXPECT_EQ(program.Run({"--version"}).status, 0);
  program.Write("b.cdb", "benchmark b { }");
  EXPECT_EQ(program.Run({"run", "b.cdb", "--shard", "3/2"}).status, 2);
  EXPECT_EQ(program.Run({"run", "b.cdb", "-j", "0"}).status, 2);
  EXPECT_FALSE(program.Exists("b.h5"));
}

}  // namespace
}  // namespace cdb::tests
