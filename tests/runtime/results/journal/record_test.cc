// A run is read from the merged file as it was written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime/results/hdf5/file.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

using plan::Plan;
using testing::ElementsAre;

const SceneSize kEverything = {
    .cycles = 7,
    .objects = 2,
    .record = {"timing", "counts", "energy", "stability", "contacts", "poses", "boxes", "memory"}};

Plan TwoAxes(const SceneSize& size = kEverything) {
  return MakePlan({NumberAxis("quantity", {10, 20, 30}), NumberAxis("size", {0.5, 1.5}, "m"),
                   TextAxis("detector", {"simple", "dbvt"})},
                  2, size);
}

/// Compares every series of a cell that holds one run, value by value.
void ExpectSeries(const results::ResultFile& file, const results::ResultFile::Cell& cell,
                  const plan::Run& run, std::uint64_t n_cycles) {
  const std::uint64_t cycles = run.scene.world.Count("cycles");
  for (const protocol::Series& series : protocol::AllSeries()) {
    if (!protocol::IsRecordedBy(series, run.scene)) continue;
    if (series.shape != protocol::SeriesShape::kScalar &&
        series.shape != protocol::SeriesShape::kPhase)
      continue;
    for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase) {
      const bool by_phase = series.shape == protocol::SeriesShape::kPhase;
      const std::vector<double> values =
          by_phase ? file.ReadDuration(static_cast<protocol::Phase>(phase), cell)
                   : file.ReadSeries(series.name, cell);
      ASSERT_EQ(values.size(), n_cycles) << series.name;
      for (std::size_t i = 0; i < n_cycles; ++i)
        ASSERT_EQ(values[i], ValueAt(run, series, by_phase ? phase * cycles + i : i))
            << series.name << " phase " << phase << " cycle " << i;
      if (!by_phase) break;
    }
  }
}

results::ResultFile Merged(const Plan& plan, const TemporaryFolder& folder) {
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  return results::ResultFile(folder / "out.h5");
}

TEST(Record, HoldsEverySeriesOfItsRun) {
  const Plan plan = TwoAxes();
  const TemporaryFolder folder;
  const plan::Run& run = plan.runs[13];
  const FakeResult fake(run);
  WriteRun(plan, run, fake.result, TestProvenance(), folder.path());
  ASSERT_THAT(FilesIn(folder.path()), ElementsAre("runs.journal"));

  const results::ResultFile file = Merged(plan, folder);
  const results::ResultFile::Cell cell = {run.at, run.rep};
  ExpectSeries(file, cell, run, 7);
  EXPECT_EQ(file.ReadStatus(cell), results::Status::kDone);
  EXPECT_EQ(file.ReadCycleCount(cell), 7u);
  EXPECT_EQ(file.ReadText("state_hash", cell), fake.result.state_hash);
  EXPECT_EQ(file.ReadText("run_id", cell), run.id);
  EXPECT_EQ(file.ReadText("host", cell), fake.result.host);
  EXPECT_EQ(file.ReadText("message", cell), "");
  EXPECT_EQ(file.ReadText("omitted", cell), fake.result.omitted);
  EXPECT_EQ(file.ReadText("needs", cell), fake.result.decisions);
  EXPECT_NE(fake.result.decisions, "");
  EXPECT_EQ(file.ReadReal("started", cell), fake.result.started_s);
  EXPECT_EQ(file.ReadReal("load_average", cell), fake.result.load);
  EXPECT_EQ(file.ReadReal("peak_rss", cell), fake.result.scalars.peak_rss_bytes);
  EXPECT_EQ(file.ReadReal("place_time", cell), fake.result.scalars.place_ns);
  EXPECT_EQ(file.ReadReal("build_time", cell), fake.result.scalars.build_ns);
  EXPECT_EQ(file.ReadReal("fill_fraction", cell), fake.result.scalars.fill_fraction);
  EXPECT_EQ(file.ReadReal("harness", cell), fake.result.scalars.harness_ns);
  EXPECT_EQ(file.ReadProvenance("cpu"), "a µ-processor");
  EXPECT_EQ(file.ReadProvenance("no such fact"), "");
}

TEST(Record, HasNoDatasetThatNobodyAskedFor) {
  const Plan plan = TwoAxes({.record = {"timing"}});
  const TemporaryFolder folder;
  WriteRun(plan, plan.runs[0], FakeResult(plan.runs[0]).result, {}, folder.path());
  const results::ResultFile file = Merged(plan, folder);
  for (const protocol::Series& series : protocol::AllSeries())
    EXPECT_EQ(file.Has(series.name), series.name == "duration") << series.name;
  for (const char* name : {"body", "pose", "contact_row", "contact_body", "contact_first"})
    EXPECT_FALSE(file.Has(name)) << name;
  EXPECT_THROW(file.ReadSeries("pairs", {{0, 0, 0}, 0}), files::StoreError);
}

TEST(Record, OfARunThatCrashedKeepsItsCyclesAndNoMore) {
  const Plan plan = TwoAxes();
  const TemporaryFolder folder;
  for (const std::uint64_t n_cycles : {0, 3}) {
    const plan::Run& run = plan.runs[n_cycles];
    FakeResult fake(run, results::Status::kCrashed, 7);
    fake.result.n_cycles = n_cycles;  // values after them are not valid
    WriteRun(plan, run, fake.result, TestProvenance(), folder.path());
    const results::ResultFile file = Merged(plan, folder);
    const results::ResultFile::Cell cell = {run.at, run.rep};
    EXPECT_EQ(file.ReadStatus(cell), results::Status::kCrashed);
    EXPECT_EQ(file.ReadCycleCount(cell), n_cycles);
    EXPECT_EQ(file.ReadText("message", cell), fake.result.message);
    EXPECT_EQ(file.ReadText("state_hash", cell), "");
    ExpectSeries(file, cell, run, n_cycles);
    // Readers of the file itself find fill values after these cycles.
    const hdf5::File raw = hdf5::File::Open(folder / "out.h5");
    const auto read = [&](const char* name) {
      const hdf5::Dataset dataset = raw.OpenDataset(name);
      hdf5::Shape start(run.at.begin(), run.at.end()), count = dataset.shape();
      start.push_back(run.rep);
      std::fill_n(count.begin(), start.size(), 1);
      start.resize(count.size());
      return dataset.Read(start, count);
    };
    const std::vector<double> pairs = read("pairs"), poses = read("poses"), boxes = read("boxes");
    ASSERT_EQ(pairs.size(), 7u);
    ASSERT_EQ(poses.size(), 7u * 2 * protocol::kPoseSize);
    for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_EQ(pairs[i] == -1, i >= n_cycles) << i;
    for (std::size_t i = 0; i < poses.size(); ++i)
      EXPECT_EQ(std::isnan(poses[i]), i >= n_cycles * 2 * protocol::kPoseSize) << i;
    ASSERT_EQ(boxes.size(), 7u * 8 * protocol::kBoxSize);
    for (std::size_t i = 0; i < boxes.size(); ++i)
      EXPECT_EQ(std::isnan(boxes[i]), i >= n_cycles * 8 * protocol::kBoxSize) << i;
  }
}

TEST(Record, IsNotMuchLargerThanItsValues) {
  const Plan plan = TwoAxes({.cycles = 1000, .record = {"timing", "counts", "stability"}});
  const TemporaryFolder folder;
  const plan::Run& run = plan.runs[0];
  WriteRun(plan, run, FakeResult(run).result, TestProvenance(), folder.path());
  const auto record = journal::Journals({folder.path()}).Find(run.id);
  ASSERT_TRUE(record);
  EXPECT_LT(record->EncodeFacts().size(), 2'000u);
  EXPECT_LT(record->about->Encode().size(), 3'000u) << "shared by many runs";
}

TEST(Record, OfARunWithoutObjectsOrAxes) {
  const Plan plan = MakePlan({}, 1, {.cycles = 1, .objects = 0, .record = {"poses", "contacts"}});
  const TemporaryFolder folder;
  FakeResult fake(plan.runs[0]);
  WriteRun(plan, plan.runs[0], fake.result, {}, folder.path());
  const results::ResultFile file = Merged(plan, folder);
  EXPECT_TRUE(file.axes().empty());
  EXPECT_EQ(file.ReadStatus({{}, 0}), results::Status::kDone);
  EXPECT_EQ(file.ReadSeries("contacts", {{}, 0}).size(), 1u);
}

TEST(Record, WrittenTwiceIsTheSame) {
  const Plan plan = TwoAxes();
  const TemporaryFolder folder;
  const plan::Run& run = plan.runs[5];
  const FakeResult fake(run);
  for (int i = 0; i < 2; ++i) WriteRun(plan, run, fake.result, TestProvenance(), folder.path());
  EXPECT_EQ(RunsIn(folder.path()).size(), 1u);
  ExpectSeries(Merged(plan, folder), {run.at, run.rep}, run, 7);
}

TEST(Record, InfoNamesRunAndStatus) {
  const Plan plan = TwoAxes();
  const TemporaryFolder folder;
  const plan::Run& run = plan.runs[2];
  WriteRun(plan, run, FakeResult(run, results::Status::kTimedOut, 4).result, {}, folder.path());
  const auto info = journal::InfoOf(*journal::Journals({folder.path()}).Find(run.id));
  EXPECT_EQ(info.run_id, run.id);
  EXPECT_EQ(info.outcome.status, results::Status::kTimedOut);
}

TEST(Record, LongRunsAreCutIntoChunksUnderOneMebibyte) {
  // 50,000 cycles of 6 phases are 2.4 MB, 3 cycles of 40,000 poses 2.2 MB each.
  for (const SceneSize& size : {SceneSize{.cycles = 50000, .objects = 1, .record = {"timing"}},
                                SceneSize{.cycles = 3, .objects = 40000, .record = {"poses"}}}) {
    const Plan plan = MakePlan({NumberAxis("quantity", {10})}, 1, size);
    const TemporaryFolder folder;
    WriteRun(plan, plan.runs[0], FakeResult(plan.runs[0]).result, {}, folder.path());
    journal::Merge(plan, {}, folder.path(), folder / "out.h5");
    ExpectSeries(results::ResultFile(folder / "out.h5"), {{0}, 0}, plan.runs[0], size.cycles);
  }
}

TEST(StatusNames, AreThoseOfTheContract) {
  std::string names;
  for (int i = 0; i <= static_cast<int>(results::Status::kTimedOut); ++i)
    names += std::string(results::StatusName(static_cast<results::Status>(i))) + " ";
  EXPECT_EQ(names, "missing done skipped failed crashed timed_out ");
}

}  // namespace
}  // namespace cdb::tests
