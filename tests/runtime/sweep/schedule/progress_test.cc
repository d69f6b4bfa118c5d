#include "runtime/sweep/schedule/progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

/// A terminal or a log, and a simulated clock.
struct Screen {
  double now_s = 1000;
  std::size_t columns = 80;
  std::string text;

  schedule::ProgressOutput Output(bool is_terminal, bool is_utf8 = true) {
    return {is_terminal, is_utf8, [this] { return now_s; }, [this] { return columns; },
            [this](std::string_view more) { text += more; }};
  }
  /// The output since the last call, with escape sequences as words.
  std::string Take() {
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\r') {
        plain += "<cr>";
      } else if (text[i] == '\x1b') {
        const std::size_t end = text.find_first_of("AJK", i);
        plain.append("<").append(text, i + 2, end - i - 1).append(">");
        i = end;
      } else {
        plain += text[i];
      }
    }
    text.clear();
    return plain;
  }
};

results::RunResult Result(results::Status status, std::string message = "") {
  results::RunResult result;
  result.status = status;
  result.message = std::move(message);
  return result;
}

TEST(ProgressBarTest, TellsAllOfIt) {
  const auto plan = MakePlan({.quantities = {100, 200}, .detectors = {"dbvt", "sap"}});
  Screen screen;
  schedule::Progress progress(screen.Output(true));
  progress.Begin(plan, Pointers(plan), {}, 1);
  EXPECT_EQ(screen.Take(), "<cr>▕                    ▏ 0/4   0 %<K>");
  progress.RunStarted(plan.runs[0]);
  EXPECT_EQ(screen.Take(), "") << "drawn a moment ago";
  screen.now_s += 1;
  progress.Tick();
  EXPECT_EQ(screen.Take(), "<cr>▕                    ▏ 0/4   0 %  quantity 100, detector dbvt<K>");
  screen.now_s += 19;
  progress.RunEnded(plan.runs[0], Result(results::Status::kDone), 20);
  // The other run of this size takes equally long, the two of twice the size twice as long: 20 + 2
  // x 40 s.
  EXPECT_EQ(screen.Take(), "<cr>▕█████               ▏ 1/4  25 %  2 min left<K>");
  progress.RunStarted(plan.runs[1]);
  screen.now_s += 14.5;
  progress.Tick();
  EXPECT_EQ(screen.Take(),
            "<cr>▕█████               ▏ 1/4  25 %  86 s left  quantity 100, detector sap<K>");
  progress.RunEnded(plan.runs[1], Result(results::Status::kCrashed, "signal 11"), 1);
  EXPECT_EQ(screen.Take(),
            "<cr><J>cdb: quantity 100, detector sap: crashed: signal 11\n"
            "<cr>▕██████████          ▏ 2/4  50 %  80 s left  1 bad<K>");
  progress.End();
  EXPECT_EQ(screen.Take(), "<cr><J>");
  progress.End();
  EXPECT_EQ(screen.Take(), "") << "nothing left to clear";
}

TEST(ProgressBarTest, IsAsciiWhereTheLocaleIs) {
  const auto plan = MakePlan({.quantities = {100, 200}, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(true, false));
  progress.Begin(plan, Pointers(plan), {}, 1);
  screen.now_s += 1;
  progress.RunEnded(plan.runs[0], Result(results::Status::kDone), 2);
  EXPECT_EQ(screen.Take(),
            "<cr>[....................] 0/2   0 %<K>"
            "<cr>[##########..........] 1/2  50 %  4 s left<K>");
}

TEST(ProgressBarTest, ShowsEighthsOfACell) {
  std::vector<std::uint64_t> quantities(64);
  for (std::size_t i = 0; i < quantities.size(); ++i) quantities[i] = i + 1;
  const auto plan = MakePlan({.quantities = quantities, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(true));
  schedule::Summary resumed;
  resumed.done = 3;  // 3/64 of 160 eighths are 7.5
  std::vector<const plan::Run*> to_do = Pointers(plan);
  to_do.erase(to_do.begin(), to_do.begin() + 3);
  progress.Begin(plan, to_do, resumed, 1);
  EXPECT_EQ(screen.Take(), "<cr>▕▉                   ▏  3/64   4 %<K>");
}

TEST(ProgressBarTest, FitsTheTerminal) {
  const auto plan = MakePlan({.quantities = {100, 200}, .detectors = {"dbvt"}});
  for (std::size_t columns = 0; columns < 90; ++columns) {
    for (const bool is_utf8 : {false, true}) {
      Screen screen;
      screen.columns = columns;
      schedule::Progress progress(screen.Output(true, is_utf8));
      progress.Begin(plan, Pointers(plan), {}, 1);
      progress.RunStarted(plan.runs[0]);
      screen.now_s += 1;
      screen.Take();
      progress.Tick();
      std::string line = screen.Take();
      line = line.substr(line.rfind("<cr>") + 4);
      line = line.substr(0, line.find("<K>"));
      std::size_t width = 0;
      for (const char c : line) width += (c & 0xc0) != 0x80;
      EXPECT_LT(width, std::max<std::size_t>(columns, 1)) << line;
      EXPECT_TRUE(columns < 70 || line.ends_with("quantity 100, detector dbvt")) << line;
    }
  }
}

TEST(ProgressBarTest, CutsWithDots) {
  const auto plan = MakePlan({.quantities = {100, 200}, .detectors = {"dbvt"}});
  Screen screen;
  screen.columns = 30;
  schedule::Progress progress(screen.Output(true));
  progress.Begin(plan, Pointers(plan), {}, 1);
  progress.RunStarted(plan.runs[0]);
  screen.now_s += 1;
  screen.Take();
  progress.Tick();
  EXPECT_EQ(screen.Take(), "<cr>0/2   0 %  quantity 100, det…<K>");
}

TEST(ProgressBarTest, ClimbsOverTheLinesThatANarrowerTerminalMade) {
  const auto plan = MakePlan({.quantities = {100, 200}, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(true));
  progress.Begin(plan, Pointers(plan), {}, 1);
  screen.Take();
  screen.columns = 15;  // the previous 32 columns now take three lines
  screen.now_s += 1;
  progress.Tick();
  EXPECT_EQ(screen.Take(), "<2A><cr><J>0/2   0 %<K>");
  screen.columns = 4;
  progress.End();
  EXPECT_EQ(screen.Take(), "<2A><cr><J>");
}

TEST(ProgressBarTest, IsDrawnTenTimesASecondAtMost) {
  std::vector<std::uint64_t> quantities(1000);
  for (std::size_t i = 0; i < quantities.size(); ++i) quantities[i] = i;
  const auto plan = MakePlan({.quantities = quantities, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(true));
  progress.Begin(plan, Pointers(plan), {}, 1);
  for (const plan::Run& run : plan.runs) {
    progress.RunStarted(run);
    screen.now_s += 0.001;
    progress.RunEnded(run, Result(results::Status::kDone), 0.001);
  }
  const std::string all = screen.Take();
  std::size_t drawn = 0;
  for (std::size_t at = 0; (at = all.find("<cr>", at)) != std::string::npos; ++at) ++drawn;
  EXPECT_LE(drawn, 12u);
  EXPECT_GE(drawn, 9u);
  EXPECT_NE(all.find("1000/1000 100 %"), std::string::npos) << "the last is drawn at once";
}

TEST(ProgressBarTest, WarningsStandAboveIt) {
  const auto plan = MakePlan({.quantities = {100}, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(true));
  progress.Warn("a broken journal");
  EXPECT_EQ(screen.Take(), "cdb: warning: a broken journal\n");
  progress.Begin(plan, Pointers(plan), {}, 1);
  screen.Take();
  progress.Warn("another");
  EXPECT_EQ(screen.Take(), "<cr><J>cdb: warning: another\n<cr>▕                    ▏ 0/1   0 %<K>");
}

TEST(ProgressBarTest, JobsShareTheTimeLeft) {
  const auto plan = MakePlan({.quantities = {100}, .detectors = {"dbvt"}, .repeats = 5});
  Screen screen;
  schedule::Progress progress(screen.Output(true));
  progress.Begin(plan, Pointers(plan), {}, 2);
  progress.RunStarted(plan.runs[0]);
  progress.RunStarted(plan.runs[1]);
  screen.Take();
  screen.now_s += 10;
  progress.RunEnded(plan.runs[0], Result(results::Status::kDone), 10);
  // Four are left at 10 s each, one of them nearly done, in two slots: 15 s.
  EXPECT_EQ(screen.Take(),
            "<cr>▕████                ▏ 1/5  20 %  15 s left  quantity 100, detector dbvt, rep 1"
            "<K>");
}

TEST(ProgressLogTest, HasALineForEachRunOfASmallPlan) {
  const auto plan = MakePlan({.quantities = {100, 200}, .detectors = {"dbvt", "sap"}});
  Screen screen;
  schedule::Progress progress(screen.Output(false));
  schedule::Summary resumed;
  resumed.done = 1;
  std::vector<const plan::Run*> to_do = Pointers(plan);
  to_do.erase(to_do.begin());
  progress.Begin(plan, to_do, resumed, 2);
  progress.RunStarted(*to_do[0]);
  progress.RunEnded(*to_do[0], Result(results::Status::kDone), 1.25);
  progress.Tick();
  progress.RunEnded(*to_do[1], Result(results::Status::kTimedOut, "ended after its timeout of 3 s"),
                    3);
  progress.Warn("odd");
  progress.RunEnded(*to_do[2], Result(results::Status::kFailed, "the cube is full"), 0);
  progress.End();
  EXPECT_EQ(screen.Take(),
            "cdb: study: 4 runs, 1 of them already done, 2 at a time\ncdb: 2/4  50 %  quantity "
            "100, detector sap: done in 1.2 s\ncdb: 3/4  75 %  quantity 200, detector dbvt: timed "
            "out: ended after its timeout of 3 s\ncdb: warning: odd\ncdb: 4/4 100 %  quantity 200, "
            "detector sap: failed: the cube is full\n");
}

TEST(ProgressBarTest, TellsHowFarAPileHasSettled) {
  const auto plan = MakePlan({.quantities = {100}, .detectors = {"dbvt"}});
  Screen screen;
  screen.columns = 120;
  schedule::Progress progress(screen.Output(true));
  progress.Begin(plan, Pointers(plan), {}, 1);
  progress.RunStarted(plan.runs[0]);
  screen.Take();
  screen.now_s += 1;
  progress.RunSettles(plan.runs[0], "34 of 100 objects at rest");
  EXPECT_EQ(screen.Take(),
            "<cr>▕                    ▏ 0/1   0 %  settling, 34 of 100 objects at rest:  quantity "
            "100, detector dbvt<K>");
  screen.now_s += 1;
  progress.RunSettles(plan.runs[0], "");
  EXPECT_EQ(screen.Take(), "<cr>▕                    ▏ 0/1   0 %  quantity 100, detector dbvt<K>");
}

TEST(ProgressLogTest, TellsOfAPileAfterFiveSecondsAndThenEachMinute) {
  const auto plan = MakePlan({.quantities = {100}, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(false));
  progress.Begin(plan, Pointers(plan), {}, 1);
  progress.RunStarted(plan.runs[0]);
  screen.Take();
  std::string all;
  for (int second = 1; second <= 70; ++second) {
    screen.now_s += 1;
    progress.RunSettles(plan.runs[0], std::to_string(second) + " of 100 objects at rest");
    progress.Tick();
    all += screen.Take();
  }
  EXPECT_EQ(
      all,
      "cdb: 0/1   0 %  quantity 100, detector dbvt: its pile settles, 5 of 100 objects at rest\n"
      "cdb: 0/1   0 %  quantity 100, detector dbvt: its pile settles, 65 of 100 objects at rest\n");
}

TEST(ProgressLogTest, SparesALargePlan) {
  std::vector<std::uint64_t> quantities(1000, 7);
  const auto plan = MakePlan({.quantities = quantities, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(false));
  progress.Begin(plan, Pointers(plan), {}, 1);
  EXPECT_EQ(screen.Take(), "cdb: study: 1000 runs\n");
  // 5 % are 50 runs, but at most one line is printed in 5 s: at 20 runs a second, one for every
  // hundredth run.
  std::string all;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    screen.now_s += 0.0625;  // exact in binary: 16 a second, 80 in 5 s
    progress.RunEnded(plan.runs[i], Result(results::Status::kDone), 0.0625);
    const std::string text = screen.Take();
    all += text;
    if (i == 79) {
      EXPECT_EQ(text,
                "cdb:   80/1000   8 %  quantity 7, detector dbvt: done in 62 ms; 58 s left\n");
    }
  }
  EXPECT_EQ(std::ranges::count(all, '\n'), 1000 / 80 + 1) << all;
  EXPECT_TRUE(all.ends_with("cdb: 1000/1000 100 %  quantity 7, detector dbvt: done in 62 ms\n"));
}

TEST(ProgressLogTest, SlowRunsOfALargePlanAreHeardOfOnceAMinute) {
  std::vector<std::uint64_t> quantities(1000, 7);
  const auto plan = MakePlan({.quantities = quantities, .detectors = {"dbvt"}});
  Screen screen;
  schedule::Progress progress(screen.Output(false));
  progress.Begin(plan, Pointers(plan), {}, 1);
  screen.Take();
  int lines = 0;
  for (std::size_t i = 0; i < 49; ++i) {
    screen.now_s += 20;
    progress.RunEnded(plan.runs[i], Result(results::Status::kDone), 20);
    lines += screen.Take().empty() ? 0 : 1;
  }
  EXPECT_EQ(lines, 49 / 3);
  progress.RunEnded(plan.runs[49], Result(results::Status::kCrashed, "x"), 20);
  EXPECT_EQ(screen.Take(), "cdb:   50/1000   5 %  quantity 7, detector dbvt: crashed: x\n");
}

TEST(ProgressTest, Durations) {
  const std::pair<double, const char*> cases[] = {{-1, "0 ms"},
                                                  {0.0123, "12 ms"},
                                                  {0.5, "0.5 s"},
                                                  {9.94, "9.9 s"},
                                                  {9.96, "10 s"},
                                                  {89, "89 s"},
                                                  {90, "2 min"},
                                                  {59 * 60, "59 min"},
                                                  {3599, "1 h 0 min"},
                                                  {3 * 3600 + 5 * 60, "3 h 5 min"},
                                                  {86400 - 1, "1 d 0 h"},
                                                  {2 * 86400 + 4 * 3600, "2 d 4 h"},
                                                  {86400 * 400.0, "400 d 0 h"}};
  for (const auto& [seconds, text] : cases)
    EXPECT_EQ(schedule::DurationText(seconds), text) << seconds;
}

}  // namespace
}  // namespace cdb::tests
