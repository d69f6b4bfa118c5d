// `cdb run --until`: the fewest repeats that make each interval narrow enough, the same number for
// all points.
#include "runtime/cli/plans/plan_runner.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "runtime/results/store.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using plans::Precision;
using results::ResultFile;
using results::Status;

const char kTwoPoints[] =
    "benchmark s { cycles 4; repeats 12; world.side 500; detector sweep(dbvt, sap32) }";

Precision Reached(std::uint64_t repeats, std::size_t within, double widest) {
  return {.repeats = repeats, .missing = 0, .points = 10, .within = within, .widest = widest};
}

TEST(NextRepeats, GrowWithTheSquareOfTheWidth) {
  EXPECT_EQ(plans::NextRepeats(Reached(20, 4, 0.012), 0.01, 1000), 29u);
  EXPECT_EQ(plans::NextRepeats(Reached(20, 9, 0.01001), 0.01, 1000), 21u) << "at least one more";
  EXPECT_EQ(plans::NextRepeats(Reached(20, 4, 0.5), 0.01, 1000), 40u) << "at most twice as many";
  EXPECT_EQ(plans::NextRepeats(Reached(20, 4, 0.5), 0.01, 25), 25u);
  EXPECT_EQ(plans::NextRepeats(Reached(25, 4, 0.5), 0.01, 25), 25u) << "no more";
  EXPECT_EQ(plans::NextRepeats(Reached(20, 10, 0.009), 0.01, 1000), 20u) << "precise";
}

class Until : public testing::Test {
 protected:
  void SetUp() override { program_.Write("s.cdb", kTwoPoints); }
  ResultFile Open() const { return ResultFile(program_.folder() / "s.h5"); }
  /// The number of repeats that each of the two points has, before the first missing one.
  std::uint64_t Repeats() const {
    const ResultFile file = Open();
    for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) {
      const bool is_there = file.ReadStatus({{0}, rep}) == Status::kDone;
      EXPECT_EQ(file.ReadStatus({{1}, rep}), is_there ? Status::kDone : Status::kMissing) << rep;
      EXPECT_EQ(is_there, rep < file.begun_repeats());
    }
    return file.begun_repeats();
  }

  const Program program_;
};

TEST_F(Until, EndsAfterFiveRepeatsThatAreNearEnough) {
  const Finished run = program_.Run({"run", "s.cdb", "--until", "100000%"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("5 repeats: every mean step is known within 1e+05 %\n"), std::string::npos)
      << run.err;
  EXPECT_NE(run.out.find("14 not run yet: repeats 6 to 12 of each point."), std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("95 % interval"), std::string::npos) << run.out;
  EXPECT_EQ(Repeats(), 5u);
  EXPECT_FALSE(program_.Exists("s.runs"));
  // Running it again does nothing, and removes what a kill after the merge has left.
  std::filesystem::create_directory(program_.folder() / "s.runs");
  program_.Write("s.runs/plan.yaml", "");
  const double started = Open().ReadReal("started", {{0}, 0});
  const Finished again = program_.Run({"run", "s.cdb", "--until", "100000"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_FALSE(program_.Exists("s.runs"));
  EXPECT_EQ(Repeats(), 5u);
  // Without it, the rest is run; existing results stay.
  EXPECT_EQ(program_.Run({"run", "s.cdb", "-q"}).status, 0);
  EXPECT_EQ(Repeats(), 12u);
  EXPECT_EQ(Open().ReadReal("started", {{0}, 0}), started);
  EXPECT_EQ(program_.Run({"check", "s.h5"}).status, 0);
}

TEST_F(Until, GoesOnToTheMostThatThereAre) {
  const Finished run = program_.Run({"run", "s.cdb", "--until", "0.000001 %"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("; continuing to 10\n"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("; `repeats` is reached\n"), std::string::npos) << run.err;
  EXPECT_EQ(Repeats(), 12u);
  EXPECT_EQ(run.out.find("not run yet"), std::string::npos) << run.out;
}

TEST_F(Until, ASmallerPartGoesOnFromALargerOne) {
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "--until", "100000"}).status, 0);
  const double started = Open().ReadReal("started", {{1}, 4});
  EXPECT_EQ(program_.Run({"run", "s.cdb", "-q", "--until", "0.000001"}).status, 0);
  EXPECT_EQ(Repeats(), 12u);
  EXPECT_EQ(Open().ReadReal("started", {{1}, 4}), started);
}

/// A command that was stopped in a round had finished some runs of it.
TEST_F(Until, ARoundThatWasBegunIsFinished) {
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "--shard", "1/3"}).status, 0);
  ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "--until", "100000"}).status, 0);
  EXPECT_EQ(Repeats(), 10u) << "the shard had begun ten";
  EXPECT_FALSE(program_.Exists("s.runs"));
}

TEST_F(Until, IsRefusedWhereItCannotBe) {
  const auto error = [&](const std::string& text, const std::vector<std::string>& more) {
    program_.Write("t.cdb", text);
    std::vector<std::string> arguments = {"run", "t.cdb", "--until"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished finished = program_.Run(arguments);
    EXPECT_EQ(finished.status, 2);
    EXPECT_FALSE(program_.Exists("t.h5"));
    return finished.err;
  };
  const std::string few = "benchmark t { cycles 2; world.side 500 }";
  EXPECT_NE(error(few, {"1%"}).find("'t' has repeats 1, the upper limit"), std::string::npos);
  EXPECT_NE(error("benchmark t { repeats 9; record energy }", {"1%"}).find("records no times"),
            std::string::npos);
  EXPECT_NE(error(kTwoPoints, {"few"}).find("--until few: not a percentage"), std::string::npos);
  EXPECT_NE(error(kTwoPoints, {"0"}).find("--until 0%"), std::string::npos);
  EXPECT_NE(error(kTwoPoints, {"1%", "--shard", "1/2"}).find("remove --shard"), std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
