#include "compiler/plan/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

plan::Plan Example() {
  const compiler::Compilation result = CompileText(
      "# a \"comment\"\t\xC3\xA4\nbenchmark b \"T: x\" { repeats 2; cycles sweep(1, 2); "
      "seed 0xFFFFFFFFFFFFFFFF\n"
      "detector sweep(simple, dbvt); timestep 1/3; omit none; objects { mass any(fixed 3, 2) } "
      "skip "
      "when cycles == "
      "2 and detector == dbvt }");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.at(0);
}

/// The message of the error with which reading `text` fails.
std::string ErrorOf(const std::string& text) {
  try {
    yaml::FromYaml(text, "plan.yaml");
  } catch (const yaml::PlanError& error) {
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
  const plan::Plan plan = Example();
  const std::string yaml = yaml::ToYaml(plan);
  const plan::Plan back = yaml::FromYaml(yaml, "plan.yaml");
  EXPECT_TRUE(back == plan);
  EXPECT_EQ(back.Sha256(), plan.Sha256());
  EXPECT_EQ(yaml::ToYaml(back), yaml);
  const plan::Run& run = plan.runs.back();
  EXPECT_TRUE(yaml::RunFromYaml(yaml::RunToYaml(run), "run") == run);
}

plan::Plan PluginsExample(
    const std::string& library = "mine 100 broad\ntouch 0 narrow\nspare 0 broad\n",
    const std::string& path = "lib/mi ne.so") {
  const compiler::Compilation result =
      CompileText("use detector \"" + path +
                      "\"\nbenchmark b { detector sweep(mine, dbvt); narrow_phase touch }",
                  {{path, library}});
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.at(0);
}

// Mutations of plans that are rejected anyway would test little.
TEST(PlanYaml, ReadsTheCorpusOfItsFuzzer) {
  for (const auto& entry :
       std::filesystem::directory_iterator(SourceFolder() / "tests/fuzz/corpus_plan"))
    EXPECT_NO_THROW(yaml::FromYaml(ReadFile(entry.path()), entry.path()));
}

TEST(PlanYaml, ReadsPluginsBack) {
  const plan::Plan plan = PluginsExample();
  const std::string yaml = yaml::ToYaml(plan);
  EXPECT_TRUE(yaml::FromYaml(yaml, "plan.yaml") == plan);
  EXPECT_EQ(yaml::ToYaml(yaml::FromYaml(yaml, "plan.yaml")), yaml);
  EXPECT_TRUE(yaml::RunFromYaml(yaml::RunToYaml(plan.runs[0]), "run") == plan.runs[0]);
  // A run lists only the detectors that it uses.
  const auto& first = plan.runs[0].scene.plugins;
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].name, "mine");
  EXPECT_EQ(first[0].path, "lib/mi ne.so");
  EXPECT_EQ(first[0].max_bodies, 100u);
  EXPECT_EQ(first[1].phases, "narrow");
  EXPECT_EQ(plan.runs[1].scene.plugins.size(), 1u);
}

TEST(PlanYaml, RefusesPluginsThatDoNotFit) {
  const std::string yaml = yaml::ToYaml(PluginsExample());
  EXPECT_NE(ErrorOf(Replaced(yaml, "phases: broad", "phases: wide")).find("no phases `wide`"),
            std::string::npos);
  EXPECT_NE(
      ErrorOf(Replaced(yaml, "      touch:\n", "      other:\n")).find("`narrow_phase` takes"),
      std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "detector: mine", "detector: dbvt")).find("does not use it"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "      mine:\n", "      dbvt:\n")).find("two detectors `dbvt`"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "max_bodies: 100", "max_bodies: 101")).find("changed by hand"),
            std::string::npos);
}

TEST(PlanYaml, ReadsJointsBackAndRefusesThoseThatCannotBe) {
  const compiler::Compilation result = CompileText(
      "benchmark b { objects a { quantity 2 } objects c { quantity 2; location uniform }\n"
      "joints elbow { parent a; child c; type hinge; damping sweep(1, 2); at (0, 1, 0) }\n"
      "joints { child a; type ball } }");
  ASSERT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  const plan::Plan& plan = result.plans.at(0);
  EXPECT_EQ(plan.axes.at(0).name, "elbow_damping");
  EXPECT_EQ(plan.axes[0].unit, "N m s/rad");
  const std::string yaml = yaml::ToYaml(plan);
  EXPECT_TRUE(yaml::FromYaml(yaml, "plan.yaml") == plan);
  for (const plan::Run& run : plan.runs) EXPECT_EQ(run.id, plan::RunId(run.scene, run.rep));
  EXPECT_NE(plan.runs[0].id, plan.runs[1].id);
  EXPECT_NE(ErrorOf(Replaced(yaml, "joints.parent: a", "joints.parent: d")).find("no group `d`"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "joints.child: c", "joints.child: a")).find("joins a to itself"),
            std::string::npos);
  EXPECT_NE(
      ErrorOf(Replaced(yaml, "joints.damping: 1", "damping: 1")).find("no parameter `damping`"),
      std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "joints.damping: 1", "size: 1")).find("no parameter `size`"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "joints.damping: 1", "joints.damping: 3")).find("by hand"),
            std::string::npos);
}

TEST(RunId, IsOfTheLibraryToo) {
  const plan::Plan plan = PluginsExample();
  const plan::Plan again = PluginsExample();
  EXPECT_EQ(plan.Sha256(), again.Sha256());
  const plan::Plan changed = PluginsExample("mine 100 broad\ntouch 0 narrow\nspare 7 broad\n");
  const plan::Plan moved =
      PluginsExample("mine 100 broad\ntouch 0 narrow\nspare 0 broad\n", "mine.so");
  for (const plan::Plan* other : {&changed, &moved}) {
    EXPECT_NE(plan.runs[0].id, other->runs[0].id);
    EXPECT_NE(plan.runs[1].id, other->runs[1].id);
  }
}

plan::Plan WordsExample() {
  const compiler::Compilation result = CompileText(
      "benchmark b { acceleration every(60, uniform((-1, -1, -1), (1, 1, 1)))\n"
      "objects { location stack(height: 4, spacing: 3); type any(mesh(\"a \\\"\\n\\tb.obj\") 3, "
      "cone)\n"
      "angular_velocity rotating((1, 0, 0), (0, 0, 1), 4) } }",
      {{"a \"\n\tb.obj", "v 0 0 0"}});
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.at(0);
}

TEST(PlanYaml, ReadsWordsWithArgumentsBack) {
  const plan::Plan plan = WordsExample();
  const plan::Plan back = yaml::FromYaml(yaml::ToYaml(plan), "plan.yaml");
  EXPECT_TRUE(back == plan);
  EXPECT_EQ(yaml::ToYaml(back), yaml::ToYaml(plan));
  // The values in a plan mean the same in a scenario.
  const plan::GroupSettings& objects = plan.runs[0].scene.groups[0].settings;
  const std::string text = "benchmark b { acceleration " +
                           schema::ToText(plan.runs[0].scene.world.Get("acceleration")) +
                           "\nobjects { location " + schema::ToText(objects.Get("location")) +
                           "; type " + schema::ToText(objects.Get("type")) + "; angular_velocity " +
                           schema::ToText(objects.Get("angular_velocity")) + " } }";
  const compiler::Compilation again = CompileText(text, {{"a \"\n\tb.obj", "v 0 0 0"}});
  EXPECT_EQ(dsl::Render(again.diagnostics), "");
  EXPECT_EQ(again.plans.at(0).runs[0].id, plan.runs[0].id);
}

/// In any order, because one writer may get the runs of several plans: references, plug-ins,
/// groups.
TEST(RunText, IsThatOfARunAlone) {
  std::vector<plan::Run> runs;
  for (const plan::Plan& plan : {Example(), PluginsExample(), WordsExample(), Example()})
    for (const plan::Run& run : plan.runs) runs.push_back(run);
  runs.push_back(runs.front());
  runs.back().scene.role = plan::Role::kReference;
  yaml::RunText text("");
  for (int round = 0; round < 2; ++round) {
    for (const plan::Run& run : runs) EXPECT_EQ(text.YamlOf(run), yaml::RunToYaml(run)) << run.id;
    std::ranges::reverse(runs);
  }
}

TEST(RunText, TellsZerosOfDifferentSignApart) {
  plan::Run run = Example().runs[0];
  run.scene.groups[0].settings.Set("linear_velocity", Eigen::Vector3d(0.0, 1, 0));
  plan::Run other = run;
  other.scene.groups[0].settings.Set("linear_velocity", Eigen::Vector3d(-0.0, 1, 0));
  ASSERT_NE(yaml::RunToYaml(run), yaml::RunToYaml(other));
  yaml::RunText text("");
  for (const plan::Run* one : {&run, &other, &run})
    EXPECT_EQ(text.YamlOf(*one), yaml::RunToYaml(*one));
}

TEST(PlanYaml, HoldsWhatDiffersFromTheDefaults) {
  const auto plan_of = [](const std::string& text) {
    const compiler::Compilation result =
        CompileText("benchmark b { objects { size 2 " + text + " } objects dust { size 1 } }");
    EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
    return result.plans.at(0);
  };
  const plan::Plan plain = plan_of(""),
                   same = plan_of("; collides_with all; friction 1 / 2; type sphere"),
                   filtered = plan_of("; collides_with walls, dust");
  const std::string yaml = yaml::ToYaml(plain);
  EXPECT_EQ(
      yaml.substr(yaml.find("    world:"), yaml.find("    seeds:") - yaml.find("    world:")),
      "    world:\n      world.side: 1000\n    groups:\n      - name: objects\n        size: 2\n"
      "      - name: dust\n        size: 1\n");
  EXPECT_EQ(plain.runs[0].id, same.runs[0].id);
  EXPECT_NE(plain.runs[0].id, filtered.runs[0].id);
  EXPECT_NE(yaml::ToYaml(filtered).find("collides_with: [dust, walls]"), std::string::npos);
  for (const plan::Plan& plan : {plain, same, filtered})
    EXPECT_TRUE(yaml::FromYaml(yaml::ToYaml(plan), "plan.yaml") == plan);
  EXPECT_NE(ErrorOf(Replaced(yaml, "      world.side: 1000\n", "      {}\n")).find("is missing"),
            std::string::npos);
}

// Listed defaults are dropped, so this also fails if a row's first default changes, which ids of
// runs rely on: state the new one in `later_default`.
TEST(PlanYaml, ReadsTheFormatThatListedEveryParameter) {
  const auto folder = SourceFolder() / "tests/golden/compiler/plans_of_format_5";
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string text = ReadFile(entry.path()), name = entry.path().filename().string();
    EXPECT_EQ(yaml::FindPlanVersion(text), 5);
    plan::Plan plan = yaml::FromYaml(text, name);
    EXPECT_NE(text.find("id: \"" + plan.runs.at(0).id), std::string::npos);
    EXPECT_EQ(yaml::FindBriefRuns(text)->at(0).id, plan.runs[0].id);
    plan.Renew();
    const plan::Plan now = yaml::FromYaml(
        ReadFile(SourceFolder() / "tests/fuzz/corpus_plan" / name), "the same in this format");
    EXPECT_TRUE(plan == now) << name;
    EXPECT_EQ(plan.Sha256(), now.Sha256()) << name;
    EXPECT_NE(ErrorOf(Replaced(text, "rolling_friction: 0", "rolling_friction: 10"))
                  .find("changed by hand"),
              std::string::npos);
    ++count;
  }
  EXPECT_EQ(count, 5);
}

TEST(PlanYaml, ReadsPointsBack) {
  const compiler::Compilation result = CompileText(
      "benchmark b { objects { location sweep(at((0.1, 0, -3), (1e9, 2, 3)), at(1, 2, 3)) } }");
  ASSERT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  const std::string yaml = yaml::ToYaml(result.plans.at(0));
  EXPECT_NE(yaml.find("location: {at: [[0.1, 0, -3], [1000000000, 2, 3]]}"), std::string::npos)
      << yaml;
  EXPECT_NE(yaml.find("location: {at: {x: 1, y: 2, z: 3}}"), std::string::npos);
  EXPECT_TRUE(yaml::FromYaml(yaml, "plan.yaml") == result.plans.at(0));
}

TEST(PlanYaml, HoldsWordsAgainstTheirRow) {
  const std::string yaml = yaml::ToYaml(WordsExample());
  const std::string stack = "{stack: {height: 4, gap: fit, spacing: 3}}";
  const auto error = [&](const std::string& location) {
    return ErrorOf(Replaced(yaml, stack, location));
  };
  const std::pair<const char*, const char*> rows[] = {
      {"{stack: {height: 4, gap: fit}}", "the 3 arguments of `stack`"},
      {"{stack: {height: 4, gap: fit, spacing: 3, x: 1}}", "the 3 arguments of `stack`"},
      {"{stack: {height: 4, gap: fit, x: 1}}", "`spacing` is missing"},
      {"{stack: [4, fit, 3]}", "the 3 arguments of `stack`"},
      {"stack", "`location` takes one of uniform"},
      {"{stack: {height: 0, gap: fit, spacing: 3}}", "`height` takes a whole number, 1 or more"},
      {"{stack: {height: 4, gap: fitt, spacing: 3}}", "`fitt` is not a finite number"},
      {"{stack: {height: 4, gap: fit, spacing: {uniform: [1, 2]}}}", "cannot be drawn"},
      {"{stack: {height: 4, gap: fit, spacing: 4}}", "changed by hand"},
      {"{mesh: {file: \"a.obj\", sha256: any}}", "`location` takes one of uniform"},
      {"{stakc: {height: 4}}", "cannot be drawn"},
      {"{at: []}", "`at` needs a point"},
      {"{at: [[0, 0, 0], [1, 2]]}", "expected three numbers"},
      {"{at: [[0, 0, 0], [1, 2, 3]]}", "changed by hand"},
      {"{}", "expected a distribution or a word"},
  };
  for (const auto& [location, message] : rows)
    EXPECT_NE(error(location).find(message), std::string::npos) << error(location);
  const std::string turning = "{rotating: {vector: [1, 0, 0], about: [0, 0, 1], period: 4}}";
  EXPECT_NE(ErrorOf(Replaced(yaml, turning,
                             "{rotating: {vector: [1, 0, 0], about: [0, 0, 0], period: 4}}"))
                .find("`about` takes a vector (x, y, z) other than 0"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, turning, "{any: [[" + turning + ", 1]]}"))
                .find("cannot last for the whole run"),
            std::string::npos);
}

TEST(PlanYaml, SaysWhatIsWrongAndWhere) {
  const std::string yaml = yaml::ToYaml(Example());
  EXPECT_NE(ErrorOf("").find("this is not a plan of cdb"), std::string::npos);
  EXPECT_NE(ErrorOf("a: [1, 2").find("plan.yaml:"), std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "cdb_plan: 6", "cdb_plan: 99")).find("format 99"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "cdb_plan: 6", "cdb_plan: 2")).find("plan again"),
            std::string::npos);
  // A single word has the same text, and so the same id, as a list with only this word.
  EXPECT_NE(ErrorOf(Replaced(yaml, "omit: [none]", "omit: none")).find("a list of words"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "omit: [none]", "omit: [walls]")).find("changed by hand"),
            std::string::npos);
  EXPECT_NE(ErrorOf(Replaced(yaml, "omit: [none]", "omit: [gyro]")).find("`omit` takes auto, none"),
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

TEST(PlanYaml, HoldsNamesToTheRuleOfTheLanguage) {
  const std::string yaml = yaml::ToYaml(Example());
  const std::string name = "benchmark: \"" + Example().benchmark + "\"";
  ASSERT_NE(yaml.find(name), std::string::npos);
  for (const char* wrong :
       {"../../escaped", "/tmp/escaped", "..", "", "a b", "1st", "\u202eb", "a\\n", "caf\u00e9"})
    EXPECT_NE(ErrorOf(Replaced(yaml, name, std::string("benchmark: \"") + wrong + "\""))
                  .find("a name consists of letters, digits and _"),
              std::string::npos)
        << wrong;
  EXPECT_NE(ErrorOf(Replaced(yaml, "name: cycles", "name: \"../cycles\"")).find("is not a name"),
            std::string::npos);
  yaml::ShortPlan form;
  form.benchmark = "../../escaped";
  EXPECT_THROW(yaml::FindShortPlan(yaml::ToYaml(form), "short.yaml"), yaml::PlanError);
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
  EXPECT_EQ(plan::StreamSeed(0xAAAAAAAAAA, "objects.location"), 0xe84cf39fa2a828ecu);
  EXPECT_EQ(plan::StreamSeed(0xAAAAAAAAAA, "objects.type"), 0x61e6a31f697a1f29u);
}

TEST(Plan, KnowsItsExtents) {
  const plan::Plan plan = Example();
  EXPECT_EQ(plan.MaxCycles(), 2u);
  EXPECT_EQ(plan.MaxObjects(), 10u);
  EXPECT_TRUE(plan.Records("timing"));
  EXPECT_FALSE(plan.Records("poses"));
  EXPECT_EQ(plan::Describe(plan, plan.runs[1]), "cycles 1, detector simple, rep 1");
}

}  // namespace
}  // namespace cdb::tests
