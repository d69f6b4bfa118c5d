#include "runtime/sweep/schedule/schedule.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <functional>
#include <set>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/results/journal/journals.h"
#include "tests/runtime/results/journal/change_facts.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

/// Ends each run immediately, the last one started first, as `behave` determines.
class FakeLauncher : public process::Launcher {
 public:
  std::function<results::Status(const plan::Run&)> behave = [](const auto&) {
    return results::Status::kDone;
  };
  std::function<void()> before_wait = [] {};
  std::function<process::Pulse(std::size_t)> pulse;
  /// True if the run itself needs the walls; other runs may omit them.
  std::function<bool(const plan::Run&)> needs_walls = [](const auto&) { return true; };
  /// The noise of an attempt of a run, counted from 1.
  std::function<machine::NoiseJudgement(const plan::Run&, int attempt)> noise = [](const auto&,
                                                                                   int) {
    return machine::NoiseJudgement{machine::Noise::kQuiet, "", 0};
  };
  std::vector<std::string> started;  // run ids, in order
  std::size_t most_at_once = 0;
  int stops = 0;

  struct Started {
    std::size_t slot;
    const plan::Run* run;
    std::string kept;
  };
  std::vector<Started> running;

  void Start(std::size_t slot, const plan::Run& run, const std::string& kept) override {
    for (const Started& other : running) EXPECT_NE(other.slot, slot);
    started.push_back(run.id);
    running.push_back({slot, &run, kept});
    most_at_once = std::max(most_at_once, running.size());
  }
  std::optional<process::Ending> Wait(double) override {
    before_wait();
    if (running.empty()) return std::nullopt;
    const auto [slot, run, kept] = running.back();
    process::Ending ending;
    ending.slot = slot;
    ending.result.status = behave(*run);
    if (ending.result.status == results::Status::kMissing) return std::nullopt;
    running.pop_back();
    ending.result.host = "here";
    const auto attempt = std::ranges::count(started, run->id);
    ending.result.noise = noise(*run, static_cast<int>(attempt));
    ending.result.scalars.place_ns = static_cast<double>(attempt);
    const bool keeps = kept == "walls" || needs_walls(*run);
    ending.result.omitted = keeps ? "" : "walls";
    ending.result.decisions = keeps ? "walls: kept: reached" : "walls: left out: far away";
    return ending;
  }
  process::Pulse PulseOf(std::size_t slot) const override {
    return pulse ? pulse(slot) : process::Pulse{};
  }
  void StopAll() override {
    ++stops;
    running.clear();
  }
};

struct Ears : schedule::ProgressListener {
  std::vector<std::string> repeated;  // run ids
  std::vector<std::string> warnings, settling;
  std::size_t to_do = 0, began = 0, ended = 0, found = 0, ticks = 0, ends = 0;
  void Begin(const plan::Plan&, const std::vector<const plan::Run*>& runs, const schedule::Summary&,
             std::size_t) override {
    to_do = runs.size();
  }
  void Repeat(const plan::Plan&, const std::vector<const plan::Run*>& runs,
              const std::string& components) override {
    EXPECT_EQ(components, "walls");
    for (const plan::Run* run : runs) repeated.push_back(run->id);
  }
  void RunStarted(const plan::Run&) override { ++began; }
  void RunSettles(const plan::Run&, const std::string& how_far) override {
    settling.push_back(how_far);
  }
  void RunEnded(const plan::Run&, const results::RunResult&, double) override { ++ended; }
  void RunFound(const plan::Run&, const results::Outcome&) override { ++found; }
  void Warn(const std::string& text) override { warnings.push_back(text); }
  void Tick() override { ++ticks; }
  void End() override { ++ends; }
};

std::vector<std::string> IdsOf(const plan::Plan& plan) {
  std::set<std::string> ids;
  for (const plan::Run& run : plan.runs) ids.insert(run.id);
  return {ids.begin(), ids.end()};
}

std::vector<std::string> IdsIn(const fs::path& folder) {
  std::vector<std::string> ids;
  for (const auto& [id, written] : RunsIn(folder)) ids.push_back(id);
  return ids;
}

/// What a journal in the folder has of a run.
journal::RunInfo InfoIn(const fs::path& folder, const std::string& id) {
  return journal::InfoOf(journal::Journals({folder}).Find(id).value());
}

/// As after a driver that has not finished these runs.
void Forget(const plan::Plan& plan, const fs::path& folder, const std::string& id) {
  journal::Journal::OpenToWrite(folder, plan.Sha256()).Forget(id);
}

/// All bytes of the journal, with its log written back.
std::string JournalIn(const fs::path& folder) { return ReadFile(folder / "runs.journal"); }

class ScheduleTest : public testing::Test {
 protected:
  schedule::Summary Run(const plan::Plan& to_run) {
    return schedule::Execute(to_run, options, launcher, ears);
  }

  TemporaryFolder root;
  schedule::ExecuteOptions options{.folder = root.path() / "study.runs"};
  FakeLauncher launcher;
  Ears ears;
  plan::Plan plan = MakePlan();
};

TEST_F(ScheduleTest, CarriesOutEveryRunInOrder) {
  const schedule::Summary summary = Run(plan);
  EXPECT_EQ(summary, (schedule::Summary{.done = 9}));
  EXPECT_FALSE(summary.HasBadRuns());
  std::vector<std::string> order;
  for (const plan::Run* run : schedule::OrderRuns(plan)) order.push_back(run->id);
  EXPECT_EQ(launcher.started, order);
  EXPECT_EQ(launcher.most_at_once, 1u);
  EXPECT_EQ(FilesIn(options.folder), (std::vector<std::string>{"plan.yaml", "runs.journal"}));
  EXPECT_TRUE(ReadFile(options.folder / "plan.yaml") == yaml::ToYaml(plan));
  EXPECT_EQ(IdsIn(options.folder), IdsOf(plan));
  for (const std::string& id : IdsOf(plan))
    EXPECT_EQ(InfoIn(options.folder, id).outcome.status, results::Status::kDone);
  EXPECT_EQ(ears.to_do, 9u);
  EXPECT_EQ(ears.began, 9u);
  EXPECT_EQ(ears.ended, 9u);
  EXPECT_EQ(ears.ends, 1u);
}

std::string OmittedIn(const fs::path& folder, const plan::Run& run) {
  return InfoIn(folder, run.id).omitted;
}

TEST_F(ScheduleTest, ComparedRunsLeaveOutTheSameParts) {
  // The last run of two objects needs its walls; those of one and of three objects need none.
  const auto is_compared = [](const plan::Run& run) { return run.scene.ObjectCount() == 2; };
  const plan::Run* needy = nullptr;
  for (const plan::Run* run : schedule::OrderRuns(plan))
    if (is_compared(*run)) needy = run;
  launcher.needs_walls = [&](const plan::Run& run) { return run.id == needy->id; };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
  EXPECT_EQ(ears.repeated.size(), 2u);
  EXPECT_EQ(launcher.started.size(), 11u);
  for (const plan::Run& run : plan.runs)
    EXPECT_EQ(OmittedIn(options.folder, run), is_compared(run) ? "" : "walls");
  // All results exist: nothing is left to do.
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9, .resumed = 9}));
  EXPECT_EQ(launcher.started.size(), 11u);
}

TEST_F(ScheduleTest, RunsAfterOneThatNeedsAPartKeepItAtOnce) {
  const std::string first = schedule::OrderRuns(plan)[0]->id;
  launcher.needs_walls = [&](const plan::Run& run) { return run.id == first; };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
  EXPECT_TRUE(ears.repeated.empty());
  EXPECT_EQ(launcher.started.size(), 9u);
}

TEST_F(ScheduleTest, ARepeatThatEndsBadlyLosesNothing) {
  const auto order = schedule::OrderRuns(plan);
  launcher.needs_walls = [&](const plan::Run& run) { return run.id == order.back()->id; };
  launcher.behave = [&](const plan::Run&) {
    return launcher.started.size() > 9 ? results::Status::kCrashed : results::Status::kDone;
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
  EXPECT_EQ(ears.repeated.size(), 2u);
  EXPECT_EQ(ears.warnings.size(), 2u);
  for (const std::string& id : ears.repeated)
    EXPECT_EQ(InfoIn(options.folder, id).outcome.status, results::Status::kDone);
}

TEST_F(ScheduleTest, HasAsManyAtOnceAsJobs) {
  options.jobs = 4;
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
  EXPECT_EQ(launcher.most_at_once, 4u);
  EXPECT_EQ(IdsIn(options.folder), IdsOf(plan));
}

TEST_F(ScheduleTest, CountsHowRunsEnded) {
  launcher.behave = [this](const plan::Run& run) {
    constexpr results::Status kKinds[] = {results::Status::kDone, results::Status::kFailed,
                                          results::Status::kCrashed, results::Status::kTimedOut};
    return kKinds[(&run - plan.runs.data()) % 4];
  };
  const schedule::Summary summary = Run(plan);
  EXPECT_EQ(summary, (schedule::Summary{.done = 3, .failed = 2, .crashed = 2, .timed_out = 2}));
  EXPECT_TRUE(summary.HasBadRuns());
  EXPECT_EQ(schedule::Describe(summary), "9 runs: 3 done, 2 failed, 2 crashed, 2 timed out");
  // A failed run has finished and is not run again.
  launcher.started.clear();
  const schedule::Summary again = Run(plan);
  EXPECT_TRUE(launcher.started.empty());
  EXPECT_EQ(again, (schedule::Summary{
                       .done = 3, .failed = 2, .crashed = 2, .timed_out = 2, .resumed = 9}));
}

TEST_F(ScheduleTest, WarnsOnceOfAPluginThatHangs) {
  for (plan::Run& run : plan.runs)
    run.scene.plugins = {{"mine", "broad", 0, "mine.so", std::string(64, '0')}};
  int waits = 0;
  launcher.pulse = [&](std::size_t) {
    return process::Pulse{waits < 30 ? static_cast<std::uint64_t>(waits) : 30,
                          "FindPairs of `mine`"};
  };
  // The first run goes on for 30 ticks and hangs for 100.
  launcher.behave = [&](const auto&) {
    return ++waits < 130 ? results::Status::kMissing : results::Status::kDone;
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
  ASSERT_EQ(ears.warnings.size(), 1u);
  EXPECT_NE(ears.warnings[0].find("the run is in FindPairs of `mine`"), std::string::npos)
      << ears.warnings[0];
}

TEST_F(ScheduleTest, TellsHowFarPilesHaveSettledWhenThatChanges) {
  for (plan::Run& run : plan.runs) {
    run.scene.groups[0].settings.Set("location", schema::Call{"pile", {schema::Word{"fit"}}});
    run.id = plan::RunId(run.scene, run.rep);
  }
  int waits = 0;
  launcher.pulse = [&](std::size_t) {
    return process::Pulse{0, "", waits < 4 ? "1 of 3" : waits < 8 ? "2 of 3" : ""};
  };
  launcher.behave = [&](const auto&) {
    return ++waits < 12 ? results::Status::kMissing : results::Status::kDone;
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
  EXPECT_EQ(ears.settling, (std::vector<std::string>{"1 of 3", "2 of 3", ""}));
}

TEST_F(ScheduleTest, DescribesASummary) {
  EXPECT_EQ(schedule::Describe({.done = 1}), "1 run: 1 done");
  EXPECT_EQ(schedule::Describe({.done = 3, .resumed = 2, .left = 4}),
            "7 runs: 3 done, 4 not run (2 of them before)");
}

TEST_F(ScheduleTest, GoesOnWhereItStopped) {
  Run(plan);
  const auto ids = IdsOf(plan);
  for (const std::size_t i : {1, 4, 8}) Forget(plan, options.folder, ids[i]);
  const auto kept = RunsIn(options.folder);
  launcher.started.clear();
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9, .resumed = 6}));
  EXPECT_EQ(launcher.started.size(), 3u);
  for (const std::string& id : launcher.started)
    EXPECT_TRUE(id == ids[1] || id == ids[4] || id == ids[8]);
  for (const auto& [id, written] : kept) EXPECT_EQ(RunsIn(options.folder).at(id), written);
  EXPECT_EQ(ears.to_do, 3u);
}

TEST_F(ScheduleTest, FreshStartsOver) {
  Run(plan);
  WriteFile(options.folder / "notes.txt", "mine");
  WriteFile(options.folder / "mine.h5", "mine too");
  WriteFile(options.folder / "00112233aabbccdd.h5", "of an earlier version");
  WriteFile(options.folder / "00112233aabbccdd.h5.broken", "");
  WriteFile(options.folder / "node7.journal", "damaged");
  WriteFile(options.folder / "runs.journal.broken", "damaged");
  for (const auto start : {schedule::SweepStart::kFresh, schedule::SweepStart::kFreshForResult}) {
    launcher.started.clear();
    options.start = start;
    EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
    EXPECT_EQ(launcher.started.size(), 9u);
    EXPECT_EQ(journal::FindRequest(options.folder, journal::kFresh),
              start == schedule::SweepStart::kFresh ? "" : plan.Sha256());
    EXPECT_EQ(FilesIn(options.folder),
              (std::vector<std::string>{"mine.h5", "notes.txt", "plan.yaml", "runs.journal"}))
        << "what is not ours stays";
  }
}

TEST_F(ScheduleTest, RefusesShardsOfEarlierVersionsByName) {
  fs::create_directories(options.folder);
  WriteFile(options.folder / "00112233aabbccdd.h5", "a shard");
  try {
    Run(plan);
    ADD_FAILURE();
  } catch (const process::ScheduleError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("00112233aabbccdd.h5"), std::string::npos) << message;
    EXPECT_NE(message.find("--fresh"), std::string::npos) << message;
  }
  EXPECT_EQ(FilesIn(options.folder), std::vector<std::string>{"00112233aabbccdd.h5"});
}

TEST_F(ScheduleTest, RefusesAJournalOfAnotherPlanAndChangesNothing) {
  Run(plan);
  const std::string text = ReadFile(options.folder / "plan.yaml");
  // Other runs; then the same runs under another plan, which is recognised only by its hash.
  plan::Plan renamed = plan;
  renamed.benchmark = "other";
  for (const plan::Plan& other : {MakePlan({.quantities = {9}}), renamed}) {
    launcher.started.clear();
    try {
      Run(other);
      ADD_FAILURE() << "mixed in";
    } catch (const process::ScheduleError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("runs.journal is of another plan"), std::string::npos) << message;
      EXPECT_NE(message.find("--fresh"), std::string::npos) << message;
    }
    EXPECT_TRUE(launcher.started.empty());
    EXPECT_TRUE(ReadFile(options.folder / "plan.yaml") == text);
    EXPECT_EQ(IdsIn(options.folder), IdsOf(plan));
  }
}

TEST_F(ScheduleTest, ANewTitleIsNotANewPlan) {
  Run(plan);
  plan.title = "a better title";
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9, .resumed = 9}));
  EXPECT_TRUE(ReadFile(options.folder / "plan.yaml") == yaml::ToYaml(plan));
}

TEST_F(ScheduleTest, RunsADamagedRunAgain) {
  Run(plan);
  const std::string id = IdsOf(plan)[3];
  ChangeFacts(options.folder / "runs.journal", id);
  launcher.started.clear();
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9, .resumed = 8}));
  EXPECT_EQ(launcher.started, std::vector<std::string>{id});
  ASSERT_EQ(ears.warnings.size(), 1u);
  EXPECT_NE(ears.warnings[0].find(id + " is damaged"), std::string::npos) << ears.warnings[0];
  EXPECT_EQ(InfoIn(options.folder, id).outcome.status, results::Status::kDone);
}

TEST_F(ScheduleTest, SetsABrokenJournalAsideAndKeepsWhatCanBeRead) {
  Run(plan);
  const std::string whole = JournalIn(options.folder);
  // Nothing, everything, and a page in the middle.
  std::string hole = whole;
  std::fill_n(hole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 4096 / 2 * 4096), 4096,
              '\0');
  for (const std::string& damaged : {std::string("no journal"), whole.substr(0, 4096), hole}) {
    SCOPED_TRACE(damaged.size());
    for (const char* name : {"runs.journal-wal", "runs.journal-shm", "runs.journal.broken"})
      fs::remove(options.folder / name);
    WriteFile(options.folder / "runs.journal", damaged);
    launcher.started.clear();
    ears.warnings.clear();
    const schedule::Summary summary = Run(plan);
    EXPECT_EQ(summary.done, 9u);
    EXPECT_EQ(launcher.started.size() + summary.resumed, 9u);
    EXPECT_GE(launcher.started.size(), 1u);
    EXPECT_EQ(IdsIn(options.folder), IdsOf(plan));
    ASSERT_FALSE(ears.warnings.empty());
    EXPECT_NE(ears.warnings[0].find("runs.journal"), std::string::npos) << ears.warnings[0];
  }
}

TEST_F(ScheduleTest, TakesWhatAnotherDriverFinishedMeanwhile) {
  const auto order = schedule::OrderRuns(plan);
  int waits = 0;
  launcher.before_wait = [&] {
    if (++waits != 2) return;
    results::RunResult result;
    result.status = results::Status::kCrashed;
    WriteRun(plan, *order[3], result, {}, options.folder);
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 8, .crashed = 1, .resumed = 1}));
  EXPECT_EQ(launcher.started.size(), 8u);
  EXPECT_EQ(ears.found, 1u);
}

TEST_F(ScheduleTest, AShardOfThePlanIsCarriedOutAlone) {
  std::size_t runs = 0;
  for (std::uint64_t index = 1; index <= 2; ++index) {
    options.shard = {index, 2};
    runs += Run(plan).done;
  }
  EXPECT_EQ(runs, 9u);
  EXPECT_EQ(launcher.started.size(), 9u);
  EXPECT_EQ(IdsIn(options.folder), IdsOf(plan));
}

TEST_F(ScheduleTest, AStopKeepsWhatIsFinished) {
  process::StopFlag stop;
  options.stop = &stop;
  options.jobs = 2;
  launcher.behave = [&](const plan::Run&) {
    if (ears.ended == 3) stop.Request(15);
    return ears.ended == 4 ? results::Status::kMissing
                           : results::Status::kDone;  // the last never ends
  };
  const schedule::Summary summary = Run(plan);
  EXPECT_EQ(summary, (schedule::Summary{.done = 4, .left = 5, .signal = 15}));
  EXPECT_EQ(IdsIn(options.folder).size(), 4u);
  EXPECT_TRUE(launcher.running.empty()) << "ended by the schedule";
  EXPECT_EQ(ears.ends, 1u);
  process::StopFlag none;
  options.stop = &none;
  launcher.behave = [](const auto&) { return results::Status::kDone; };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9, .resumed = 4}));
}

TEST_F(ScheduleTest, AStopBeforeTheFirstRunRunsNothing) {
  process::StopFlag stop;
  stop.Request(2);
  stop.Request(15);
  options.stop = &stop;
  EXPECT_EQ(Run(plan), (schedule::Summary{.left = 9, .signal = 2}));
  EXPECT_TRUE(launcher.started.empty());
}

TEST_F(ScheduleTest, ListenersTickWhileNothingEnds) {
  int waits = 0;
  launcher.behave = [&](const plan::Run&) {
    return ++waits % 3 != 0 ? results::Status::kMissing : results::Status::kDone;
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9}));
  EXPECT_EQ(ears.ticks, 18u);
}

TEST_F(ScheduleTest, AStoreThatRefusesEndsTheWork) {
  launcher.before_wait = [&] {
    if (ears.ended != 4) return;
    // The driver's own log cannot grow any more; it holds four runs.
    const rlimit limit = {fs::file_size(options.folder / "runs.journal-wal"), RLIM_INFINITY};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  try {
    Run(plan);
    ADD_FAILURE() << "went on";
  } catch (const files::StoreError& error) {
    EXPECT_NE(std::string(error.what()).find("4 of 9 runs are safe in"), std::string::npos)
        << error.what();
  }
  const rlimit none = {RLIM_INFINITY, RLIM_INFINITY};
  setrlimit(RLIMIT_FSIZE, &none);
  EXPECT_EQ(launcher.stops, 1);
  EXPECT_EQ(ears.ends, 1u);
  EXPECT_EQ(IdsIn(options.folder).size(), 4u);
}

TEST_F(ScheduleTest, RunsAgainWhatIsAskedForAndNothingElse) {
  const std::string crashed = plan.runs[4].id;
  launcher.behave = [&](const plan::Run& run) {
    return run.id == crashed ? results::Status::kCrashed : results::Status::kDone;
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 8, .crashed = 1}));
  const auto before = RunsIn(options.folder);
  launcher.behave = [](const plan::Run&) { return results::Status::kDone; };
  launcher.started.clear();
  options.is_repeated = [](const journal::RunInfo& run) {
    return run.outcome.status == results::Status::kCrashed;
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 9, .resumed = 8}));
  EXPECT_EQ(launcher.started, std::vector<std::string>{crashed});
  for (const auto& [id, written] : RunsIn(options.folder))
    EXPECT_EQ(written == before.at(id), id != crashed);
}

TEST_F(ScheduleTest, LeavesRunsAloneThatAreKeptElsewhere) {
  const std::string wanted = plan.runs[4].id;
  options.find_elsewhere = [&](const plan::Run& run) -> std::optional<journal::RunInfo> {
    if (run.id == wanted) return std::nullopt;
    return journal::RunInfo{run.id, {results::Status::kDone}, "", ""};
  };
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 1}));
  EXPECT_EQ(launcher.started, std::vector<std::string>{wanted});
  EXPECT_EQ(IdsIn(options.folder), std::vector<std::string>{wanted});
}

TEST_F(ScheduleTest, NoticesThatItsJournalIsGone) {
  bool keeps_folder = false;
  launcher.before_wait = [&] {
    if (ears.ended != 4) return;
    fs::remove_all(options.folder);
    if (keeps_folder) fs::create_directories(options.folder);
  };
  for (const bool keeps : {false, true}) {
    keeps_folder = keeps;
    ears = {};
    try {
      Run(plan);
      ADD_FAILURE();
    } catch (const files::StoreError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("was removed while the runs went"), std::string::npos) << message;
      EXPECT_NE(message.find("0 of 9 runs are safe in"), std::string::npos) << message;
    }
  }
}

TEST_F(ScheduleTest, ALauncherThatRefusesEndsTheWork) {
  struct Refuser : FakeLauncher {
    void Start(std::size_t slot, const plan::Run& run, const std::string& kept) override {
      if (started.size() == 3)
        throw process::ScheduleError("cannot start a run: no more processes");
      FakeLauncher::Start(slot, run, kept);
    }
  } refuser;
  EXPECT_THROW(schedule::Execute(plan, options, refuser, ears), process::ScheduleError);
  EXPECT_EQ(IdsIn(options.folder).size(), 3u);
  EXPECT_EQ(ears.ends, 1u);
}

TEST_F(ScheduleTest, AFolderThatCannotBeIsNamed) {
  WriteFile(root.path() / "file", "");
  options.folder = root.path() / "file" / "study.runs";
  try {
    Run(plan);
    ADD_FAILURE();
  } catch (const files::StoreError& error) {
    EXPECT_NE(std::string(error.what()).find(options.folder.string()), std::string::npos);
  }
}

TEST_F(ScheduleTest, AnEmptyPlanIsDone) {
  plan.runs.clear();
  EXPECT_EQ(Run(plan), schedule::Summary{});
}

double NumberIn(const fs::path& folder, const std::string& id, const std::string& name) {
  return journal::Journals({folder}).Find(id).value().Number("run/" + name).value();
}

/// The values of a scalar in the journal, in the order of the plan's runs.
std::vector<double> InJournal(const plan::Plan& plan, const fs::path& folder, const char* name) {
  std::vector<double> values;
  for (const plan::Run& run : plan.runs) values.push_back(NumberIn(folder, run.id, name));
  return values;
}

TEST_F(ScheduleTest, MeasuresNoisyRunsAgainAndKeepsTheQuietest) {
  plan = MakePlan({.quantities = {1, 2, 3}, .detectors = {"dbvt"}});
  using machine::Noise;
  launcher.noise = [this](const plan::Run& run, int attempt) -> machine::NoiseJudgement {
    const double disturbed[] = {0.5, 0.2, 0.4, 0.3};
    if (run.id == plan.runs[0].id) return {Noise::kNoisy, "busy", disturbed[attempt - 1]};
    if (run.id == plan.runs[1].id && attempt == 1) return {Noise::kNoisy, "busy", 0.1};
    return {Noise::kQuiet, "", 0.01};
  };
  options.noisy_retries = 3;
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 3}));
  EXPECT_EQ(launcher.started.size(), 4u + 2 + 1);
  EXPECT_EQ(ears.ended, 3u);
  EXPECT_EQ(InJournal(plan, options.folder, "attempts"), (std::vector<double>{4, 2, 1}));
  EXPECT_EQ(InJournal(plan, options.folder, "place_time"), (std::vector<double>{2, 2, 1}));
  EXPECT_EQ(InJournal(plan, options.folder, "noise"), (std::vector<double>{2, 1, 1}));
  // Finished runs are not measured again when the sweep is resumed.
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 3, .resumed = 3}));
  EXPECT_EQ(launcher.started.size(), 7u);
}

TEST_F(ScheduleTest, ANoisyRunWhoseRepeatCrashesIsKept) {
  plan = MakePlan({.quantities = {1}, .detectors = {"dbvt"}});
  launcher.behave = [this](const auto&) {
    return launcher.started.size() == 1 ? results::Status::kDone : results::Status::kCrashed;
  };
  launcher.noise = [](const auto&, int attempt) -> machine::NoiseJudgement {
    if (attempt == 1) return {machine::Noise::kNoisy, "busy", 0.5};
    return {};
  };
  options.noisy_retries = 2;
  EXPECT_EQ(Run(plan), (schedule::Summary{.done = 1}));
  EXPECT_EQ(InJournal(plan, options.folder, "attempts"), std::vector<double>{3});
  EXPECT_EQ(InJournal(plan, options.folder, "place_time"), std::vector<double>{1});
}

TEST_F(ScheduleTest, AStopWhileARunIsMeasuredAgainKeepsIt) {
  plan = MakePlan({.quantities = {1, 2}, .detectors = {"dbvt"}});
  process::StopFlag stop;
  options.stop = &stop;
  options.noisy_retries = 5;
  launcher.noise = [](const auto&, int attempt) -> machine::NoiseJudgement {
    return {machine::Noise::kNoisy, "busy", 1.0 / attempt};
  };
  launcher.behave = [&](const auto&) {
    if (launcher.started.size() < 3) return results::Status::kDone;
    stop.Request(SIGTERM);
    return results::Status::kMissing;  // it does not end before the stop
  };
  const schedule::Summary summary = Run(plan);
  EXPECT_EQ(summary, (schedule::Summary{.done = 1, .left = 1, .signal = SIGTERM}));
  EXPECT_EQ(NumberIn(options.folder, launcher.started[0], "place_time"), 2);
  EXPECT_EQ(NumberIn(options.folder, launcher.started[0], "attempts"), 2);
}

}  // namespace
}  // namespace cdb::tests
