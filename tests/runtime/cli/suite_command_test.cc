// The standard suite: its set of scenes, a run of some of them, and the rejection of results that
// are incomplete, not comparable, or tampered with.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "runtime/cli/options/inputs.h"
#include "runtime/cli/plans/suite_plan.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

TEST(StandardSuite, HasARowForEachFileAndAFileForEachRow) {
  const fs::path folder = fs::path(options::ScenarioLibrary()) / "standard";
  std::set<std::string> files, rows;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".cdb")
      files.insert(fs::relative(entry.path(), folder).replace_extension());
  for (const figures::StandardScene& scene : figures::StandardScenes()) rows.insert(scene.Id());
  EXPECT_EQ(files, rows);
  EXPECT_GE(rows.size(), 10u);
  EXPECT_LE(rows.size(), 17u);
}

TEST(StandardSuite, ScenesOfAKindSweepTheSameConfigurations) {
  std::map<std::string_view, std::vector<plan::Axis>> of_kind;
  for (const figures::StandardScene& scene : figures::StandardScenes()) {
    const plan::Plan plan = plans::StandardPlan(scene, {});
    const auto [there, is_new] = of_kind.try_emplace(scene.kind, plan.axes);
    EXPECT_EQ(plan.axes, there->second) << scene.Id();
    EXPECT_EQ(plan.repeats, 5u) << scene.Id();
    const plan::Scene& baseline = plan.runs[0].scene;
    const auto is = [](const schema::Value& value, const char* word) {
      return value == schema::Value(schema::Word{word});
    };
    EXPECT_TRUE(is(baseline.world.Get("detector"), "dbvt")) << scene.Id();
    EXPECT_TRUE(is(baseline.world.Get("narrow_phase"), "own")) << scene.Id();
    EXPECT_TRUE(is(baseline.world.Get("coordinates"), "maximal")) << scene.Id();
    for (const plan::Run& run : plan.runs) {
      EXPECT_FALSE(std::holds_alternative<schema::Word>(run.scene.world.Get("timeout")))
          << scene.Id() << " may run for ever";
      EXPECT_TRUE(run.scene.world.Lists("record", "timing")) << scene.Id();
      EXPECT_TRUE(run.scene.world.Lists("record", "stability")) << scene.Id();
    }
  }
  EXPECT_EQ(of_kind.size(), figures::SuiteKinds().size());
}

TEST(StandardSuite, PlansOfAVersionStayAsTheyAre) {
  std::string plans;
  for (const figures::StandardScene& scene : figures::StandardScenes())
    for (const bool is_long : {false, true})
      plans += fmt::format("{} {} {} bound {} {}\n", scene.Id(), is_long ? "long" : "short",
                           plans::StandardPlan(scene, {.is_long = is_long}).Sha256(), scene.bound,
                           protocol::VerdictName(scene.worst_verdict));
  const fs::path golden = SourceFolder() / "tests" / "golden" / "suite" /
                          fmt::format("version_{}.txt", figures::kSuiteVersion);
  const char* update = std::getenv("CDB_UPDATE_GOLDEN");
  if (!fs::exists(golden) && update != nullptr && std::string(update) == "1")
    WriteFile(golden, plans);
  ASSERT_TRUE(fs::exists(golden)) << "run this test with CDB_UPDATE_GOLDEN=1";
  EXPECT_EQ(plans, ReadFile(golden))
      << "results of before and after this change are not comparable: raise kSuiteVersion";
}

TEST(StandardSuite, AFreshSeedAndFurtherDetectorsMakeOtherRuns) {
  const figures::StandardScene& scene = figures::StandardScenes()[0];
  const plan::Plan plan = plans::StandardPlan(scene, {}),
                   fresh = plans::StandardPlan(scene, {.seed = 7}),
                   more = plans::StandardPlan(scene, {.detectors = {"kd_tree"}});
  std::set<std::string> ids, wider;
  for (const plan::Run& run : plan.runs) ids.insert(run.id);
  for (const plan::Run& run : fresh.runs) {
    EXPECT_FALSE(ids.contains(run.id));
    EXPECT_EQ(run.scene.seeds.at("objects.location"), plan::StreamSeed(7, "objects.location"));
  }
  for (const plan::Run& run : more.runs) wider.insert(run.id);
  EXPECT_EQ(wider.size(), ids.size() + 5);
  for (const std::string& id : ids) EXPECT_TRUE(wider.contains(id));
  // Every point of the grid is run or skipped.
  for (const plan::Plan& made : {more, plans::StandardPlan(scene, {.is_long = true})}) {
    std::size_t points = 1;
    for (const plan::Axis& axis : made.axes) points *= axis.values.size();
    std::set<std::vector<std::size_t>> all(made.skipped.begin(), made.skipped.end());
    EXPECT_EQ(all.size(), made.skipped.size());
    for (const plan::Run& run : made.runs) all.insert(run.at);
    EXPECT_EQ(all.size(), points);
    EXPECT_EQ(made.runs.size(), (points - made.skipped.size()) * made.repeats);
  }
}

TEST(StandardSuite, HasTheNarrowPhaseBatchBesideThatOfBullet) {
  for (const figures::StandardScene& scene : figures::StandardScenes()) {
    if (scene.kind == "stiff" || scene.kind == "soft") continue;
    const plan::Plan plan = plans::StandardPlan(scene, {});
    std::set<std::string> with_own, with_batch;
    for (const plan::Run& run : plan.runs) {
      const auto detector = std::get<schema::Word>(run.scene.world.Get("detector")).text;
      const auto narrow = std::get<schema::Word>(run.scene.world.Get("narrow_phase")).text;
      (narrow == "batch" ? with_batch : with_own).insert(detector);
    }
    EXPECT_TRUE(with_own.contains("auto")) << scene.Id();
    EXPECT_EQ(with_batch, std::set<std::string>{"auto"}) << scene.Id();
  }
}

/// One scene of each kind for a few cycles; a pile would have to settle first.
TEST(StandardSuite, ScenesOfEveryKindRun) {
  const Program program;
  std::string text;
  for (const char* scene : {"games/debris", "granular/drum", "robotics/warehouse", "haptics/probe",
                            "planning/clutter", "extreme/large_world", "joints/ragdolls"}) {
    const std::string name = std::string(scene).substr(std::string(scene).find('/') + 1);
    text += fmt::format("use \"standard/{}\"\n", scene);
    text += fmt::format(
        "benchmark {0} from standard_{0} {{ cycles 3; warmup 0; repeats 1\n"
        "  detector sweep(dbvt, auto); accuracy.metrics none }}\n",
        name);
  }
  program.Write("all.cdb", text);
  for (const char* name :
       {"debris", "drum", "warehouse", "probe", "clutter", "large_world", "ragdolls"}) {
    const Finished run = program.Run({"run", "-q", "all.cdb", "-b", name});
    EXPECT_EQ(run.status, 0) << name << '\n' << run.out << run.err;
  }
}

class SuiteResults : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    program_ = std::make_unique<Program>();
    run_ = program_->Run({"suite", "--only", "pendulum,bounce", "-o", "out"});
  }
  static void TearDownTestSuite() { program_.reset(); }

  /// A copy to be modified.
  static fs::path Copy(const std::string& name) {
    fs::copy(program_->folder() / "out", program_->folder() / name);
    return program_->folder() / name;
  }
  static void ExpectSays(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nis not in\n" << text;
  }

  static inline std::unique_ptr<Program> program_;
  static inline Finished run_;
};

TEST_F(SuiteResults, AreScoredAndWritten) {
  EXPECT_EQ(run_.status, 0) << run_.err;
  ExpectSays(run_.out, fmt::format("Standard suite {}, short", figures::kSuiteVersion));
  ExpectSays(run_.out, "stiff: settings of Bullet");
  ExpectSays(run_.out, "\n  bullet");
  ExpectSays(run_.out, "steps_240");
  // The ball loses its energy in small steps.
  ExpectSays(run_.out, "bounce: drifting from cycle");
  ExpectSays(run_.out, "Not a complete suite, without games/debris");
  EXPECT_TRUE(program_->Exists("out/suite.json"));
  const bool has_pages = (run_.out + run_.err).find("built without pages") == std::string::npos;
  EXPECT_EQ(program_->Exists("out/suite.html"), has_pages);
  // Finished runs are not run again.
  const Finished again = program_->Run({"suite", "--only", "pendulum,bounce", "-o", "out"});
  EXPECT_EQ(again.out, run_.out);
  ExpectSays(again.err, "is complete");
}

TEST_F(SuiteResults, ThatAreIncompleteAreRefusedByName) {
  const Finished check = program_->Run({"suite", "--check", "out"});
  EXPECT_EQ(check.status, 3) << check.err;
  ExpectSays(check.out, "Not complete and comparable");
  ExpectSays(check.out, "games/debris: there are no results");
  EXPECT_EQ(check.out.find("stiff/bounce: there are no results"), std::string::npos) << check.out;
  const Finished none = program_->Run({"suite", "--check", "nowhere"});
  EXPECT_EQ(none.status, 2);
  ExpectSays(none.err, "'nowhere' has no results of the standard suite");
}

TEST_F(SuiteResults, ThatAreTamperedWithAreRefusedByName) {
  const fs::path spoilt = Copy("spoilt");
  std::string bytes = ReadFile(spoilt / "standard_bounce.h5");
  bytes[bytes.size() / 2] ^= 1;
  WriteFile(spoilt / "standard_bounce.h5", bytes);
  const Finished check = program_->Run({"suite", "--check", "spoilt"});
  EXPECT_EQ(check.status, 2) << check.out;
  ExpectSays(check.err, "standard_bounce.h5");

  const fs::path better = Copy("better");
  std::string summary = ReadFile(better / "suite.json");
  const std::string was = fmt::format("\"suite\": {}", figures::kSuiteVersion);
  summary.replace(summary.find(was), was.size(),
                  fmt::format("\"suite\": {}", figures::kSuiteVersion + 1));
  WriteFile(better / "suite.json", summary);
  const std::string versions =
      fmt::format("of version {} of the suite, and this cdb has version {}",
                  figures::kSuiteVersion + 1, figures::kSuiteVersion);
  ExpectSays(program_->Run({"suite", "--check", "better"}).out, "suite.json: it is " + versions);
  const Finished against = program_->Run({"suite", "--against", "better", "-o", "out"});
  EXPECT_EQ(against.status, 2);
  ExpectSays(against.err, "the results in 'better' are " + versions);
  std::string faster = ReadFile(program_->folder() / "out" / "suite.json");
  faster.insert(faster.find("\"speedup\": ") + 11, "9");
  WriteFile(better / "suite.json", faster);
  ExpectSays(program_->Run({"suite", "--check", "better"}).out,
             "suite.json: it is not the summary of these results");
  fs::remove(better / "suite.json");
  ExpectSays(program_->Run({"suite", "--check", "better"}).out, "suite.json: ");
}

TEST_F(SuiteResults, OfOtherRunsAreRefusedByName) {
  program_->Write("short.cdb",
                  "use \"standard/stiff/pendulum\"\n"
                  "benchmark standard_p from standard_pendulum { repeats 2; solver.erp 0.3 }\n");
  fs::create_directory(program_->folder() / "own");
  ASSERT_EQ(
      program_
          ->Run({"run", "-q", "short.cdb", "-b", "standard_p", "-o", "own/standard_pendulum.h5"})
          .status,
      0);
  ExpectSays(
      program_->Run({"suite", "--check", "own"}).out,
      fmt::format("stiff/pendulum: it is not of version {} of the suite", figures::kSuiteVersion));
  ExpectSays(program_->Run({"suite", "--only", "pendulum", "-o", "own", "-q"}).err, "another plan");
}

TEST_F(SuiteResults, AreVerifiedByThoseOfAnotherRun) {
  ASSERT_EQ(program_->Run({"suite", "--only", "pendulum", "-o", "mine", "-q"}).status, 0);
  const Finished against = program_->Run({"suite", "--against", "out", "-o", "mine"});
  ExpectSays(against.out, "6 of 6");
  ExpectSays(against.out, "stiff/bounce");
  ExpectSays(against.out, "Not verified, because not in 'mine'");
}

TEST_F(SuiteResults, RefusesWhatItHasNot) {
  const auto error = [&](const std::vector<std::string>& arguments) {
    const Finished finished = program_->Run(arguments);
    EXPECT_EQ(finished.status, 2);
    return finished.err;
  };
  ExpectSays(error({"suite", "--only", "game"}), "did you mean 'games'?");
  ExpectSays(error({"suite", "--detector", "kd_tre"}), "kd_tree");
  ExpectSays(error({"suite", "--detector", "dbvt"}), "it is already in the suite");
  ExpectSays(error({"suite", "--long", "--seed", "7"}), "cannot be combined with --seed");
  ExpectSays(error({"suite", "--check", "out", "--against", "out"}),
             "cannot be combined with --against");
  EXPECT_FALSE(program_->Exists("suite"));
}

}  // namespace
}  // namespace cdb::tests
