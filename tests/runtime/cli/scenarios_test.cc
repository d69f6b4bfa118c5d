// The scenarios shipped with cdb, run by name.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/program.h"

namespace cdb::tests {
namespace {

TEST(Scenarios, AreListedByFolderWithWhatTheyAre) {
  const Finished list = Program().Run({"list", "scenarios"});
  EXPECT_EQ(list.status, 0);
  for (const char* part :
       {"scenarios: paper\n", "scenarios: related\n", "scenarios: application\n",
        "scenarios: stability\n", "scenarios: accuracy\n", "scenarios: work_precision\n",
        "paper/experiment2 ", "Woulfe & Manzke 2009, experiment 2"})
    EXPECT_NE(list.out.find(part), std::string::npos) << part << '\n' << list.out;
  EXPECT_EQ(list.out.find("Look at"), std::string::npos);
}

TEST(Scenarios, AreRunByNameFromAnyFolder) {
  const Program program;
  const Finished plan = program.Run({"plan", "paper/experiment2"});
  EXPECT_EQ(plan.status, 0) << plan.err;
  EXPECT_NE(plan.out.find("paper_experiment2: 75 runs"), std::string::npos) << plan.out;
  const Finished check = program.Run({"check", "paper/experiment1", "related/cao_2006.cdb"});
  EXPECT_EQ(check.status, 0) << check.err;
  EXPECT_NE(check.out.find("paper/experiment1: paper_experiment1: 1 run\n"), std::string::npos)
      << check.out;
}

TEST(Scenarios, AreSecondToWhatLiesHere) {
  const Program program;
  std::filesystem::create_directory(program.folder() / "paper");
  program.Write("paper/experiment2.cdb", "benchmark my_own { }\n");
  const Finished mine = program.Run({"check", "paper/experiment2.cdb"});
  EXPECT_EQ(mine.out, "paper/experiment2.cdb: my_own: 1 run\n") << mine.err;
}

TEST(Scenarios, AreNamedWhereAFileIsMissing) {
  const Program program;
  for (const char* command : {"check", "plan", "run"}) {
    const Finished missing = program.Run({command, "paper/experiment9"});
    EXPECT_EQ(missing.status, 2);
    EXPECT_EQ(missing.err,
              "cdb: cannot read 'paper/experiment9': No such file or directory; `cdb list "
              "scenarios` lists those that come with cdb\n");
  }
}

TEST(Scenarios, AreLaidOverByAFileOfOnesOwnAndBringTheirModels) {
  const Program program;
  program.Write("mine.cdb",
                "use \"related/i_collide\"\n"
                "benchmark mine from i_collide_quantity {\n"
                "  cycles 3; detector dbvt; objects.quantity 4 }\n");
  const Finished run = program.Run({"run", "-q", "mine.cdb"});
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  EXPECT_TRUE(program.Exists("mine.h5"));
}

}  // namespace
}  // namespace cdb::tests
