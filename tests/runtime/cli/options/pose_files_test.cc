// Runs that start with the poses of a file.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "runtime/results/store.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

/// Two groups that fly freely, recorded.
constexpr const char* kRecordedFlight =
    "benchmark flight { cycles 20; world.side 60; precision PRECISION; detector sweep(simple, "
    "dbvt)\n"
    "record timing, poses; objects { quantity 5; size 2; linear_velocity uniform(-9, 9) }\n"
    "objects boxes { quantity 3; type cuboid; size 2; angular_velocity uniform(-2, 2) } }";

std::string WithPrecision(std::string text, const std::string& what, const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

class PoseFilesOf : public testing::TestWithParam<const char*> {};

TEST_P(PoseFilesOf, BeginARunWhereAnotherWas) {
  const Program program;
  program.Write("flight.cdb", WithPrecision(kRecordedFlight, "PRECISION", GetParam()));
  ASSERT_EQ(program.Run({"run", "-q", "flight.cdb"}).status, 0);
  const std::string of = "run: \"detector=dbvt\", ";
  program.Write("again.cdb",
                "benchmark again { cycles 1; world.side 60; acceleration 0; record timing, poses\n"
                "precision " +
                    std::string(GetParam()) +
                    "\n"
                    "objects { size 2; location poses(\"flight.h5\", " +
                    of +
                    "cycle: 7, group: \"objects\") }\n"
                    "objects boxes { type cuboid; size 2\n"
                    "location poses(\"flight.h5\", " +
                    of + "cycle: 7, group: \"boxes\") } }");
  const Finished run = program.Run({"run", "-q", "again.cdb"});
  ASSERT_EQ(run.status, 0) << run.out << run.err;
  const results::ResultFile flight(program.folder() / "flight.h5"),
      again(program.folder() / "again.h5");
  const std::vector<double> then = flight.ReadCycle("poses", {{1}, 0}, 7),
                            now = again.ReadCycle("poses", {{}, 0}, 0);
  ASSERT_EQ(now.size(), then.size());
  // They do not move, because no force acts on them. Bullet converts quaternions to matrices and
  // back.
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (i % 7 < 3)
      EXPECT_EQ(now[i], then[i]) << i;
    else
      EXPECT_NEAR(now[i], then[i], 1e-6) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, PoseFilesOf, testing::Values("single", "double"));

TEST(PoseFile, SaysWhatAResultsFileLacks) {
  const Program program;
  program.Write("flight.cdb", WithPrecision(kRecordedFlight, "PRECISION", "single"));
  ASSERT_EQ(program.Run({"run", "-q", "flight.cdb"}).status, 0);
  const std::pair<const char*, const char*> rows[] = {
      {"\"flight.h5\"", "flight.h5: it has several runs"},
      {"\"flight.h5\", run: \"detector=sap\"", "the axis has the values simple, dbvt"},
      {"\"flight.h5\", run: \"detector=dbvt\", cycle: 20", "it has no cycle 20"},
      {"\"flight.h5\", run: \"detector=dbvt\", group: \"balls\"", "there are objects, boxes"},
      {"\"flight.cdb.h5\"", "cannot read flight.cdb.h5"},
  };
  for (const auto& [arguments, message] : rows) {
    program.Write("again.cdb", std::string("benchmark again { objects { size 2; location poses(") +
                                   arguments + ") } }");
    const Finished check = program.Run({"check", "again.cdb"});
    EXPECT_EQ(check.status, 1);
    EXPECT_NE(check.err.find(message), std::string::npos) << check.err;
    EXPECT_NE(check.err.find("again.cdb:1:"), std::string::npos) << check.err;
  }
}

TEST(PoseFile, RefusesAFileThatChangedAfterThePlan) {
  const Program program;
  program.Write("start.csv", "x,y,z\n0,0,0\n5,0,0\n");
  program.Write("b.cdb",
                "benchmark b { cycles 2; objects { size 2; location poses(\"start.csv\") } }");
  ASSERT_EQ(program.Run({"plan", "b.cdb", "-o", "b.yaml"}).status, 0);
  EXPECT_EQ(program.Run({"run", "-q", "b.yaml"}).status, 0);
  program.Write("start.csv", "x,y,z\n0,0,0\n6,0,0\n");
  const Finished run = program.Run({"run", "-q", "--fresh", "b.yaml"});
  EXPECT_NE(run.status, 0);
  const results::ResultFile results(program.folder() / "b.h5");
  EXPECT_NE(results.ReadText("message", {{}, 0})
                .find("differs from the file that the plan was made with"),
            std::string::npos)
      << results.ReadText("message", {{}, 0});
}

}  // namespace
}  // namespace cdb::tests
