#include "runtime/cli/plans/verify_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

TEST(VerifyCommand, FindsNothingWrongWithBulletsAndEverythingWithNothing) {
  const Program program;
  program.Write("s.cdb",
                "benchmark s { cycles 20; repeats 2; world.side 300; detector sweep(simple, dbvt)\n"
                "objects { quantity sweep(20, 40); linear_velocity uniform(-300, 300) } }");
  const Finished good = program.Run({"verify", "s.cdb", "-q"});
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_EQ(good.err, "");
  EXPECT_NE(good.out.find("\n  simple    broad        2      40 "), std::string::npos) << good.out;
  EXPECT_NE(good.out.find("  exact\n"), std::string::npos) << good.out;
  EXPECT_TRUE(program.Exists("s.verify.h5"));

  const Finished bad = program.Run(
      {"verify", "s.cdb", "-q", "--detector", "sap,null", "--cycles", "5", "-o", "results"});
  EXPECT_EQ(bad.status, 3) << bad.err;
  EXPECT_LT(bad.out.find("\n  null "), bad.out.find("\n  sap ")) << bad.out;
  EXPECT_NE(bad.out.find("  wrong: misses pairs\n"), std::string::npos) << bad.out;
  // The command that it prints replays the run, and reports the same.
  const std::string replay = "    cdb run results/s.verify.yaml -b s --only ";
  const std::size_t at = bad.out.find(replay);
  ASSERT_NE(at, std::string::npos) << bad.out;
  const std::string id = bad.out.substr(at + replay.size(), 16);
  const Finished again = program.Run({"run", "results/s.verify.yaml", "--only", id});
  EXPECT_NE(again.out.find("  WRONG: null missed "), std::string::npos) << again.out << again.err;

  const Finished other = program.Run({"verify", "s.cdb", "-q", "--detector", "dvbt"});
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.err.find("did you mean 'dbvt'?"), std::string::npos) << other.err;
}

TEST(VerifyCommand, TellsTheContactsThatBulletMissesFromThoseOfADetector) {
  // A ball that overlaps the rim of a cylinder by .061 mm, where Bullet makes no contact.
  const Program program;
  program.Write("rim.cdb",
                "benchmark rim { cycles 1; world.walls none; acceleration (0, 0, 0)\n"
                "objects ball { quantity 1; type sphere; size 0.1; overlap on\n"
                "location at(0.1703122, 0.1703122, 0) }\n"
                "objects drum { quantity 1; type cylinder; size 0.27; overlap on\n"
                "location at(0, 0, 0) } }");
  const Finished rim = program.Run({"verify", "rim.cdb", "-q"});
  EXPECT_EQ(rim.status, 0) << "no detector misses anything";
  EXPECT_NE(
      rim.out.find("  1 of 1       0        0          0            -             -  exact\n"),
      std::string::npos)
      << rim.out;
  EXPECT_NE(rim.out.find("  1 of 1       1        -          -            -             -  Bullet "
                         "misses contacts\n"),
            std::string::npos)
      << rim.out;
}

TEST(VerifyPlan, LeavesOutWhatANamedDetectorDoesNotHold) {
  const Program program;
  program.Write("s.cdb",
                "benchmark s { cycles 1; omit none; detector sap32\n"
                "objects { quantity sweep(10, 16384) } }");
  const Finished some = program.Run({"verify", "s.cdb", "-q", "--detector", "sap,dbvt"});
  EXPECT_EQ(some.status, 0) << some.err;
  EXPECT_NE(some.out.find("  Omitted: sap, if there are more than 16384 bodies.\n"),
            std::string::npos)
      << some.out;
  program.Write("t.cdb",
                "benchmark t { cycles 1; omit none; detector sap32\n"
                "objects { quantity 16384 } }");
  const Finished none = program.Run({"verify", "t.cdb", "-q", "--detector", "sap"});
  EXPECT_EQ(none.status, 2);
  EXPECT_NE(
      none.err.find("t: there is nothing to verify: sap, if there are more than 16384 bodies"),
      std::string::npos)
      << none.err;
}

TEST(VerifyPlan, TakesEveryDetectorThatHoldsTheScene) {
  const Program program;
  program.Write("s.cdb",
                "benchmark s { cycles 1; omit none; detector sap32\n"
                "objects { quantity sweep(10, 16384) } }");
  ASSERT_EQ(program.Run({"plan", "s.cdb", "-o", "s.yaml"}).status, 0);
  const plan::Plan plan = yaml::FromYaml(program.Read("s.yaml"), "s.yaml");
  const plans::VerifyPlan every = plans::MakeVerifyPlan(plan, {{"all"}, 7, {}});
  const auto& detectors = every.plan.axes[0];
  EXPECT_EQ(detectors.name, "detector");
  EXPECT_EQ(std::ranges::count(detectors.values, plan::Coordinate("null")), 0);
  const auto sap = std::ranges::find(detectors.values, plan::Coordinate("sap"));
  ASSERT_NE(sap, detectors.values.end());
  const auto index = static_cast<std::size_t>(sap - detectors.values.begin());
  EXPECT_EQ(every.plan.skipped, (std::vector<std::vector<std::size_t>>{{index, 1}}));
  EXPECT_EQ(every.plan.runs.size() + 1, 2 * detectors.values.size());
  EXPECT_NE(std::ranges::find(every.left_out, "sap, if there are more than 16384 bodies"),
            every.left_out.end());
  for (const plan::Run& run : every.plan.runs) {
    EXPECT_EQ(run.scene.world.Count("cycles"), 7u);
    EXPECT_TRUE(run.scene.world.Lists("record", "pairs"));
    EXPECT_FALSE(run.scene.world.Lists("record", "timing"));
    EXPECT_EQ(run.scene.world.WordOr("pair_order"), "sorted");
  }
}

TEST(VerifyPlan, LeavesOutTheTestOfAllPairsOfManyBodiesUnlessItIsNamed) {
  const Program program;
  program.Write("s.cdb",
                "benchmark s { cycles 1; omit none; detector sap32; world.walls none\n"
                "objects { quantity sweep(20_000, 20_001) } }");
  ASSERT_EQ(program.Run({"plan", "s.cdb", "-o", "s.yaml"}).status, 0);
  const plan::Plan plan = yaml::FromYaml(program.Read("s.yaml"), "s.yaml");
  const plans::VerifyPlan every = plans::MakeVerifyPlan(plan, {{"all"}, 7, {}});
  EXPECT_NE(std::ranges::find(every.left_out,
                              "simple, if there are more than 20000 bodies, because it tests all "
                              "pairs of them; name it to run it anyway"),
            every.left_out.end());
  const auto& detectors = every.plan.axes[0].values;
  const auto simple = std::ranges::find(detectors, plan::Coordinate("simple"));
  ASSERT_NE(simple, detectors.end());
  const auto index = static_cast<std::size_t>(simple - detectors.begin());
  EXPECT_TRUE(std::ranges::binary_search(every.plan.skipped, std::vector<std::size_t>{index, 1}));
  EXPECT_FALSE(std::ranges::binary_search(every.plan.skipped, std::vector<std::size_t>{index, 0}));
  const plans::VerifyPlan named = plans::MakeVerifyPlan(plan, {{"simple", "dbvt"}, 7, {}});
  EXPECT_TRUE(named.left_out.empty());
  EXPECT_TRUE(named.plan.skipped.empty());
}

}  // namespace
}  // namespace cdb::tests
