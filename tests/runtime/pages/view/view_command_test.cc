// `cdb view` on the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kDropScenario = R"(benchmark drop "</script><script>alert(1)</script>" {
  cycles 5
  world.side 10
  detector sweep(dbvt, sap)
  record timing, counts, poses
  objects { quantity 3; size 1 }
}
)";

bool HasPages(const Program& program) {
  program.Write("start.cdb", "benchmark start { world.side 10; objects { quantity 1; size 1 } }");
  const Finished view = program.Run({"view", "start.cdb"});
  EXPECT_TRUE(view.status == 0 || view.err.find("built without pages") != std::string::npos)
      << view.err;
  return view.status == 0;
}

TEST(ViewCommand, WritesAPageOfARunAndOfAScenario) {
  const Program program;
  if (!HasPages(program)) GTEST_SKIP() << "built without npm";
  EXPECT_TRUE(program.Exists("start.scene.html"));
  program.Write("drop.cdb", kDropScenario);
  ASSERT_EQ(program.Run({"run", "-q", "drop.cdb"}).status, 0);
  const Finished view =
      program.Run({"view", "drop.h5", "-o", "a.html", "--select", "detector=sap", "rep=0"});
  EXPECT_EQ(view.status, 0) << view.err;
  EXPECT_EQ(view.out, "");
  EXPECT_THAT(view.err, HasSubstr("drop.h5, detector sap: 3 objects, 5 frames\n"));
  const std::string page = program.Read("a.html");
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("\"detector sap\""));
}

TEST(ViewCommand, SetsTwoRunsSideBySide) {
  const Program program;
  if (!HasPages(program)) GTEST_SKIP() << "built without npm";
  program.Write("drop.cdb", kDropScenario);
  ASSERT_EQ(program.Run({"run", "-q", "drop.cdb"}).status, 0);
  const Finished beside =
      program.Run({"view", "drop.h5", "--select", "detector=dbvt", "--beside", "detector=sap"});
  EXPECT_EQ(beside.status, 0) << beside.err;
  EXPECT_THAT(beside.err, HasSubstr("detector dbvt: 3 objects, 5 frames\ndrop.h5, detector sap"));
  EXPECT_EQ(program.Run({"view", "drop.h5", "start.cdb"}).status, 0);
}

TEST(ViewCommand, SaysThatPosesAreMissingAndShowsTheStart) {
  const Program program;
  if (!HasPages(program)) GTEST_SKIP() << "built without npm";
  ASSERT_EQ(program.Run({"run", "-q", "start.cdb"}).status, 0);
  const Finished view = program.Run({"view", "start.h5"});
  EXPECT_EQ(view.status, 0) << view.err;
  EXPECT_THAT(view.err, HasSubstr("1 object, the start\n"));
  EXPECT_THAT(view.err, HasSubstr("This run has no poses"));
  EXPECT_THAT(view.err, HasSubstr("`record timing, counts, poses`"));
  const Finished cycles = program.Run({"view", "start.h5", "--cycles", "1..2"});
  EXPECT_EQ(cycles.status, 2);
  EXPECT_THAT(cycles.err, HasSubstr("start.h5: --cycles and --every need poses"));
}

TEST(ViewCommand, WritesGltfWithoutAPage) {
  const Program program;
  program.Write("drop.cdb", kDropScenario);
  ASSERT_EQ(program.Run({"run", "-q", "drop.cdb"}).status, 0);
  const Finished view = program.Run({"view", "drop.h5", "--gltf", "drop.glb"});
  EXPECT_EQ(view.status, 0) << view.err;
  EXPECT_EQ(program.Read("drop.glb").substr(0, 4), "glTF");
  EXPECT_FALSE(program.Exists("drop.scene.html"));
}

TEST(ViewCommand, RefusesByName) {
  const Program program;
  program.Write("drop.cdb", kDropScenario);
  ASSERT_EQ(program.Run({"run", "-q", "drop.cdb"}).status, 0);
  const auto error = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "view");
    const Finished finished = program.Run(arguments);
    EXPECT_EQ(finished.status, 2);
    return finished.err;
  };
  EXPECT_THAT(error({"none.h5"}), HasSubstr("none.h5: there is no such file"));
  EXPECT_THAT(error({"drop.h5", "--select", "detector=simple"}),
              HasSubstr("drop.h5: detector=simple: the axis has the values dbvt, sap"));
  EXPECT_THAT(error({"drop.h5", "--beside", "size=1"}), HasSubstr("there is no axis 'size'"));
  EXPECT_THAT(error({"drop.h5", "drop.h5", "--select", "size=1"}),
              HasSubstr("no file has the axis 'size'"));
  EXPECT_THAT(error({"drop.h5", "--cycles", "3..9"}),
              HasSubstr("the cycles of the run are 0 to 4"));
  EXPECT_THAT(error({"drop.h5", "--every", "0"}), HasSubstr("--every 0: expected a whole number"));
  EXPECT_THAT(error({"drop.cdb", "--every", "2"}), HasSubstr("only the start is shown"));
  EXPECT_THAT(error({"drop.h5", "-b", "drop"}), HasSubstr("-b is for scenarios"));
  EXPECT_THAT(error({"drop.h5", "--gltf", "a.gltf"}), HasSubstr("must end in .glb"));
  EXPECT_THAT(error({"drop.h5", "drop.h5", "drop.h5"}), HasSubstr("name one or two files"));
  EXPECT_THAT(error({"drop.h5", "--serve"}), HasSubstr("--serve edits one scenario file"));
  EXPECT_THAT(error({"drop.cdb", "--serve", "-o", "a.html"}), HasSubstr("-o is for a page in a"));
  EXPECT_THAT(error({"paper/experiment1", "--serve"}), HasSubstr("comes with cdb"));
  EXPECT_THAT(error({"drop.cdb", "--serve", "-b", "rain"}), HasSubstr("no benchmark 'rain'"));
}

TEST(ViewCommand, ReportsErrorsOfTheScenario) {
  const Program program;
  program.Write("bad.cdb", "benchmark bad { cyclse 3 }");
  const Finished finished = program.Run({"view", "bad.cdb"});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("did you mean 'cycles'"));
}

}  // namespace
}  // namespace cdb::tests
