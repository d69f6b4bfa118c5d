// Reference runs: their records, and their part of the merged file.
#include <gtest/gtest.h>

#include <cmath>

#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

class References : public testing::Test {
 protected:
  /// Samples in which every number is different.
  std::vector<double> SamplesOf(const plan::Run& run) const {
    std::vector<double> samples(protocol::SampleShapeOf(run.scene)->Count());
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i] = static_cast<double>(i) + (run.scene.role == plan::Role::kTwin ? 0.5 : 0);
    return samples;
  }
  journal::Reference WriteOne(const plan::Run& run,
                              results::Status status = results::Status::kDone) {
    results::RunResult result;
    result.status = status;
    result.message = status == results::Status::kDone ? "" : "it fell over";
    result.state_hash = run.id;
    WriteReference(plan_, run, result, SamplesOf(run), TestProvenance(), folder_.path());
    return journal::ReadReference(run, *journal::Journals({folder_.path()}).Find(run.id));
  }
  void WriteRuns() {
    for (const plan::Run& run : plan_.runs)
      WriteRun(plan_, run, FakeResult(run).result, TestProvenance(), folder_.path());
  }

  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {10, 20})}, 1,
                                    {.cycles = 6, .metrics = {"height", "position"}});
};

TEST_F(References, AreReadAsTheyWereWritten) {
  ASSERT_EQ(plan_.references.size(), 4u);
  const plan::Run& run = plan_.references[0];
  const journal::Reference read = WriteOne(run);
  EXPECT_EQ(read.status, results::Status::kDone);
  EXPECT_EQ(read.shape, (protocol::SampleShape{4, 3}));
  EXPECT_EQ(read.values, SamplesOf(run));
  const auto record = journal::Journals({folder_.path()}).Find(run.id);
  EXPECT_EQ(journal::InfoOf(*record).outcome.status, results::Status::kDone);
  EXPECT_THROW(journal::ReadReference(plan_.references[1], *record), hdf5::Error);
  WriteRuns();
  EXPECT_THROW(journal::ReadReference(plan_.runs[0],
                                      *journal::Journals({folder_.path()}).Find(plan_.runs[0].id)),
               hdf5::Error);
}

TEST_F(References, ThatFailedHaveNoSamples) {
  const journal::Reference read = WriteOne(plan_.references[0], results::Status::kTimedOut);
  EXPECT_EQ(read.status, results::Status::kTimedOut);
  EXPECT_EQ(read.message, "it fell over");
  EXPECT_TRUE(read.values.empty());
}

TEST_F(References, StandInTheMergedFileBesideTheErrors) {
  WriteRuns();
  WriteOne(plan_.references[0]);
  WriteOne(plan_.references[1]);
  WriteOne(plan_.references[2], results::Status::kCrashed);  // the last one is missing
  journal::Merge(plan_, TestProvenance(), folder_.path(), folder_ / "out.h5");
  const results::ResultFile file(folder_ / "out.h5");
  for (std::size_t i = 0; i < 2; ++i) {
    const results::ResultFile::Cell cell{{i}, 0};
    const double n = static_cast<double>(i) * 10;
    EXPECT_EQ(file.ReadReal("accuracy/position", cell), n + 0.25);
    EXPECT_EQ(file.ReadReal("accuracy/height_w1_floor", cell), n + 0.125);
    EXPECT_TRUE(std::isnan(file.ReadReal("accuracy/horizon", cell)));
    EXPECT_TRUE(std::isnan(file.ReadReal("accuracy/timestep", cell)));
    EXPECT_EQ(file.ReadText("accuracy/truth", cell), plan_.runs[i].reference);
  }
  EXPECT_TRUE(file.Has("accuracy/reference/states"));
  EXPECT_FALSE(file.Has("accuracy/energy"));
}

TEST_F(References, AreNotThereWithoutErrors) {
  const plan::Plan plan = MakePlan({}, 1, {});
  WriteRun(plan, plan.runs[0], FakeResult(plan.runs[0]).result, TestProvenance(), folder_.path());
  journal::Merge(plan, TestProvenance(), folder_.path(), folder_ / "out.h5");
  const results::ResultFile file(folder_ / "out.h5");
  for (const char* name : {"accuracy", "accuracy/sample", "accuracy/reference"})
    EXPECT_FALSE(file.Has(name)) << name;
}

}  // namespace
}  // namespace cdb::tests
