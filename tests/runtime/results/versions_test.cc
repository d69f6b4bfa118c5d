// Files of the previous schema version can be read, and runs of earlier builds merged.
#include "runtime/results/versions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "runtime/results/files/seal.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

using testing::ElementsAre;

TEST(Versions, PathsOfOldFiles) {
  EXPECT_EQ(results::PathIn(2, "run/host"), "run/host");
  EXPECT_EQ(results::PathIn(1, "run/host"), "host");
  EXPECT_EQ(results::PathIn(1, "run/load_average"), "load");
  EXPECT_EQ(results::PathIn(1, "accuracy/step_size"), "accuracy/timestep");
  EXPECT_EQ(results::PathIn(1, "accuracy/energy"), "accuracy/energy");
  EXPECT_EQ(results::PathIn(1, "status"), "status");
}

/// Two cases by two time steps, made by cdb with schema version 1, which stored the axis `load` as
/// `load_axis`.
TEST(Versions, AResultOfVersion1IsRead) {
  const results::ResultFile file(SourceFolder() / "tests" / "golden" / "results" / "version1.h5");
  ASSERT_EQ(file.axes().size(), 2u);
  EXPECT_EQ(file.axes()[0].name, "load");
  EXPECT_THAT(file.axes()[0].values,
              ElementsAre(plan::Coordinate("calm"), plan::Coordinate("storm")));
  EXPECT_EQ(file.axes()[1].name, "hz");
  EXPECT_EQ(file.axes()[1].unit, "");
  for (std::size_t load = 0; load < 2; ++load)
    for (std::size_t hz = 0; hz < 2; ++hz) {
      const results::ResultFile::Cell cell = {{load, hz}, 0};
      EXPECT_EQ(file.ReadStatus(cell), results::Status::kDone);
      EXPECT_EQ(file.ReadJudgement(cell).verdict, protocol::Verdict::kUnknown);
      EXPECT_EQ(file.ReadJudgement(cell).first_bad_cycle, -1);
      const std::uint64_t cycles = hz == 0 ? 4 : 8;
      EXPECT_EQ(file.ReadCycleCount(cell), cycles);
      EXPECT_EQ(file.ReadDuration(protocol::Phase::kStep, cell).size(), cycles);
      EXPECT_EQ(file.ReadText("state_hash", cell).size(), 16u);
      EXPECT_EQ(file.ReadText("message", cell), "");
      EXPECT_EQ(file.ReadText("host", cell), "example");
      EXPECT_GT(file.ReadReal("started", cell), 1.7e9);
      EXPECT_GE(file.ReadReal("load_average", cell), 0);
      EXPECT_GT(file.ReadReal("peak_rss", cell), 1e6);
      EXPECT_EQ(file.ReadReal("accuracy/timestep", cell), hz == 0 ? 0.1 : 0.05);
      EXPECT_GT(file.ReadReal("accuracy/position", cell), 0);
    }
  EXPECT_TRUE(file.Has("omitted"));
  EXPECT_TRUE(file.ReadReferenceTroubles().empty());
  EXPECT_NE(file.ReadProvenance("plan_text"), "");
}

/// Changes a results file, and seals it as if it had been written so.
void Change(const std::filesystem::path& path, const std::function<void(hid_t file)>& change) {
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - sizeof(files::Seal));
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  change(file);
  H5Fclose(file);
  files::AppendSeal(path, path);
}

/// A series, a number and a text.
constexpr const char* kAdded[] = {"displaced", "run/peak_rss", "run/host"};

/// Of a file from before they were added.
void LeaveOutArrays(hid_t file) {
  for (const char* array : kAdded) EXPECT_GE(H5Ldelete(file, array, H5P_DEFAULT), 0) << array;
}

/// The same for the record of a run.
void LeaveOutArrays(const plan::Plan& plan, const plan::Run& run,
                    const std::filesystem::path& folder) {
  auto journal = journal::Journal::OpenToWrite(folder, plan.Sha256());
  const journal::Record now = *journal.Read(run.id);
  journal::About about = *now.about;
  journal::Record before;
  before.run_id = run.id;
  const auto is_added = [](const std::string& name) {
    return std::ranges::find(kAdded, name) != std::end(kAdded);
  };
  std::vector<std::uint32_t> places;
  about.arrays.clear();
  for (const journal::RecordedArray& array : now.about->arrays) {
    places.push_back(static_cast<std::uint32_t>(about.arrays.size()));
    if (!is_added(array.name)) about.arrays.push_back(array);
  }
  std::span<const std::byte> left(now.bytes);
  for (const journal::Record::Chunk& chunk : now.chunks) {
    if (!is_added(now.about->arrays[chunk.array].name))
      before.Add(places[chunk.array], chunk.index, left.first(chunk.bytes));
    left = left.subspan(chunk.bytes);
  }
  for (std::size_t i = 0; i < now.numbers.size(); ++i)
    if (!is_added(now.about->numbers[i])) before.numbers.push_back(now.numbers[i]);
  for (std::size_t i = 0; i < now.texts.size(); ++i)
    if (!is_added(now.about->texts[i])) before.texts.push_back(now.texts[i]);
  std::erase_if(about.numbers, is_added);
  std::erase_if(about.texts, is_added);
  before.about = std::make_shared<const journal::About>(std::move(about));
  journal.Write(before);
}

TEST(Versions, FilesFromBeforeAnArrayWasAddedAreMerged) {
  const plan::Plan plan =
      MakePlan({NumberAxis("quantity", {10, 20})}, 1, {.record = {"timing", "stability"}});
  const TemporaryFolder folder, runs, replaced;
  const auto write = [&](const plan::Run& run, const TemporaryFolder& to) {
    WriteRun(plan, run, FakeResult(run).result, TestProvenance(), to.path());
  };
  const results::ResultFile::Cell old = {plan.runs[0].at, 0}, today = {plan.runs[1].at, 0};
  const auto check = [&](const std::filesystem::path& path) {
    const results::ResultFile file(path);
    EXPECT_TRUE(std::isnan(file.ReadReal("peak_rss", old)));
    EXPECT_EQ(file.ReadText("host", old), "");
    for (const double value : file.ReadSeries("displaced", old)) EXPECT_LT(value, 0);
    for (const auto& cell : {old, today}) {
      EXPECT_EQ(file.ReadStatus(cell), results::Status::kDone);
      EXPECT_EQ(file.ReadDuration(protocol::Phase::kStep, cell).size(), 5u);
    }
    const FakeResult wanted(plan.runs[1]);
    EXPECT_EQ(file.ReadReal("peak_rss", today), wanted.result.scalars.peak_rss_bytes);
    EXPECT_EQ(file.ReadText("host", today), wanted.result.host);
  };
  for (const plan::Run& run : plan.runs) write(run, runs);
  journal::Merge(plan, {}, runs.path(), folder / "result.h5");

  LeaveOutArrays(plan, plan.runs[0], runs.path());
  journal::Merge(plan, {}, runs.path(), folder / "merged.h5");
  check(folder / "merged.h5");

  // A run is repeated in a result.
  Change(folder / "result.h5", [](hid_t file) { LeaveOutArrays(file); });
  write(plan.runs[1], replaced);
  journal::Merge(plan, {}, {replaced.path()}, folder / "result.h5", folder / "result.h5");
  check(folder / "result.h5");
}

}  // namespace
}  // namespace cdb::tests
