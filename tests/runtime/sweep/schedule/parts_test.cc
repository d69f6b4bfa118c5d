// A plan that is executed in parts, and resumed.
#include "runtime/sweep/schedule/parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>

#include "compiler/yaml/short_plan.h"
#include "runtime/results/journal/journals.h"
#include "runtime/sweep/schedule/folder.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

/// Every run succeeds immediately; a stop is requested after `most`.
class PromptLauncher : public process::Launcher {
 public:
  explicit PromptLauncher(process::StopFlag& stop) : stop_(stop) {}

  std::vector<std::string> started;  // run ids
  std::size_t most = static_cast<std::size_t>(-1);

  void Start(std::size_t, const plan::Run& run, const std::string&) override {
    started.push_back(run.id);
    is_running_ = true;
  }
  std::optional<process::Ending> Wait(double) override {
    if (!is_running_) return std::nullopt;
    is_running_ = false;
    if (started.size() >= most) stop_.Request(15);
    process::Ending ending;
    ending.result.status = results::Status::kDone;
    ending.result.host = "here";
    return ending;
  }
  void StopAll() override { is_running_ = false; }

 private:
  process::StopFlag& stop_;
  bool is_running_ = false;
};

/// 24 runs, executed in parts of five at most.
class PartsTest : public testing::Test {
 protected:
  PartsTest() {
    auto whole = std::make_shared<plan::WholePlan>();
    whole->sha256 = std::string(64, 'e');
    whole->run_count = listed_.runs.size();
    whole->bounds = listed_.runs;
    yaml::ShortPlan form;
    form.benchmark = "large";
    form.sha256 = whole->sha256;
    whole->short_text = yaml::ToYaml(form);
    plan_ = listed_;
    plan_.runs.clear();
    plan_.whole = std::move(whole);
  }

  schedule::Summary Execute(std::size_t most = static_cast<std::size_t>(-1)) {
    process::StopFlag stop;
    PromptLauncher launcher(stop);
    launcher.most = most;
    options_.stop = &stop;
    listed_parts_.clear();
    const auto list = [&](std::uint64_t index, std::uint64_t count) {
      listed_parts_.push_back(index);
      plan::Plan part = plan_;
      for (std::size_t i = 0; i < listed_.runs.size(); ++i)
        if (i * count / listed_.runs.size() == index) part.runs.push_back(listed_.runs[i]);
      return part;
    };
    schedule::ProgressListener silent;
    const auto summary = schedule::ExecuteParts(plan_, list, options_, launcher, silent, 5);
    started_ = launcher.started;
    return summary;
  }

  std::map<std::string, std::int64_t> Runs() const { return RunsIn(options_.folder); }
  void Forget(const std::string& id) const {
    journal::Journal::OpenToWrite(options_.folder, plan_.Sha256()).Forget(id);
  }

  const TemporaryFolder root_;
  const plan::Plan listed_ = MakePlan({.quantities = {1, 2, 3, 4}, .repeats = 2});
  plan::Plan plan_;
  schedule::ExecuteOptions options_{.folder = root_.path() / "large.runs"};
  std::vector<std::uint64_t> listed_parts_;
  std::vector<std::string> started_;
};

TEST_F(PartsTest, EveryRunIsExecutedOnce) {
  const schedule::Summary summary = Execute();
  EXPECT_EQ(summary.done, 24u);
  EXPECT_EQ(summary.left, 0u);
  EXPECT_EQ(std::set(started_.begin(), started_.end()).size(), 24u);
  EXPECT_EQ(started_.size(), 24u);
  EXPECT_EQ(listed_parts_, (std::vector<std::uint64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(Runs().size(), 24u);
}

TEST_F(PartsTest, PartsThatHaveEndedAreNotListedAgain) {
  const schedule::Summary stopped = Execute(12);
  EXPECT_EQ(stopped.signal, 15);
  EXPECT_EQ(stopped.done, 12u);
  const auto kept = Runs();
  const schedule::Summary summary = Execute();
  EXPECT_EQ(summary.done, 24u);
  EXPECT_EQ(summary.resumed, 12u);
  EXPECT_EQ(started_.size(), 12u);
  EXPECT_EQ(listed_parts_, (std::vector<std::uint64_t>{2, 3, 4}));
  for (const auto& [id, written] : kept) EXPECT_EQ(Runs().at(id), written);
  EXPECT_EQ(Execute().resumed, 24u);
  EXPECT_TRUE(listed_parts_.empty());
}

/// As `cdb run --until` does for repeats that are not needed yet.
TEST_F(PartsTest, PartsWithRunsElsewhereAreNotTakenForDone) {
  options_.find_elsewhere = [](const plan::Run& run) {
    return run.rep > 0 ? std::optional(journal::RunInfo{}) : std::nullopt;
  };
  EXPECT_EQ(Execute().done, 12u);
  options_.find_elsewhere = nullptr;
  const schedule::Summary summary = Execute();
  EXPECT_EQ(summary.done, 24u);
  EXPECT_EQ(summary.resumed, 12u);
  EXPECT_EQ(Runs().size(), 24u);
}

TEST_F(PartsTest, ARunThatIsGoneIsRunAgainThoughItsPartWasMarked) {
  Execute();
  const std::string gone = Runs().begin()->first;
  Forget(gone);
  const schedule::Summary summary = Execute();
  EXPECT_EQ(summary.done, 24u);
  EXPECT_EQ(started_, std::vector{gone});
}

TEST_F(PartsTest, ShardsWithoutAllTheirMarksAreKnown) {
  const auto unmarked = [&] { return schedule::FindUnmarkedShards(plan_, options_.folder, 3, 5); };
  EXPECT_EQ(unmarked(), (std::vector<std::uint64_t>{1, 2, 3}));
  options_.shard = {2, 3};
  Execute();
  EXPECT_EQ(unmarked(), (std::vector<std::uint64_t>{1, 3}));
  options_.shard = {3, 3};
  Execute(2);  // stopped
  EXPECT_EQ(unmarked(), (std::vector<std::uint64_t>{1, 3}));
  Forget(Runs().begin()->first);
  EXPECT_EQ(unmarked(), (std::vector<std::uint64_t>{1, 2, 3})) << "fewer runs than marked";
}

TEST_F(PartsTest, AMarkThatIsCutShortIsNone) {
  Execute();
  for (const auto& [what, value] : journal::FindRequests(options_.folder))
    journal::Ask(options_.folder, plan_.Sha256(), what, value.substr(0, 66));
  EXPECT_EQ(Execute().resumed, 24u);
  EXPECT_TRUE(started_.empty());
  EXPECT_EQ(listed_parts_.size(), 5u);
}

TEST_F(PartsTest, ShardsOfAShardAreItsParts) {
  options_.shard = {2, 3};
  EXPECT_EQ(Execute().done, 8u);
  EXPECT_EQ(listed_parts_, (std::vector<std::uint64_t>{2, 3}));
  options_.shard = {};
  const schedule::Summary rest = Execute();
  EXPECT_EQ(rest.done, 24u);
  EXPECT_EQ(started_.size(), 16u);
  options_.shard = {4, 3};
  EXPECT_THROW(Execute(), process::ScheduleError);
}

TEST_F(PartsTest, FreshForgetsRunsAndMarks) {
  Execute();
  options_.start = schedule::SweepStart::kFresh;
  EXPECT_EQ(Execute().resumed, 0u);
  EXPECT_EQ(started_.size(), 24u);
}

TEST_F(PartsTest, AnotherPlanIsRefusedThoughPartsAreMarked) {
  Execute();
  auto other = std::make_shared<plan::WholePlan>(*plan_.whole);
  other->sha256 = std::string(64, 'f');
  plan_.whole = std::move(other);
  try {
    Execute();
    FAIL() << "was mixed";
  } catch (const process::ScheduleError& error) {
    EXPECT_NE(std::string(error.what()).find("runs.journal is of another plan"), std::string::npos)
        << error.what();
  }
  fs::remove(options_.folder / "plan.yaml");
  EXPECT_THROW(Execute(), process::ScheduleError) << "runs without a plan.yaml";
  EXPECT_EQ(Runs().size(), 24u);
}

TEST_F(PartsTest, ThePlanIsRemovedWithItsRuns) {
  Execute();
  WriteFile(options_.folder / "notes.txt", "mine");
  schedule::RemoveSweep(options_.folder, std::string(64, '0'));
  EXPECT_EQ(Runs().size(), 24u) << "of another plan";
  schedule::RemoveSweep(options_.folder, plan_.Sha256());
  EXPECT_EQ(FilesIn(options_.folder), std::vector<std::string>{"notes.txt"});
}

}  // namespace
}  // namespace cdb::tests
