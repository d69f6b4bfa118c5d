// Merging journals neither adds nor loses data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

using plan::Plan;

using testing::ElementsAre;
using testing::HasSubstr;

results::ResultFile::Cell CellOf(const plan::Run& run) { return {run.at, run.rep}; }

void ExpectCell(const results::ResultFile& file, const plan::Run& run, results::Status status,
                std::uint64_t n_cycles) {
  const results::ResultFile::Cell cell = CellOf(run);
  SCOPED_TRACE(run.id);
  const FakeResult fake(run, status, n_cycles);
  ASSERT_EQ(file.ReadStatus(cell), status);
  ASSERT_EQ(file.ReadCycleCount(cell), n_cycles);
  EXPECT_EQ(file.ReadText("run_id", cell), run.id);
  EXPECT_EQ(file.ReadText("state_hash", cell), fake.result.state_hash);
  EXPECT_EQ(file.ReadText("message", cell), fake.result.message);
  EXPECT_EQ(file.ReadText("host", cell), fake.result.host);
  EXPECT_EQ(file.ReadText("omitted", cell), fake.result.omitted);
  EXPECT_EQ(file.ReadText("needs", cell), fake.result.decisions);
  EXPECT_EQ(file.ReadReal("started", cell), fake.result.started_s);
  EXPECT_EQ(file.ReadReal("peak_rss", cell), fake.result.scalars.peak_rss_bytes);
  const std::uint64_t cycles = run.scene.world.Count("cycles");
  for (const protocol::Series& series : protocol::AllSeries()) {
    if (!protocol::IsRecordedBy(series, run.scene)) continue;
    if (series.shape != protocol::SeriesShape::kScalar &&
        series.shape != protocol::SeriesShape::kPhase)
      continue;
    for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase) {
      const bool by_phase = series.shape == protocol::SeriesShape::kPhase;
      const auto values = by_phase ? file.ReadDuration(static_cast<protocol::Phase>(phase), cell)
                                   : file.ReadSeries(series.name, cell);
      ASSERT_EQ(values.size(), n_cycles) << series.name;
      for (std::size_t i = 0; i < n_cycles; ++i)
        ASSERT_EQ(values[i], ValueAt(run, series, by_phase ? phase * cycles + i : i))
            << series.name << " phase " << phase << " cycle " << i;
      if (!by_phase) break;
    }
  }
}

Plan Grid() {
  return MakePlan({NumberAxis("quantity", {10, 20, 30}), NumberAxis("aspect_z", {1, 2.5}),
                   TextAxis("detector", {"simple", "sap", "dbvt"})},
                  2, {.cycles = 6}, {{0, 1, 2}, {2, 0, 0}});
}

TEST(Merge, PutsEveryRunInItsCell) {
  const Plan plan = Grid();
  const TemporaryFolder folder;
  std::map<std::string, std::pair<results::Status, std::uint64_t>> ended;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    if (i % 7 == 3) continue;  // has not run yet
    const results::Status status = i % 5 == 0 ? results::Status::kFailed : results::Status::kDone;
    ended[plan.runs[i].id] = {status, status == results::Status::kDone ? 6 : i % 6};
    const auto& [how, n_cycles] = ended[plan.runs[i].id];
    WriteRun(plan, plan.runs[i], FakeResult(plan.runs[i], how, n_cycles).result, TestProvenance(),
             folder.path());
  }
  const std::vector<std::string> before = FilesIn(folder.path());
  const TemporaryFolder target;
  journal::Merge(plan, TestProvenance(), folder.path(), target / "out.h5");
  EXPECT_EQ(FilesIn(folder.path()), before);
  EXPECT_THAT(FilesIn(target.path()), ElementsAre("out.h5"));

  const results::ResultFile file(target / "out.h5");
  EXPECT_EQ(file.axes(), plan.axes);
  EXPECT_EQ(file.repeats(), 2u);
  EXPECT_EQ(file.cycles(), 6u);
  EXPECT_EQ(file.plan_sha256(), plan.Sha256());
  EXPECT_EQ(file.ReadProvenance("plan_text"), yaml::ToYaml(plan));
  EXPECT_EQ(file.ReadProvenance("scenario_text"), plan.scenario_text);
  EXPECT_EQ(file.ReadProvenance("cpu"), "a µ-processor");
  for (const plan::Run& run : plan.runs) {
    if (const auto found = ended.find(run.id); found != ended.end()) {
      ExpectCell(file, run, found->second.first, found->second.second);
      continue;
    }
    EXPECT_EQ(file.ReadStatus(CellOf(run)), results::Status::kMissing);
    EXPECT_EQ(file.ReadCycleCount(CellOf(run)), 0u);
    EXPECT_EQ(file.ReadText("run_id", CellOf(run)), run.id) << "a missing run is named";
    EXPECT_EQ(file.ReadText("omitted", CellOf(run)) + file.ReadText("needs", CellOf(run)), "");
    EXPECT_TRUE(file.ReadDuration(protocol::Phase::kStep, CellOf(run)).empty());
  }
  for (const auto& point : plan.skipped)
    for (std::uint64_t rep = 0; rep < 2; ++rep) {
      EXPECT_EQ(file.ReadStatus({point, rep}), results::Status::kSkipped);
      EXPECT_EQ(file.ReadText("run_id", {point, rep}), "");
    }
}

TEST(Merge, OneRunAtTwoPointsFillsBoth) {
  Plan plan = MakePlan({NumberAxis("quantity", {10, 20}), TextAxis("case", {"a", "b"})}, 1,
                       {.record = {"timing", "contacts"}});
  plan.runs[3].scene = plan.runs[0].scene;
  plan.runs[3].id = plan.runs[0].id;
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs)
    WriteRun(plan, run, FakeResult(run).result, {}, folder.path());
  EXPECT_EQ(RunsIn(folder.path()).size(), 3u);
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  for (const plan::Run& run : plan.runs) ExpectCell(file, run, results::Status::kDone, 5);
  const double rows = file.ReadReal("contact_first", CellOf(plan.runs[1]));
  EXPECT_EQ(rows, static_cast<double>(FakeResult(plan.runs[0]).result.contacts.size()));
}

TEST(Merge, RunsOfOtherLengthsAndRecordsStandSideBySide) {
  Plan plan = MakePlan({TextAxis("case", {"short", "long", "plain"})}, 1, {});
  Resize(plan.runs[0], {.cycles = 2, .objects = 1, .record = {"timing", "poses"}});
  Resize(plan.runs[1],
         {.cycles = 9, .objects = 4, .record = {"poses", "boxes", "contacts", "energy"}});
  Resize(plan.runs[2], {.cycles = 4, .objects = 9, .record = {"counts"}});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs)
    WriteRun(plan, run, FakeResult(run).result, {}, folder.path());
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  EXPECT_EQ(file.cycles(), 9u);
  for (const plan::Run& run : plan.runs)
    ExpectCell(file, run, results::Status::kDone, run.scene.world.Count("cycles"));
  // Run 2 counts contacts, but does not record them.
  EXPECT_EQ(file.ReadReal("contact_first", CellOf(plan.runs[1])), 0);
  const double none = file.ReadReal("contact_first", CellOf(plan.runs[2]));
  EXPECT_NE(none, none);
}

TEST(Merge, OfNoRunsAndOfAGridThatIsAllSkipped) {
  const Plan plan = Grid();
  const TemporaryFolder folder;
  journal::Merge(plan, TestProvenance(), folder.path(), folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  for (const plan::Run& run : plan.runs)
    EXPECT_EQ(file.ReadStatus(CellOf(run)), results::Status::kMissing);
  EXPECT_EQ(file.ReadProvenance("bullet_version"), "3.24");

  const Plan skipped = MakePlan({NumberAxis("quantity", {1, 2})}, 1, {}, {{0}, {1}});
  journal::Merge(skipped, {}, folder.path(), folder / "skipped.h5");
  EXPECT_EQ(results::ResultFile(folder / "skipped.h5").ReadStatus({{1}, 0}),
            results::Status::kSkipped);
}

TEST(Merge, GrowsWithTheFolder) {
  const Plan plan = Grid();
  const TemporaryFolder folder;
  for (std::size_t n = 0; n < 3; ++n) {
    WriteRun(plan, plan.runs[n], FakeResult(plan.runs[n]).result, {}, folder.path());
    journal::Merge(plan, {}, folder.path(), folder / "out.h5");
    const results::ResultFile file(folder / "out.h5");
    for (std::size_t i = 0; i <= n; ++i) ExpectCell(file, plan.runs[i], results::Status::kDone, 6);
  }
}

TEST(Merge, RefusesAJournalOfAnotherPlan) {
  const Plan plan = Grid();
  Plan other = Grid();
  other.axes[1].values[1] = 2.75;
  ASSERT_EQ(other.runs[0].id, plan.runs[0].id) << "the same run in another sweep";
  const TemporaryFolder folder;
  WriteRun(other, other.runs[0], FakeResult(other.runs[0]).result, {}, folder.path());
  WriteFile(folder / "out.h5", "as before");
  try {
    journal::Merge(plan, {}, folder.path(), folder / "out.h5");
    FAIL() << "was merged";
  } catch (const files::StoreError& error) {
    EXPECT_THAT(error.what(), HasSubstr("runs.journal"));
    EXPECT_THAT(error.what(), HasSubstr("another plan"));
    EXPECT_THAT(error.what(), HasSubstr("--fresh"));
  }
  EXPECT_EQ(ReadFile(folder / "out.h5"), "as before");
  EXPECT_EQ(FilesIn(folder.path()).size(), 2u) << "no temporary is left";
}

/// A run of several journals of a folder counts as it was written last; of several arguments, as in
/// the first.
TEST(Merge, TakesTheNewestOfAFolderAndTheFirstOfSeveralFolders) {
  const Plan plan = MakePlan({NumberAxis("quantity", {10})}, 1, {});
  const plan::Run& run = plan.runs[0];
  const TemporaryFolder one, two, folder;
  WriteRun(plan, run, FakeResult(run, results::Status::kCrashed, 2).result, {}, one.path());
  std::filesystem::rename(one / "runs.journal", one / "z.journal");
  WriteRun(plan, run, FakeResult(run).result, {}, one.path());
  WriteRun(plan, run, FakeResult(run, results::Status::kTimedOut, 3).result, {}, two.path());
  const auto status = [&](const std::vector<std::filesystem::path>& places) {
    journal::Merge(plan, {}, places, folder / "out.h5");
    return results::ResultFile(folder / "out.h5").ReadStatus({{0}, 0});
  };
  EXPECT_EQ(status({one.path(), two.path()}), results::Status::kDone);
  EXPECT_EQ(status({two.path(), one.path()}), results::Status::kTimedOut);
  EXPECT_EQ(status({one / "z.journal"}), results::Status::kCrashed);
}

TEST(Merge, FactsThatDifferBetweenRunsAreAllKept) {
  const Plan plan = MakePlan({NumberAxis("quantity", {10, 20, 30})}, 1, {});
  const TemporaryFolder folder;
  for (const char* cpu : {"fast", "slow"}) {
    const plan::Run& run = plan.runs[cpu == std::string_view("slow") ? 1 : 0];
    WriteRun(plan, run, FakeResult(run).result, {{"cpu", cpu}, {"compiler", "gcc"}}, folder.path());
  }
  journal::Merge(plan, {{"cpu", "of the merging machine"}}, folder.path(), folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  EXPECT_EQ(file.ReadProvenance("cpu"), "fast; slow");
  EXPECT_EQ(file.ReadProvenance("compiler"), "gcc");
  EXPECT_EQ(file.ReadProvenance("cpu", {{0}, 0}), "fast");
  EXPECT_EQ(file.ReadProvenance("cpu", {{1}, 0}), "slow");
  EXPECT_EQ(file.ReadProvenance("cpu", {{2}, 0}), "") << "of a run that is missing";
  EXPECT_EQ(file.ReadProvenance("compiler", {{1}, 0}), "gcc");
}

TEST(Merge, AxesKeepTheirNames) {
  // Names that are in /accuracy, in /accuracy/reference or in no group of this file.
  const Plan plan = MakePlan(
      {TextAxis("load", {"calm", "a storm"}), NumberAxis("timestep", {1, 2}, "s"),
       NumberAxis("sample", {1, 2, 3}), NumberAxis("state", {7}), TextAxis("contact", {"bullet"})},
      1, {});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs)
    WriteRun(plan, run, FakeResult(run).result, {}, folder.path());
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  const results::ResultFile file(folder / "out.h5");
  EXPECT_EQ(file.axes(), plan.axes);
  for (const plan::Axis& axis : plan.axes) {
    EXPECT_TRUE(file.Has(axis.name)) << axis.name;
    EXPECT_TRUE(file.Has("run/" + axis.name)) << axis.name;
  }
  for (const plan::Run& run : plan.runs) ExpectCell(file, run, results::Status::kDone, 5);
}

TEST(Merge, TheAxisTimestepAndTheTimeStepOfARunAreInOneGroup) {
  const Plan plan = MakePlan({NumberAxis("timestep", {1, 2}, "s")}, 1, {.metrics = {"position"}});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs) {
    FakeResult fake(run);
    fake.result.errors.values["timestep"] = {static_cast<double>(1 + run.at[0])};
    WriteRun(plan, run, fake.result, {}, folder.path());
  }
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  const hdf5::File file = hdf5::File::Open(folder / "out.h5");
  EXPECT_EQ(file.OpenDataset("accuracy/timestep").shape(), hdf5::Shape{2});
  EXPECT_EQ(file.OpenDataset("accuracy/step_size").shape(), (hdf5::Shape{2, 1}));
  const results::ResultFile result(folder / "out.h5");
  for (const plan::Run& run : plan.runs)
    EXPECT_EQ(result.ReadReal("accuracy/timestep", CellOf(run)), 1 + run.at[0]);
}

TEST(Merge, RefusesAnAxisWithTheNameOfSomethingElse) {
  for (const char* name : {"status", "phase", "cycle", "energy", "run", "host", "contact_first"}) {
    const Plan plan = MakePlan({NumberAxis(name, {1, 2})}, 1, {});
    const TemporaryFolder folder;
    try {
      WriteRun(plan, plan.runs[0], FakeResult(plan.runs[0]).result, {}, folder.path());
      ADD_FAILURE() << name << " was written";
    } catch (const files::StoreError& error) {
      EXPECT_THAT(error.what(), HasSubstr("the axis '" + std::string(name) + "'"));
      EXPECT_THAT(error.what(), HasSubstr("another name in 'fixture.cdb'"));
    }
    EXPECT_TRUE(FilesIn(folder.path()).empty());
  }
  // An error is in the file only if the benchmark asks for it.
  const Plan without = MakePlan({NumberAxis("height", {1, 2})}, 1, {});
  const Plan with = MakePlan({NumberAxis("height", {1, 2})}, 1, {.metrics = {"height"}});
  const TemporaryFolder folder;
  journal::Merge(without, {}, folder.path(), folder / "out.h5");
  EXPECT_THROW(journal::Merge(with, {}, folder.path(), folder / "out.h5"), files::StoreError);
}

TEST(Merge, FactsThatDifferAreArraysOverTheRuns) {
  const Plan plan = MakePlan({NumberAxis("cpu", {10, 20, 30})}, 1, {});
  const TemporaryFolder folder;
  for (std::size_t i = 0; i < 2; ++i)
    WriteRun(plan, plan.runs[i], FakeResult(plan.runs[i]).result,
             {{"cpu", i == 0 ? "fast" : "slow"}}, folder.path());
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  const hdf5::File file = hdf5::File::Open(folder / "out.h5");
  EXPECT_THAT(file.OpenDataset("provenance/run").ReadText(),
              ElementsAre(plan.runs[0].id, plan.runs[1].id));
  EXPECT_THAT(file.OpenDataset("provenance/cpu").ReadText(), ElementsAre("fast", "slow"));
  EXPECT_THAT(file.OpenDataset("cpu").Read(), ElementsAre(10, 20, 30));
}

TEST(Merge, RefusesMoreAxesThanHdf5HasDimensions) {
  std::vector<plan::Axis> axes;
  for (int i = 0; i < 28; ++i) axes.push_back(NumberAxis("a" + std::to_string(i), {1}));
  const TemporaryFolder folder;
  journal::Merge(MakePlan(axes, 1, {.record = {"poses"}}), {}, folder.path(), folder / "out.h5");
  EXPECT_EQ(results::ResultFile(folder / "out.h5").axes().size(), 28u);
  axes.push_back(NumberAxis("b", {1}));
  EXPECT_THROW(journal::Merge(MakePlan(axes, 1, {}), {}, folder.path(), folder / "out29.h5"),
               files::StoreError);
}

}  // namespace
}  // namespace cdb::tests
