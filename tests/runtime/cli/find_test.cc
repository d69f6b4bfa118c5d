// Searches (`find( )`) as users see them: the runs that they take, and the boundaries they find.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

#include "runtime/figures/model.h"
#include "runtime/figures/points.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

/// A ball that flies freely: after 10 cycles of 1/60 s it has moved by speed / 6, and its largest
/// speed is `speed`. Nothing else depends on the values.
std::string Flight(const std::string& find, const std::string& more = "") {
  return fmt::format(
      "benchmark flight {{\n  let speed = {}\n  cycles 10\n  acceleration 0\n  sleeping off\n{}"
      "  world {{ side 1e4; walls none }}\n"
      "  objects {{ quantity 1; size 1; location at(0, 0, 0); linear_velocity (speed, 0, 0) }}\n"
      "  record stability, counts, timing\n}}\n",
      find, more);
}

struct FoundSearch {
  std::vector<searches::Boundary> boundaries;
  std::size_t runs = 0, missing = 0;
};
FoundSearch ReadFound(const std::filesystem::path& path) {
  const results::ResultFile file(path);
  const figures::Model model(file);
  FoundSearch found{searches::FindBoundaries(model), 0, 0};
  for (const figures::Cell& cell : figures::AllCells(file)) {
    found.runs += file.ReadStatus(cell) == results::Status::kDone;
    found.missing += file.ReadStatus(cell) == results::Status::kMissing;
  }
  return found;
}

TEST(Find, TakesTheRunsThatItNeedsAndFindsTheBoundary) {
  const Program program;
  program.Write("flight.cdb", Flight("find(1 .. 1000 log, until: max(max_speed) > 77.7)",
                                     "  seed sweep(1, 2, 3)\n"));
  EXPECT_EQ(program.Run({"check", "flight.cdb"}).out,
            "flight.cdb: flight: a search: about 33 of 771 runs\n");
  const Finished run = program.Run({"run", "flight.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("Where max(max_speed) > 77.7 along speed"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("0 of 3 searches have ended"), std::string::npos) << run.err;
  const FoundSearch found = ReadFound(program.folder() / "flight.h5");
  ASSERT_EQ(found.boundaries.size(), 3u);
  EXPECT_LE(found.runs, 33u);
  EXPECT_EQ(found.missing, 0u) << "what it does not need is not missing";
  for (const searches::Boundary& of : found.boundaries) {
    EXPECT_EQ(of.bracket.outcome, searches::Outcome::kBetween);
    EXPECT_LE(of.low, 77.7);
    EXPECT_GE(of.high, 77.7);
    EXPECT_LE(of.high / of.low, 1.05) << "the tolerance, if none is given";
    EXPECT_DOUBLE_EQ(of.value, std::sqrt(of.low * of.high));
  }
  // The file stores what the model finds.
  const hdf5::File file = hdf5::File::Open(program.folder() / "flight.h5");
  const auto values = file.OpenDataset("boundary/value").Read();
  ASSERT_EQ(values.size(), 3u);
  EXPECT_EQ(values[1], found.boundaries[1].value);
  EXPECT_EQ(file.OpenDataset("boundary/probes").Read()[2], 11);
  EXPECT_EQ(program.Run({"check", "flight.h5"}).status, 0);
  // Nothing is left to do.
  const Finished again = program.Run({"run", "flight.cdb"});
  EXPECT_NE(again.err.find("is complete"), std::string::npos) << again.err;
}

TEST(Find, SearchesDownwardsAndInEqualSteps) {
  const Program program;
  program.Write("flight.cdb",
                Flight("find(100 .. 0, tolerance: 1 %, until: max(max_speed) < 42.1)"));
  EXPECT_EQ(program.Run({"run", "flight.cdb", "-q"}).status, 0);
  const FoundSearch found = ReadFound(program.folder() / "flight.h5");
  ASSERT_EQ(found.boundaries.size(), 1u);
  const searches::Boundary& of = found.boundaries[0];
  EXPECT_LE(of.low, 42.1);
  EXPECT_GE(of.high, 42.1);
  EXPECT_LE(of.high - of.low, 1) << "1 % of the range";
  EXPECT_DOUBLE_EQ(of.value, (of.low + of.high) / 2);
}

TEST(Find, TakesListedValuesAndCounts) {
  const Program program;
  program.Write("flight.cdb", Flight("find(10, 20, 40, 80, until: max(max_speed) > 30)"));
  EXPECT_EQ(program.Run({"run", "flight.cdb", "-q"}).status, 0);
  const FoundSearch listed = ReadFound(program.folder() / "flight.h5");
  EXPECT_EQ(listed.boundaries.at(0).low, 20);
  EXPECT_EQ(listed.boundaries.at(0).high, 40);
  program.Write(
      "many.cdb",
      "benchmark many {\n  cycles 2\n  world.side 100\n  record stability\n"
      "  objects { quantity find(1 .. 30 step 1, until: moving_objects >= 18); size 1 }\n}\n");
  const Finished run = program.Run({"run", "many.cdb", "-q"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(ReadFound(program.folder() / "many.h5").boundaries.at(0).low, 17);
}

TEST(Find, SaysWhereThereIsNoBoundary) {
  const Program program;
  program.Write("flight.cdb", Flight("find(1 .. 10 log, until: max(max_speed) > 77.7)"));
  const Finished nowhere = program.Run({"run", "flight.cdb"});
  EXPECT_NE(nowhere.out.find("nowhere up to 10"), std::string::npos) << nowhere.out;
  program.Write("flight.cdb", Flight("find(100 .. 200 log, until: max(max_speed) > 77.7)"));
  const Finished first = program.Run({"run", "flight.cdb"});
  EXPECT_NE(first.out.find("at 100 already"), std::string::npos) << first.out << first.err;
}

TEST(Find, KeepsItsRunsWhenConditionOrToleranceChange) {
  const Program program;
  program.Write("flight.cdb", Flight("find(1 .. 1000 log, until: max(max_speed) > 77.7)"));
  EXPECT_EQ(program.Run({"run", "flight.cdb", "-q"}).status, 0);
  for (const char* find : {"find(1 .. 1000 log, until: max(max_speed) > 60)",
                           "find(1 .. 1000 log, tolerance: 1 %, until: max(max_speed) > 60)"}) {
    program.Write("flight.cdb", Flight(find));
    const Finished run = program.Run({"run", "flight.cdb"});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.err.find("runs are kept"), std::string::npos) << run.err;
    const FoundSearch found = ReadFound(program.folder() / "flight.h5");
    EXPECT_LE(found.boundaries.at(0).low, 60);
    EXPECT_GE(found.boundaries.at(0).high, 60);
  }
}

TEST(Find, IsTheSameInShards) {
  const Program program;
  program.Write("flight.cdb", Flight("find(1 .. 1000 log, until: max(max_speed) > 77.7)",
                                     "  seed sweep(1 .. 4)\n  detector sweep(sap, dbvt)\n"));
  EXPECT_EQ(program.Run({"run", "flight.cdb", "-q", "-o", "whole.h5"}).status, 0);
  for (const char* shard : {"1/3", "2/3", "3/3", "1/3"}) {
    const Finished run = program.Run({"run", "flight.cdb", "-q", "--shard", shard});
    EXPECT_EQ(run.status, 0) << shard << run.err;
  }
  EXPECT_EQ(program.Run({"plan", "flight.cdb", "-o", "plan.yaml"}).status, 0);
  const Finished merge = program.Run({"merge", "-o", "flight.h5", "--remove", "flight.runs"});
  EXPECT_EQ(merge.status, 0) << merge.err;
  EXPECT_NE(merge.err.find("all that are needed"), std::string::npos) << merge.err;
  EXPECT_FALSE(program.Exists("flight.runs"));
  const FoundSearch whole = ReadFound(program.folder() / "whole.h5"),
                    merged = ReadFound(program.folder() / "flight.h5");
  EXPECT_EQ(whole.runs, merged.runs);
  EXPECT_EQ(merged.missing, 0u);
  ASSERT_EQ(whole.boundaries.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(whole.boundaries[i].value, merged.boundaries[i].value);
  for (const auto& entry : std::filesystem::directory_iterator(program.folder()))
    EXPECT_EQ(entry.path().string().find("found-"), std::string::npos) << entry.path();
}

TEST(Find, GoesOnFromPartOfItsRuns) {
  const Program program;
  program.Write("flight.cdb", Flight("find(1 .. 1000 log, until: max(max_speed) > 77.7)",
                                     "  seed sweep(1, 2)\n"));
  EXPECT_EQ(program.Run({"run", "flight.cdb", "-q", "-o", "whole.h5"}).status, 0);
  // One of two shards has ended; its merge is a part of the results.
  EXPECT_EQ(program.Run({"run", "flight.cdb", "-q", "--shard", "1/2"}).status, 0);
  EXPECT_EQ(program.Run({"merge", "-o", "flight.h5", "flight.runs"}).status, 0);
  EXPECT_GT(ReadFound(program.folder() / "flight.h5").missing, 0u);
  EXPECT_EQ(program.Run({"check", "flight.h5"}).status, 3);
  const Finished run = program.Run({"run", "flight.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  const FoundSearch whole = ReadFound(program.folder() / "whole.h5"),
                    now = ReadFound(program.folder() / "flight.h5");
  EXPECT_EQ(now.runs, whole.runs);
  EXPECT_EQ(now.missing, 0u);
}

/// Points of two searches may have the same run: 3 x 7 objects are 1 x 21.
TEST(Find, HasSearchesThatShareRuns) {
  const Program program;
  program.Write("shared.cdb",
                "benchmark shared {\n  let s = sweep(1, 3) as s\n  cycles 2\n  world.side 400\n"
                "  record stability\n  objects { size 1\n"
                "    quantity s * find(1 .. 33 step 1, until: moving_objects > 20) as q }\n}\n");
  const Finished run = program.Run({"run", "shared.cdb", "-q"});
  EXPECT_EQ(run.status, 0) << run.err;
  const auto check = [&](const char* file) {
    const FoundSearch found = ReadFound(program.folder() / file);
    ASSERT_EQ(found.boundaries.size(), 2u);
    EXPECT_EQ(found.missing, 0u);
    EXPECT_EQ(found.boundaries[0].low, 20);
    EXPECT_EQ(found.boundaries[1].low, 6);
  };
  check("shared.h5");
  for (const char* shard : {"1/2", "2/2"})
    EXPECT_EQ(program.Run({"run", "shared.cdb", "-q", "--shard", shard, "-o", "parts.h5"}).status,
              0);
  EXPECT_EQ(program.Run({"merge", "-o", "parts.h5", "parts.runs"}).status, 0);
  check("parts.h5");
}

TEST(Find, SearchesSeeds) {
  const Program program;
  program.Write(
      "seeds.cdb",
      "benchmark seeds {\n  seed find(1 .. 100, tolerance: 10 %, until: max(pairs) > 1e6)\n"
      "  cycles 2\n  record counts\n  objects { quantity 3; size 1 }\n}\n");
  const Finished run = program.Run({"run", "seeds.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("nowhere up to 100"), std::string::npos) << run.out;
}

/// Objects that do not fit make a run fail, which is as bad as a run can be.
TEST(Find, TakesFailedRunsForBadOnes) {
  const Program program;
  program.Write("fits.cdb",
                "benchmark fits {\n  cycles 2\n  record stability\n"
                "  world.side find(3 .. 60 log, tolerance: 10 %, until: verdict == stable)\n"
                "  objects { quantity 30; size 2; location uniform }\n}\n");
  program.Run({"run", "fits.cdb", "-q"});
  const FoundSearch found = ReadFound(program.folder() / "fits.h5");
  ASSERT_EQ(found.boundaries.size(), 1u);
  EXPECT_EQ(found.boundaries[0].bracket.outcome, searches::Outcome::kUncertain);
  EXPECT_TRUE(found.boundaries[0].IsFound());
  EXPECT_GT(found.boundaries[0].value, 3);
  EXPECT_TRUE(std::isnan(found.boundaries[0].low)) << "no run before it tells";
}

TEST(Find, IsVerifiedAtEveryValue) {
  const Program program;
  program.Write("all.cdb",
                "benchmark all {\n  cycles 2\n  world.side 100\n  record counts\n"
                "  objects { quantity find(1 .. 9 step 1, until: max(pairs) > 1e6); size 1 }\n}\n");
  const Finished verified = program.Run({"verify", "all.cdb"});
  EXPECT_EQ(verified.status, 0) << verified.err;
  EXPECT_NE(verified.err.find("9/9"), std::string::npos) << verified.err;
}

TEST(Find, ComparesBoundaries) {
  const Program program;
  for (const char* limit : {"77.7", "20"}) {
    program.Write("flight.cdb", Flight("find(1 .. 1000 log, until: max(max_speed) > limit)",
                                       fmt::format("  let limit = {}\n", limit)));
    EXPECT_EQ(program.Run({"run", "flight.cdb", "-q", "-o", std::string(limit) + ".h5"}).status, 0);
  }
  const Finished same = program.Run({"compare", "20.h5", "20.h5"});
  EXPECT_NE(same.out.find("no change that shows"), std::string::npos) << same.out << same.err;
}

TEST(Find, RefusesWhatItCannotDo) {
  const Program program;
  program.Write("flight.cdb",
                Flight("find(1 .. 1000 log, until: mean(step) > 1 ms)", "  repeats 9\n"));
  const Finished until = program.Run({"run", "flight.cdb", "--until", "5%"});
  EXPECT_EQ(until.status, 2);
  EXPECT_NE(until.err.find("'flight' has a search"), std::string::npos) << until.err;
}

}  // namespace
}  // namespace cdb::tests
