#include "compiler/plan.h"

#include <gtest/gtest.h>

#include "compiler/plan_yaml.h"
#include "dsl/render.h"
#include "tests/compiler/memory_files.h"

namespace cdb::compiler {
namespace {

Plan Example() {
  const Compilation result = CompileText(
      "# a \"comment\"\t\xC3\xA4\nbenchmark b \"T: x\" { repeats 2; cycles sweep(1, 2); "
      "seed 0xFFFFFFFFFFFFFFFF\n"
      "detector sweep(simple, dbvt); timestep 1/3; objects { mass any(fixed 3, 2) } skip "
      "when cycles == "
      "2 and detector == dbvt }");
  EXPECT_EQ(dsl::Render(result.diagnostics), "");
  return result.plans.at(0);
}

/// The message of the error that reading `text` ends with.
std::string ErrorOf(const std::string& text) {
  try {
    FromYaml(text, "plan.yaml");
  } catch (const PlanError& error) {
    return error.what();
  }
  return "no error";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(PlanYaml, ReadsBackAsItWas) {
  const Plan plan = Example();
  const std::string yaml = ToYaml(plan);
  const Plan back = FromYaml(yaml, "plan.yaml");
  EXPECT_TRUE(back == plan);
  EXPECT_EQ(back.Sha256(), plan.Sha256());
  EXPECT_EQ(ToYaml(back), yaml);
  const compiler::Run& run = plan.runs.back();
  EXPECT_TRUE(RunFromYaml(RunToYaml(run), "run") == run);
}

TEST(PlanYaml, SaysWhatIsWrongAndWhere) {
  const std::string yaml = ToYaml(Example());
  EXPECT_NE(ErrorOf("").find("this is no cdb plan"), std::string::npos);
  EXPECT_NE(ErrorOf("a: [1, 2").find("plan.yaml:"), std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "cdb_plan: 2", "cdb_plan: 99")).find("format 99"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "cdb_plan: 2", "cdb_plan: 1")).find("plan again"),
            std::string::npos);
  // A word alone has the same text, and so the same id, as a list of it.
  EXPECT_NE(ErrorOf(Replaced(yaml, "omit: [auto]", "omit: auto")).find("a list of words"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "omit: [auto]", "omit: [walls]")).find("changed by hand"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "omit: [auto]", "omit: [gyro]")).find("`omit` takes auto, none"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "cycles: 1\n", "cycles: 7\n")).find("changed by hand"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "cycles: 1\n", "cycles: -7\n")).find("whole number"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "cycles: 1\n", "cicles: 1\n")).find("no parameter `cicles`"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "detector: simple", "detector: simpel")).find("detector"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "at: [0, 0]", "at: [0, 9]")).find("axes"), std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "at: [0, 0]", "at: [0]")).find("axes"), std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "rep: 0", "rep: 5")).find("changed by hand"), std::string::npos);
}

TEST(PlanHash, IsOfWhatDecidesTheResults) {
  const auto hash = [](const std::string& text) { return CompileText(text).plans.at(0).Sha256(); };
  const std::string base = hash("benchmark b { cycles sweep(1, 2) }");
  EXPECT_EQ(base, hash("# comment\nbenchmark b \"a title\" {\n  cycles sweep(1 .. 2)\n}"));
  EXPECT_NE(base, hash("benchmark b { cycles sweep(2, 1) }"));
  EXPECT_NE(base, hash("benchmark b { cycles sweep(1, 2) as c }"));
  EXPECT_NE(base, hash("benchmark b { cycles sweep(1, 2); repeats 2 }"));
}

TEST(StreamSeed, IsFrozen) {
  // Golden values: changing them would change every scene.
  EXPECT_EQ(StreamSeed(0xAAAAAAAAAA, "objects.location"), 0xe84cf39fa2a828ecu);
  EXPECT_EQ(StreamSeed(0xAAAAAAAAAA, "objects.type"), 0x61e6a31f697a1f29u);
}

TEST(Plan, KnowsItsExtents) {
  const Plan plan = Example();
  EXPECT_EQ(plan.MaxCycles(), 2u);
  EXPECT_EQ(plan.MaxObjects(), 10u);
  EXPECT_TRUE(plan.Records("timing"));
  EXPECT_FALSE(plan.Records("poses"));
  EXPECT_EQ(Describe(plan, plan.runs[1]), "cycles 1, detector simple, rep 1");
}

}  // namespace
}  // namespace cdb::compiler
