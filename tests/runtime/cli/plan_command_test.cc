// `cdb plan`: the table of runs, the plan as YAML, estimates, and reasons.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "compiler/schema/schema.h"
#include "tests/runtime/cli/small_sweep.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

TEST(Plan, PrintsRunsAndWritesYaml) {
  const Program program;
  program.Write("small.cdb", kSmall);
  const Finished table = program.Run({"plan", "small.cdb"});
  EXPECT_EQ(table.status, 0);
  EXPECT_NE(table.out.find("small: 4 runs = 2 values of detector x 2 of quantity"),
            std::string::npos)
      << table.out;
  EXPECT_EQ(program.Run({"plan", "small.cdb", "-o", "p.yaml"}).out, "");
  EXPECT_EQ(program.Run({"plan", "p.yaml"}).out, table.out);
  EXPECT_EQ(program.Run({"plan", "p.yaml", "-o", "-"}).out, program.Read("p.yaml"));
}

TEST(Plan, EstimatesWhatASweepWillCost) {
  const Program program;
  program.Write("small.cdb", kSmall);
  const Finished some = program.Run({"plan", "--estimate", "small.cdb"});
  EXPECT_EQ(some.status, 0) << some.err;
  EXPECT_NE(some.out.find("small: 4 runs\n"), std::string::npos) << some.out;
  EXPECT_NE(some.out.find("Sampled: 4 of 4 points"), std::string::npos) << some.out;
  EXPECT_EQ(program.Shell("ls -A | grep -c estimate").out, "0\n") << "sampled runs are gone";
  EXPECT_EQ(program.Run({"plan", "--estimate", "small.cdb", "-o", "p.yaml"}).status, 2);
  EXPECT_EQ(program.Run({"plan", "small.cdb", "-o", "p.yaml"}).status, 0);
  EXPECT_EQ(program.Run({"plan", "--estimate", "p.yaml"}).status, 2);
}

TEST(Plan, EstimatesALowerBoundWhereContactsAreYetToCome) {
  const Program program;
  // Nothing touches in 30 cycles; a longer sample is too expensive.
  program.Write("fall.cdb",
                "benchmark fall { cycles 1e8; world.side 1e5; acceleration 0\n"
                "objects { quantity 3; location grid } }");
  const Finished fall = program.Run({"plan", "--estimate", "fall.cdb"});
  EXPECT_EQ(fall.status, 0) << fall.err;
  EXPECT_NE(fall.out.find("\n  time    at least "), std::string::npos) << fall.out;
  EXPECT_NE(fall.out.find("later cycles may take longer"), std::string::npos) << fall.out;
  EXPECT_EQ(fall.out.find("In brackets"), std::string::npos) << fall.out;
}

TEST(Plan, EstimatesWhatPilesTakeToSettle) {
  const Program program;
  program.Write("pile.cdb",
                "benchmark pile { cycles 5; world.side 20; detector sweep(dbvt, sap)\n"
                "objects { quantity 4; size 1; friction sweep(0.5, 0.9); location pile } }");
  const Finished some = program.Run({"plan", "--estimate", "pile.cdb"});
  EXPECT_EQ(some.status, 0) << some.err;
  EXPECT_NE(some.out.find("piles   2, each settled once: 2 are settled by now\n"),
            std::string::npos)
      << some.out;
}

TEST(Plan, SaysWhatEachRunLeavesOut) {
  const Program program;
  program.Write("o.cdb",
                "benchmark o { cycles 5; objects { quantity 1; size 5 }\n"
                "detector sweep(sap, dbvt); omit sweep(auto, none) }");
  const Finished table = program.Run({"plan", "o.cdb"});
  EXPECT_EQ(table.status, 0) << table.err;
  for (const char* row :
       {"  detector  omit  objects  side  cycles  left out\n",
        "  sap       auto        1    50       5  walls? raycast_tree solver? sleeping?\n",
        "  dbvt      auto        1    50       5  walls? solver? sleeping?\n",
        "  sap       none        1    50       5  -\n",
        "\n?: the positions of the objects decide; "})
    EXPECT_NE(table.out.find(row), std::string::npos) << row << table.out;

  const Finished why = program.Run({"plan", "--why", "o.cdb"});
  EXPECT_EQ(why.status, 0) << why.err;
  // A fall of a few millimetres in a cube of 50 m: no component is undecided, nothing touches.
  EXPECT_EQ(why.out.find("open"), std::string::npos) << why.out;
  for (const char* row :
       {"\n  walls           left out  for 6 of 6", "\n  raycast_tree    none      dbvt has none",
        "\n  gravity         kept      the accel"})
    EXPECT_NE(why.out.find(row), std::string::npos) << row << why.out;
  EXPECT_NE(why.out.find("  o: detector sap, omit auto\n"), std::string::npos) << why.out;

  const std::string id = table.out.substr(table.out.find("\n  ", table.out.find("---")) + 3, 16);
  const Finished only = program.Run({"plan", "--why", "o.cdb", "--only", id});
  EXPECT_EQ(only.status, 0) << only.err;
  EXPECT_EQ(only.out.find(id), 0u) << only.out;
  EXPECT_EQ(why.out.find(only.out), 0u) << "the first of them all";
  EXPECT_EQ(std::ranges::count(only.out, '\n'), 1 + static_cast<int>(schema::Components().size()));

  EXPECT_EQ(program.Run({"plan", "--why", "o.cdb", "--only", "nothing"}).status, 2);
  EXPECT_EQ(program.Run({"plan", "o.cdb", "--only", id}).status, 2);
  EXPECT_EQ(program.Run({"plan", "--why", "o.cdb", "-o", "p.yaml"}).status, 2);
  EXPECT_FALSE(program.Exists("p.yaml"));
}

TEST(Plan, WhySaysRepeatsOnceAndGoesOnAfterARunThatFails) {
  const Program program;
  // 40 objects have no room; and two that are stacked need a solver.
  program.Write("f.cdb",
                "benchmark f { repeats 3; cycles 300; world.side 100; omit solver\n"
                "objects { size 60; quantity sweep(40, 1, 0) } }");
  const Finished why = program.Run({"plan", "--why", "f.cdb"});
  EXPECT_EQ(why.status, 1) << why.err;
  const auto count = [&](const std::string& part) {
    int n = 0;
    for (std::size_t at = why.out.find(part); at != std::string::npos;
         at = why.out.find(part, at + 1))
      ++n;
    return n;
  };
  EXPECT_EQ(count(" and 2 more like it\n"), 3) << why.out;
  EXPECT_EQ(count("  this run fails: "), 2) << why.out;
  EXPECT_EQ(count("  this run fails: omit solver: this scene needs it: "), 1) << why.out;
  EXPECT_EQ(count("\n  solver          left out "), 1) << why.out;
}

}  // namespace
}  // namespace cdb::tests
