// The scenarios shipped with cdb: each compiles, has a description, and has the numbers of its
// source.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/schema.h"
#include "dsl/diagnostics.h"
#include "dsl/format.h"
#include "library/closed_forms/closed_form.h"
#include "library/layouts/initial_state.h"
#include "tests/support/diagnostics.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using ::testing::StartsWith;

const fs::path kLibrary = SourceFolder() / "library/scenarios";

std::vector<fs::path> Files() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(kLibrary))
    if (entry.path().extension() == ".cdb") files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

std::string Text(const fs::path& file) {
  std::string why;
  const auto text = compiler::ReadFromDisk(file.string(), why);
  EXPECT_TRUE(text) << file << ": " << why;
  return text.value_or("");
}

/// Returns nothing if the file has errors, and fails unless they are only about libraries that this
/// build does not have. Lints may warn about choices of a paper or of a suite.
std::vector<plan::Plan> Plans(const fs::path& file,
                              const scenario::ReadFile& read = compiler::ReadFromDisk) {
  compiler::Compilation result =
      compiler::Compile(file.string(), read, {kLibrary.string(), std::nullopt});
  if (LacksOnlyLibraries(result.diagnostics)) return {};
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  EXPECT_FALSE(result.plans.empty());
  return std::move(result.plans);
}

TEST(Scenarios, EachCompilesToBenchmarksOfNamesThatNoOtherHas) {
  std::map<std::string, fs::path> names;
  for (const fs::path& file : Files()) {
    SCOPED_TRACE(file);
    for (const plan::Plan& plan : Plans(file)) {
      const auto [other, is_new] = names.emplace(plan.benchmark, file);
      EXPECT_TRUE(is_new) << plan.benchmark << " is in " << other->second << " too";
      EXPECT_FALSE(plan.title.empty()) << plan.benchmark;
      EXPECT_FALSE(plan.runs.empty()) << plan.benchmark;
    }
  }
  EXPECT_GE(names.size(), 40u);
}

TEST(Scenarios, EachSaysInTwoLinesWhatItIsAndWhatToLookAt) {
  for (const fs::path& file : Files()) {
    SCOPED_TRACE(file);
    std::istringstream text(Text(file));
    std::string what, look, empty, rest;
    std::getline(text, what);
    std::getline(text, look);
    std::getline(text, empty);
    std::getline(text, rest);
    EXPECT_THAT(what, StartsWith("# "));
    EXPECT_LE(what.size(), 105u) << "`cdb list scenarios` shows it on one line";
    EXPECT_THAT(look, StartsWith("# Look at "));
    EXPECT_EQ(empty, "");
    EXPECT_NE(rest, "");
  }
}

TEST(Scenarios, EachIsLaidOutAsFmtDoesIt) {
  for (const fs::path& file : Files()) {
    const std::string text = Text(file);
    EXPECT_EQ(dsl::Format(text::Source(file.string(), text)), text) << file;
  }
}

TEST(Scenarios, AreFoundFromAnywhereAndLaidOver) {
  const fs::path mine = "/nowhere/mine.cdb";
  const std::string text =
      "use \"paper/experiment2\"\n"
      "benchmark mine from paper_experiment2 { cycles 10; detector dbvt }\n";
  const auto plans = Plans(mine, [&](const std::string& path, std::string& why) {
    return path == mine ? std::optional(text) : compiler::ReadFromDisk(path, why);
  });
  ASSERT_EQ(plans.size(), 1u);
  EXPECT_EQ(plans[0].runs.size(), 25u);
  EXPECT_EQ(plans[0].runs[0].scene.world.Count("cycles"), 10u);
}

TEST(Accuracy, ScenariosAreOfTheClosedFormsThatTheyName) {
  std::set<std::string> named;
  for (const fs::path& file : Files()) {
    if (file.parent_path().filename() != "accuracy") continue;
    for (const plan::Plan& plan : Plans(file))
      for (const plan::Run& run : plan.runs) {
        const std::string form(run.scene.world.WordOr("accuracy.closed_form"));
        if (form == "none") continue;
        named.insert(form);
        EXPECT_NO_THROW(
            closed_forms::MakeClosedForm(form, run.scene, layouts::MakeInitialState(run.scene)))
            << file << ": " << plan::Describe(plan, run);
      }
  }
  EXPECT_EQ(named.size(), schema::ClosedForms().size());
}

// The following expectations are written from the paper, not from the files.

schema::Value AllSix() {
  schema::Distribution any{schema::DistributionKind::kAny, {}, {1, 1, 1, 1, 1, 1}};
  for (const char* type : {"sphere", "cuboid", "cylinder", "cone", "bunny", "armadillo"})
    any.arguments.emplace_back(schema::Word{type});
  return any;
}

schema::Value Between(double a, double b) {
  return schema::Distribution{schema::DistributionKind::kUniform, {a, b}, {}};
}
schema::Value Bell(double mean, double deviation) {
  return schema::Distribution{schema::DistributionKind::kNormal, {mean, deviation}, {}};
}
/// The same along x, y and z.
schema::Value BoxOf(schema::DistributionKind kind, double a, double b) {
  const Eigen::Vector3d first = Eigen::Vector3d::Constant(a), second = Eigen::Vector3d::Constant(b);
  return schema::Distribution{kind, {first, second}, {}};
}
schema::Value BoxBetween(double a, double b) {
  return BoxOf(schema::DistributionKind::kUniform, a, b);
}
schema::Value BoxBell(double mean, double deviation) {
  return BoxOf(schema::DistributionKind::kNormal, mean, deviation);
}

/// Section 3.1: the ten parameters and their defaults, the seed, the side of the cube.
struct PaperScene {
  std::uint64_t cycles = 1000;
  std::uint64_t quantity = 10;
  schema::Value type = schema::Word{"sphere"};
  schema::Value aspect = schema::Ratio{{1, 1, 1}};
  schema::Value location = schema::Word{"uniform"};
  schema::Value size = 50.0;
  schema::Value mass = 1.0;
  schema::Value acceleration = Eigen::Vector3d(0, -9.8, 0);
  schema::Value linear_velocity = Eigen::Vector3d(0, 0, 0);
  schema::Value angular_velocity = Eigen::Vector3d(0, 0, 0);

  /// Every setting of a scene with these parameters and, where the paper is silent, the schema's
  /// defaults.
  plan::Scene With(const std::string& detector) const {
    static const plan::Plan defaults = compiler::Compile("d.cdb", [](auto&&...) {
                                         return std::optional<std::string>("benchmark d { }");
                                       }).plans.at(0);
    plan::Scene scene = defaults.runs[0].scene;
    scene.world.Set("cycles", cycles);
    scene.world.Set("acceleration", acceleration);
    scene.world.Set("seed", std::uint64_t{0xAAAAAAAAAA});
    scene.world.Set("world.side", 50.0 * static_cast<double>(quantity));
    scene.world.Set("world.walls", schema::Word{"all"});
    scene.world.Set("precision", schema::Word{"single"});
    scene.world.Set("detector", schema::Word{detector});
    scene.world.Set("omit", schema::WordList{"none"});
    auto& objects = scene.groups[0].settings;
    objects.Set("quantity", quantity);
    objects.Set("type", type);
    objects.Set("aspect", aspect);
    objects.Set("location", location);
    objects.Set("size", size);
    objects.Set("mass", mass);
    objects.Set("linear_velocity", linear_velocity);
    objects.Set("angular_velocity", angular_velocity);
    return scene;
  }
};

void ExpectSettings(const plan::Settings& settings, const plan::Settings& expected) {
  ASSERT_EQ(settings.size(), expected.size());
  for (auto at = settings.begin(); const auto& [name, value] : expected) {
    const auto& [found, its_value] = *at++;
    EXPECT_EQ(found, name);
    EXPECT_EQ(schema::ToText(its_value), schema::ToText(value)) << name;
  }
  EXPECT_TRUE(settings == expected);
}

void ExpectScene(const plan::Scene& scene, const plan::Scene& expected) {
  ExpectSettings(scene.world, expected.world);
  ASSERT_EQ(scene.groups.size(), 1u);
  EXPECT_EQ(scene.groups[0].name, "objects");
  ExpectSettings(scene.groups[0].settings, expected.groups[0].settings);
}

const char* const kThreeDetectors[] = {"simple", "sap", "dbvt"};

/// Table 1. "All parameters other than those specified are left at their defaults."
std::vector<PaperScene> Table1() {
  std::vector<PaperScene> rows(22);
  for (std::size_t i = 0; i < 5; ++i) rows[i].quantity = 1000 * (i + 1);
  for (std::size_t i = 5; i < 22; ++i) rows[i].quantity = 5000;
  rows[5].type = schema::Word{"cuboid"};
  rows[6].type = schema::Word{"cylinder"};
  rows[7].type = schema::Word{"cone"};
  rows[8].type = schema::Word{"bunny"};
  rows[9].type = schema::Word{"armadillo"};
  for (std::size_t i = 10; i < 22; ++i) rows[i].type = AllSix();
  rows[11].location = schema::Word{"normal"};
  rows[12].size = Between(50, 500);
  rows[13].size = Bell(275, 75);
  rows[14].mass = Between(1, 500);
  rows[15].mass = Bell(249.5, 83.5);
  rows[16].acceleration = BoxBetween(-250, 250);
  rows[17].acceleration = BoxBell(0, 83.333);
  rows[18].linear_velocity = BoxBetween(-250, 250);
  rows[19].linear_velocity = BoxBell(0, 83.333);
  rows[20].angular_velocity = BoxBetween(-250, 250);
  rows[21].angular_velocity = BoxBell(0, 83.333);
  return rows;
}

TEST(Paper, TimesEverything) {
  int runs = 0;
  for (const fs::path& file : Files()) {
    if (file.parent_path().filename() != "paper" || file.filename() == "today.cdb") continue;
    for (const plan::Plan& plan : Plans(file))
      for (const plan::Run& run : plan.runs) {
        EXPECT_EQ(run.scene.world.Get("omit"), schema::Value(schema::WordList{"none"})) << file;
        ++runs;
      }
  }
  EXPECT_EQ(runs, 1 + 75 + 66 + 66 + (3 + 2 * 75 + 2 * 66 + 30) + 12);
}

TEST(Paper, Experiment1) {
  const auto plans = Plans(kLibrary / "paper/experiment1.cdb");
  ASSERT_EQ(plans.size(), 1u);
  ASSERT_EQ(plans[0].runs.size(), 1u);
  PaperScene expected;
  expected.quantity = 5000;
  expected.type = AllSix();
  ExpectScene(plans[0].runs[0].scene, expected.With("sap"));
}

TEST(Paper, Experiment2) {
  const auto plans = Plans(kLibrary / "paper/experiment2.cdb");
  ASSERT_EQ(plans.size(), 1u);
  ASSERT_EQ(plans[0].runs.size(), 75u);
  PaperScene expected;
  expected.type = AllSix();
  std::size_t run = 0;
  for (expected.quantity = 1000; expected.quantity <= 5000; expected.quantity += 1000)
    for (double z = 1; z <= 5; ++z)
      for (const char* detector : kThreeDetectors) {
        expected.aspect = schema::Ratio{{1, 1, z}};
        ExpectScene(plans[0].runs[run++].scene, expected.With(detector));
      }
}

TEST(Paper, Table1) {
  const std::vector<PaperScene> rows = Table1();
  const auto experiment3 = Plans(kLibrary / "paper/experiment3.cdb");
  ASSERT_EQ(experiment3.size(), 1u);
  ASSERT_EQ(experiment3[0].runs.size(), 66u);
  std::set<std::string> files;
  for (const fs::path& file : Files()) {
    const std::string name = file.stem().string();
    if (!name.starts_with("table1_")) continue;
    SCOPED_TRACE(name);
    const std::size_t row = std::stoul(name.substr(7, 2)) - 1;
    ASSERT_LT(row, rows.size());
    files.insert(name.substr(0, 9));
    const auto plans = Plans(file);
    ASSERT_EQ(plans.size(), 1u);
    EXPECT_EQ(plans[0].benchmark, "paper_" + name);
    ASSERT_EQ(plans[0].runs.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      ExpectScene(plans[0].runs[i].scene, rows[row].With(kThreeDetectors[i]));
      EXPECT_EQ(plans[0].runs[i].id, experiment3[0].runs[3 * row + i].id) << "of experiment 3";
    }
    const std::string said = fmt::format("table 1, row {}", row + 1);
    EXPECT_NE(Text(file).find(said), std::string::npos);
  }
  EXPECT_EQ(files.size(), 22u);
}

}  // namespace
}  // namespace cdb::tests
