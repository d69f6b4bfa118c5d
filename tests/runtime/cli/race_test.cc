// Races (`race( )`) as users see them: the runs that they take, and what they find. Who wins among
// real times is not tested, except where one is a thousand times slower.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/figures/points.h"
#include "runtime/figures/races/races.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using races::Outcome;

/// By the fastest cycle, which no stall makes slower.
constexpr const char* kUneven =
    "benchmark uneven {\n  cycles 4\n  repeats 30\n  detector simple\n  record timing\n"
    "  world.side 4000\n"
    "  objects { quantity race(2000, 2, 1000, by: min(step)); size 1 }\n}\n";

/// Alike, so that all repeats are run, unless the noise of the machine looks like a difference.
std::string Alike(const std::string& more = "") {
  return "benchmark alike {\n  cycles 2\n  repeats 9\n  detector race(sap, dbvt)\n  record timing\n"
         "  seed sweep(1, 2, 3)\n  world.side 100\n  objects { quantity 3; size 1 }\n" +
         more + "}\n";
}

struct FoundRaces {
  std::vector<races::PlacedRace> races;
  std::size_t done = 0, missing = 0, skipped = 0;
  bool HaveEnded() const {
    return std::ranges::all_of(races, [](const auto& of) { return of.race.HasEnded(); });
  }
};
FoundRaces ReadRaces(const std::filesystem::path& path) {
  const results::ResultFile file(path);
  FoundRaces found{races::RunRaces(file), 0, 0, 0};
  for (const figures::Cell& cell : figures::AllCells(file)) {
    const results::Status status = file.ReadStatus(cell);
    found.done += status == results::Status::kDone;
    found.missing += status == results::Status::kMissing;
    found.skipped += status == results::Status::kSkipped;
  }
  return found;
}

TEST(RaceCommand, DropsTheSlowOnesAndSaysWhoWon) {
  const Program program;
  program.Write("uneven.cdb", kUneven);
  EXPECT_EQ(program.Run({"check", "uneven.cdb"}).out,
            "uneven.cdb: uneven: a race: 21 to 90 runs\n");
  const Finished dry = program.Run({"run", "uneven.cdb", "--dry-run"});
  EXPECT_NE(dry.out.find("as the results of one another ask"), std::string::npos) << dry.out;
  const Finished run = program.Run({"run", "uneven.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("0 of 1 races have ended; 18 runs next"), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("Race of quantity by min(step)"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("Which quantity has the least min(step)?\n    2. Next is 1000, with "),
            std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("1 race: 1 won."), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("slower than 2 "), std::string::npos) << run.out;
  const FoundRaces found = ReadRaces(program.folder() / "uneven.h5");
  ASSERT_EQ(found.races.size(), 1u);
  EXPECT_EQ(found.races[0].With(Outcome::kWon), std::vector<std::size_t>{1});
  EXPECT_EQ(found.done, 21u);
  EXPECT_EQ(found.missing, 0u) << "what it does not need is not missing";
  EXPECT_EQ(found.skipped, 69u);
  // The file stores what the model finds.
  const hdf5::File file = hdf5::File::Open(program.folder() / "uneven.h5");
  EXPECT_EQ(file.OpenDataset("race/outcome").Read(), (std::vector<double>{2, 1, 2}));
  EXPECT_EQ(file.OpenDataset("race/repeats").Read(), (std::vector<double>{7, 7, 7}));
  EXPECT_EQ(file.OpenDataset("race/against").Read(), (std::vector<double>{1, 1, 1}));
  EXPECT_EQ(file.OpenDataset("race/ratio").Read()[0], found.races[0].race.standings[0].ratio);
  EXPECT_EQ(program.Run({"check", "uneven.h5"}).status, 0);
  const Finished json = program.Run({"show", "uneven.h5", "--json"});
  EXPECT_NE(json.out.find("\"outcome\":\"dropped\""), std::string::npos) << json.out;
  // Nothing is left to do.
  const Finished again = program.Run({"run", "uneven.cdb"});
  EXPECT_NE(again.err.find("is complete"), std::string::npos) << again.err;
  EXPECT_EQ(program.Run({"report", "uneven.h5"}).status, 0);
}

TEST(RaceCommand, MarksRunsOfAPartAsNoRace) {
  const Program program;
  program.Write("uneven.cdb", kUneven);
  ASSERT_EQ(program.Run({"run", "uneven.cdb", "-q"}).status, 0);
  const Finished part = program.Run({"show", "uneven.h5", "--select", "quantity=2,1000"});
  EXPECT_EQ(part.status, 0) << part.err;
  EXPECT_EQ(part.out.find("Race of"), std::string::npos) << part.out;
}

TEST(RaceCommand, IsTheSameInShards) {
  const Program program;
  program.Write("alike.cdb", Alike());
  for (const char* shard : {"1/2", "2/2", "1/2"}) {
    const Finished run = program.Run({"run", "alike.cdb", "-q", "--shard", shard});
    EXPECT_EQ(run.status, 0) << shard << run.err;
  }
  const Finished merge = program.Run({"merge", "-o", "alike.h5", "--remove", "alike.runs"});
  EXPECT_EQ(merge.status, 0) << merge.err;
  EXPECT_FALSE(program.Exists("alike.runs"));
  const FoundRaces found = ReadRaces(program.folder() / "alike.h5");
  EXPECT_EQ(found.races.size(), 3u) << "one for each seed";
  EXPECT_TRUE(found.HaveEnded());
  EXPECT_EQ(found.missing, 0u);
}

TEST(RaceCommand, GoesOnFromPartOfItsRuns) {
  const Program program;
  program.Write("alike.cdb", Alike());
  EXPECT_EQ(program.Run({"run", "alike.cdb", "-q", "--shard", "1/2"}).status, 0);
  EXPECT_EQ(program.Run({"merge", "-o", "alike.h5", "alike.runs"}).status, 0);
  const FoundRaces part = ReadRaces(program.folder() / "alike.h5");
  EXPECT_GT(part.missing, 0u);
  EXPECT_FALSE(part.HaveEnded());
  EXPECT_EQ(program.Run({"check", "alike.h5"}).status, 3);
  const Finished shown = program.Run({"show", "alike.h5"});
  EXPECT_NE(shown.out.find("not finished"), std::string::npos) << shown.out;
  EXPECT_EQ(program.Run({"run", "alike.cdb", "-q"}).status, 0);
  const FoundRaces now = ReadRaces(program.folder() / "alike.h5");
  EXPECT_TRUE(now.HaveEnded());
  EXPECT_EQ(now.missing, 0u);
}

/// A race whose runs are there already runs none, and decides by those that it would have run.
TEST(RaceCommand, KeepsTheRunsOfASweep) {
  const Program program;
  std::string swept = kUneven;
  swept.replace(swept.find("race("), 4, "sweep").erase(swept.find(", by: min(step)"), 15);
  program.Write("uneven.cdb", swept);
  ASSERT_EQ(program.Run({"run", "uneven.cdb", "-q"}).status, 0);
  program.Write("uneven.cdb", kUneven);
  const Finished run = program.Run({"run", "uneven.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("runs are kept"), std::string::npos) << run.err;
  const FoundRaces found = ReadRaces(program.folder() / "uneven.h5");
  EXPECT_EQ(found.races.at(0).race.standings[0].repeats, 7u);
  EXPECT_EQ(found.missing, 0u);
}

/// A run that is measured again may decide otherwise.
TEST(RaceCommand, GoesOnAfterARunIsRepeated) {
  const Program program;
  program.Write("alike.cdb", Alike());
  ASSERT_EQ(program.Run({"run", "alike.cdb", "-q"}).status, 0);
  const std::string id =
      results::ResultFile(program.folder() / "alike.h5").ReadText("run_id", {{0, 0}, 0});
  const Finished retry = program.Run({"run", "alike.cdb", "-q", "--only", id, "-o", "alike.h5"});
  EXPECT_EQ(retry.status, 0) << retry.err;
  const FoundRaces found = ReadRaces(program.folder() / "alike.h5");
  EXPECT_EQ(found.races.size(), 3u);
  EXPECT_TRUE(found.HaveEnded());
  EXPECT_EQ(found.missing, 0u);
}

TEST(RaceCommand, DropsThoseThatFail) {
  const Program program;
  program.Write("fits.cdb",
                "benchmark fits {\n  cycles 2\n  repeats 8\n  record timing\n"
                "  world.side race(3, 60, by: min(step))\n"
                "  objects { quantity 30; size 2; location uniform }\n}\n");
  const Finished run = program.Run({"run", "fits.cdb"});
  EXPECT_EQ(run.status, 3) << run.err;
  const FoundRaces found = ReadRaces(program.folder() / "fits.h5");
  ASSERT_EQ(found.races.size(), 1u);
  EXPECT_EQ(found.races[0].race.standings[0].outcome, Outcome::kFailed);
  EXPECT_EQ(found.races[0].race.standings[1].outcome, Outcome::kWon);
  EXPECT_EQ(found.done, 1u);
  EXPECT_EQ(program.Run({"run", "fits.cdb", "-q", "--retry", "failed"}).status, 3);
  EXPECT_EQ(ReadRaces(program.folder() / "fits.h5").done, 1u);
}

TEST(RaceCommand, RefusesWhatItCannotDo) {
  const Program program;
  program.Write("alike.cdb", Alike());
  const Finished until = program.Run({"run", "alike.cdb", "--until", "5%"});
  EXPECT_EQ(until.status, 2);
  EXPECT_NE(until.err.find("'alike' has a race"), std::string::npos) << until.err;
}

TEST(RaceCommand, IsVerifiedAtEveryValue) {
  const Program program;
  program.Write("alike.cdb", Alike());
  const Finished verified = program.Run({"verify", "alike.cdb"});
  EXPECT_EQ(verified.status, 0) << verified.err;
  EXPECT_NE(verified.err.find("6/6"), std::string::npos) << verified.err;
}

}  // namespace
}  // namespace cdb::tests
