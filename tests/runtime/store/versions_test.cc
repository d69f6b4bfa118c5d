// Files of the previous schema version can be read, and their shards merged.
#include "runtime/store/versions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <functional>
#include <span>

#include "runtime/store/files/safe_file.h"
#include "runtime/store/shards/reference_shard.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"
#include "tests/runtime/store/store_fixture.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

using testing::ElementsAre;

TEST(Versions, PathsOfOldFiles) {
  EXPECT_EQ(store::PathIn(2, "run/host"), "run/host");
  EXPECT_EQ(store::PathIn(1, "run/host"), "host");
  EXPECT_EQ(store::PathIn(1, "run/load_average"), "load");
  EXPECT_EQ(store::PathIn(1, "accuracy/step_size"), "accuracy/timestep");
  EXPECT_EQ(store::PathIn(1, "accuracy/energy"), "accuracy/energy");
  EXPECT_EQ(store::PathIn(1, "status"), "status");
}

/// Two cases by two time steps, made by cdb with schema version 1, which stored the axis `load` as
/// `load_axis`.
TEST(Versions, AResultOfVersion1IsRead) {
  const store::ResultFile file(SourceFolder() / "tests" / "golden" / "results" / "version1.h5");
  ASSERT_EQ(file.axes().size(), 2u);
  EXPECT_EQ(file.axes()[0].name, "load");
  EXPECT_THAT(file.axes()[0].values,
              ElementsAre(plan::Coordinate("calm"), plan::Coordinate("storm")));
  EXPECT_EQ(file.axes()[1].name, "hz");
  EXPECT_EQ(file.axes()[1].unit, "");
  for (std::size_t load = 0; load < 2; ++load)
    for (std::size_t hz = 0; hz < 2; ++hz) {
      const store::ResultFile::Cell cell = {{load, hz}, 0};
      EXPECT_EQ(file.ReadStatus(cell), store::Status::kDone);
      EXPECT_EQ(file.ReadJudgement(cell).verdict, measure::Verdict::kUnknown);
      EXPECT_EQ(file.ReadJudgement(cell).first_bad_cycle, -1);
      const std::uint64_t cycles = hz == 0 ? 4 : 8;
      EXPECT_EQ(file.ReadCycleCount(cell), cycles);
      EXPECT_EQ(file.ReadDuration(measure::Phase::kStep, cell).size(), cycles);
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

/// Changes a shard, and seals it as if it had been written so.
void Change(const std::filesystem::path& shard, const std::function<void(hid_t file)>& change) {
  const std::vector<std::byte> image = files::ReadSealed(shard);
  WriteFile(shard, std::string(reinterpret_cast<const char*>(image.data()), image.size()));
  const hid_t file = H5Fopen(shard.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  change(file);
  H5Fclose(file);
  const std::string bytes = ReadFile(shard);
  files::WriteSealed(std::as_bytes(std::span(bytes)), shard);
}

/// Turns a shard into one of version 1, as far as reading is concerned.
void MakeVersion1(hid_t file) {
  const auto move = [file](const std::string& from, const std::string& to) {
    if (H5Lexists(file, from.c_str(), H5P_DEFAULT) <= 0) return;
    EXPECT_GE(H5Lmove(file, from.c_str(), file, to.c_str(), H5P_DEFAULT, H5P_DEFAULT), 0) << from;
  };
  for (const char* name :
       {"started", "peak_rss", "place_time", "build_time", "harness", "fill_fraction", "state_hash",
        "run_id", "host", "message", "omitted", "needs"})
    move(std::string("run/") + name, name);
  move("run/load_average", "load");
  if (H5Lexists(file, "accuracy", H5P_DEFAULT) > 0) move("accuracy/step_size", "accuracy/timestep");
  if (H5Lexists(file, "run", H5P_DEFAULT) > 0) H5Ldelete(file, "run", H5P_DEFAULT);
  const int version = 1;
  const hid_t attribute = H5Aopen(file, "schema_version", H5P_DEFAULT);
  EXPECT_GE(H5Awrite(attribute, H5T_NATIVE_INT, &version), 0);
  H5Aclose(attribute);
}

TEST(Versions, ShardsOfVersion1AreMergedWithThoseOfThisOne) {
  const plan::Plan plan =
      MakePlan({NumberAxis("quantity", {10, 20, 30})}, 1,
               {.record = {"timing", "stability", "contacts"}, .metrics = {"position"}});
  const TemporaryFolder folder;
  for (std::size_t i = 0; i < 2; ++i)
    shards::WriteShard(plan, plan.runs[i], FakeResult(plan.runs[i]).result, TestProvenance(),
                       folder.path());
  const plan::Run& reference = plan.references[0];
  store::RunResult result;
  result.status = store::Status::kDone;
  shards::WriteReference(plan.Sha256(), reference, result,
                         std::vector<double>(measure::SampleShapeOf(reference.scene)->Count(), 0.5),
                         {}, folder.path());
  Change(folder / (plan.runs[0].id + ".h5"), MakeVersion1);
  Change(folder / (reference.id + ".h5"), MakeVersion1);
  // A resumed run reads it from the shards that it finds.
  const shards::ShardInfo info = shards::ReadShardInfo(folder / (plan.runs[0].id + ".h5"));
  EXPECT_EQ(info.run_id, plan.runs[0].id);
  EXPECT_EQ(info.outcome.status, store::Status::kDone);

  shards::Merge(plan, {}, folder.path(), folder / "out.h5");
  const store::ResultFile file(folder / "out.h5");
  for (std::size_t i = 0; i < 2; ++i) {
    const FakeResult fake(plan.runs[i]);
    const store::ResultFile::Cell cell = {plan.runs[i].at, 0};
    EXPECT_EQ(file.ReadStatus(cell), store::Status::kDone);
    EXPECT_EQ(file.ReadText("host", cell), fake.result.host);
    EXPECT_EQ(file.ReadText("needs", cell), fake.result.decisions);
    EXPECT_EQ(file.ReadReal("load_average", cell), fake.result.load);
    EXPECT_EQ(file.ReadReal("peak_rss", cell), fake.result.scalars.peak_rss_bytes);
    EXPECT_EQ(file.ReadReal("accuracy/position", cell),
              fake.result.errors.values.at("position")[0]);
    EXPECT_EQ(file.ReadSeries("contacts", cell).size(), 5u);
    const auto steps = file.ReadDuration(measure::Phase::kStep, cell);
    ASSERT_EQ(steps.size(), 5u);
    EXPECT_EQ(steps[4], ValueAt(plan.runs[i], *measure::FindSeries("duration"), 5 * 5 + 4));
  }
  EXPECT_EQ(file.ReadStatus({{2}, 0}), store::Status::kMissing);
  EXPECT_EQ(file.ReadCycleCount({{2}, 0}), 0u);
}

/// Of a file from before a series, a number and a text were added.
void LeaveOutArrays(hid_t file) {
  for (const char* array : {"displaced", "run/peak_rss", "run/host"})
    EXPECT_GE(H5Ldelete(file, array, H5P_DEFAULT), 0) << array;
}

TEST(Versions, FilesFromBeforeAnArrayWasAddedAreMerged) {
  const plan::Plan plan =
      MakePlan({NumberAxis("quantity", {10, 20})}, 1, {.record = {"timing", "stability"}});
  const TemporaryFolder folder, shards, replaced;
  const auto write = [&](const plan::Run& run, const TemporaryFolder& to) {
    shards::WriteShard(plan, run, FakeResult(run).result, TestProvenance(), to.path());
  };
  const store::ResultFile::Cell old = {plan.runs[0].at, 0}, today = {plan.runs[1].at, 0};
  const auto check = [&](const std::filesystem::path& path) {
    const store::ResultFile file(path);
    EXPECT_TRUE(std::isnan(file.ReadReal("peak_rss", old)));
    EXPECT_EQ(file.ReadText("host", old), "");
    for (const double value : file.ReadSeries("displaced", old)) EXPECT_LT(value, 0);
    for (const auto& cell : {old, today}) {
      EXPECT_EQ(file.ReadStatus(cell), store::Status::kDone);
      EXPECT_EQ(file.ReadDuration(measure::Phase::kStep, cell).size(), 5u);
    }
    const FakeResult wanted(plan.runs[1]);
    EXPECT_EQ(file.ReadReal("peak_rss", today), wanted.result.scalars.peak_rss_bytes);
    EXPECT_EQ(file.ReadText("host", today), wanted.result.host);
  };
  for (const plan::Run& run : plan.runs) write(run, shards);
  shards::Merge(plan, {}, shards.path(), folder / "result.h5");

  Change(shards / (plan.runs[0].id + ".h5"), LeaveOutArrays);
  shards::Merge(plan, {}, shards.path(), folder / "merged.h5");
  check(folder / "merged.h5");

  // A run is repeated in a result.
  Change(folder / "result.h5", LeaveOutArrays);
  write(plan.runs[1], replaced);
  shards::Merge(plan, {}, {replaced.path()}, folder / "result.h5", folder / "result.h5");
  check(folder / "result.h5");
}

}  // namespace
}  // namespace cdb::tests
