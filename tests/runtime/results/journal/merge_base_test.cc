// Runs replaced in a results file: the new ones come from journals, all others are unchanged to the
// bit.
#include "runtime/results/journal/merge_base.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <string>
#include <vector>

#include "compiler/analysis/reference.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

/// Every dataset with its values, as text, without those that contain the time of creation.
std::string ValuesIn(const hdf5::Group& group, const std::string& path = "") {
  std::string all;
  for (const std::string& name : group.MemberNames()) {
    if (path.empty() && (name == "run" || name == "accuracy" || name == "provenance")) {
      all += ValuesIn(group.OpenGroup(name), name + "/");
      continue;
    }
    if (path == "accuracy/" && name == "reference") {
      all += ValuesIn(group.OpenGroup(name), path + name + "/");
      continue;
    }
    const hdf5::Dataset dataset = group.OpenDataset(name);
    all += path + name + ":";
    if (dataset.type() == hdf5::Type::kText) {
      for (const std::string& text : dataset.ReadText()) all += " " + text;
    } else {
      for (const double value : dataset.Read())
        all += " " + std::to_string(std::bit_cast<std::uint64_t>(value));
    }
    all += "\n";
  }
  for (const auto& [name, text] : path == "provenance/" ? group.Texts() : results::Provenance())
    all += path + name + "= " + text + "\n";
  return all;
}

class MergeBaseTest : public testing::Test {
 protected:
  void Write(const plan::Run& run, results::Status status, std::uint64_t n_cycles,
             const fs::path& folder, const results::Provenance& provenance) const {
    tests::WriteRun(plan_, run, FakeResult(run, status, n_cycles).result, provenance, folder);
  }
  void WriteAllReferences(const fs::path& folder) const {
    for (const plan::Run& run : plan_.references) {
      results::RunResult result;
      result.status = results::Status::kDone;
      result.state_hash = run.id;
      const std::vector<double> samples(protocol::SampleShapeOf(run.scene)->Count(), 0.1);
      WriteReference(plan_, run, result, samples, TestProvenance(), folder);
    }
  }

  const plan::Plan plan_ =
      MakePlan({NumberAxis("quantity", {10, 20, 30}), TextAxis("detector", {"sap", "dbvt"})}, 2,
               {.cycles = 6,
                .record = {"timing", "poses", "boxes", "contacts", "counts"},
                .metrics = {"height", "position"}},
               {{1, 1}});
  const TemporaryFolder folder_, runs_, retried_;
};

TEST_F(MergeBaseTest, ReplacesARunAndLeavesTheRestToTheLastBit) {
  const results::Provenance elsewhere = {{"cpu", "another processor"}, {"compiler", "one"}};
  const plan::Run& crashed = plan_.runs[3];
  for (const plan::Run& run : plan_.runs)
    Write(run, results::Status::kDone, 6, runs_.path(),
          &run == &plan_.runs[5] ? elsewhere : TestProvenance());
  WriteAllReferences(runs_.path());
  Write(crashed, results::Status::kCrashed, 2, runs_.path(), TestProvenance());
  const fs::path out = folder_ / "out.h5";
  journal::Merge(plan_, TestProvenance(), runs_.path(), out);
  EXPECT_EQ(results::ResultFile(out).ReadStatus({crashed.at, crashed.rep}),
            results::Status::kCrashed);

  // As it would be if the run had succeeded at first.
  for (const fs::path& folder : {runs_.path(), retried_.path()})
    Write(crashed, results::Status::kDone, 6, folder, TestProvenance());
  journal::Merge(plan_, TestProvenance(), runs_.path(), folder_ / "wanted.h5");
  journal::Merge(plan_, TestProvenance(), {retried_.path()}, out, out);
  EXPECT_EQ(results::ResultFile(out).ReadStatus({crashed.at, crashed.rep}), results::Status::kDone);
  EXPECT_TRUE(ValuesIn(hdf5::File::Open(out)) == ValuesIn(hdf5::File::Open(folder_ / "wanted.h5")))
      << ValuesIn(hdf5::File::Open(out)) << "\n----\n"
      << ValuesIn(hdf5::File::Open(folder_ / "wanted.h5"));
  EXPECT_EQ(FilesIn(folder_.path()), (std::vector<std::string>{"out.h5", "wanted.h5"}));
}

/// `plan_` with more points, repeats, cycles and objects.
plan::Plan Edited() {
  plan::Plan plan =
      MakePlan({NumberAxis("quantity", {10, 20, 30, 40}), TextAxis("detector", {"sap", "dbvt"})}, 3,
               {.cycles = 6,
                .record = {"timing", "poses", "boxes", "contacts", "counts"},
                .metrics = {"height", "position"}});
  for (plan::Run& run : plan.runs)
    if (run.at[0] == 3)
      Resize(run, {.cycles = 11,
                   .objects = 5,
                   .record = {"timing", "poses", "boxes", "contacts", "counts", "energy"},
                   .metrics = {"height", "position"}});
  plan.references.clear();
  analysis::AddReferences(plan);
  return plan;
}

TEST_F(MergeBaseTest, CopiesTheRunsOfAnotherPlanToTheLastBit) {
  const plan::Plan edited = Edited();
  const results::Provenance elsewhere = {{"cpu", "another processor"}, {"models", "a b"}};
  const fs::path old = folder_ / "old.h5", copied = folder_ / "copied", ran = folder_ / "ran";
  for (const fs::path& folder : {copied, ran}) fs::create_directory(folder);
  std::map<std::string, std::size_t> cells;
  for (const plan::Run& run : plan_.runs) {
    const bool is_odd = &run == &plan_.runs[5];
    Write(run, is_odd ? results::Status::kCrashed : results::Status::kDone, is_odd ? 2 : 6,
          runs_.path(), is_odd ? elsewhere : TestProvenance());
    cells[run.id] = run.at[0] * 4 + run.at[1] * 2 + run.rep;
  }
  journal::Merge(plan_, TestProvenance(), runs_.path(), old);

  journal::RunWriter writer(edited, TestProvenance());
  const journal::MergeBase base(old, writer.facts(), journal::MergeBase::Of::kAnyPlan);
  std::vector<journal::Record> records;
  for (const plan::Run& run : edited.runs) {
    const auto cell = cells.find(run.id);
    const bool is_odd = run.id == plan_.runs[5].id;
    const FakeResult made(run, is_odd ? results::Status::kCrashed : results::Status::kDone,
                          is_odd ? 2 : run.scene.world.Count("cycles"));
    tests::WriteRun(edited, run, made.result, is_odd ? elsewhere : TestProvenance(), ran);
    if (cell != cells.end())
      records.push_back(writer.Copy(run, base, cell->second, run.id));
    else
      tests::WriteRun(edited, run, made.result, TestProvenance(), copied);
  }
  EXPECT_EQ(records.size(), plan_.runs.size());
  journal::Journal::OpenToWrite(copied, edited.Sha256()).Write(records);
  journal::Merge(edited, TestProvenance(), copied, folder_ / "copied.h5");
  journal::Merge(edited, TestProvenance(), ran, folder_ / "ran.h5");
  EXPECT_EQ(ValuesIn(hdf5::File::Open(folder_ / "copied.h5")),
            ValuesIn(hdf5::File::Open(folder_ / "ran.h5")));
}

TEST_F(MergeBaseTest, RefusesTheFileOfAnotherPlan) {
  const plan::Plan other = MakePlan({}, 1, {});
  WriteRun(other, other.runs[0], FakeResult(other.runs[0]).result, {}, runs_.path());
  journal::Merge(other, {}, runs_.path(), folder_ / "other.h5");
  const std::string before = ReadFile(folder_ / "other.h5");
  EXPECT_THROW(
      journal::Merge(plan_, {}, {retried_.path()}, folder_ / "other.h5", folder_ / "other.h5"),
      files::StoreError);
  EXPECT_TRUE(ReadFile(folder_ / "other.h5") == before);
}

}  // namespace
}  // namespace cdb::tests
