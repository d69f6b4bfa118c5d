// Progress of a sweep: a bar on a terminal, plain lines in a log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/sweep/schedule/schedule.h"

namespace cdb::schedule {

// A progress bar on a terminal, with lines above it.

/// The output of progress and its environment; replaced by tests.
struct ProgressOutput {
  bool is_terminal = false;  ///< draw a bar; otherwise print lines
  bool is_utf8 = false;
  std::function<double()> now_s;                ///< with any origin; never decreases
  std::function<std::size_t()> columns;         ///< called before each drawing; terminal only
  std::function<void(std::string_view)> write;  ///< writes the text in one piece; must not throw
};

/// Standard error: a terminal unless TERM is dumb, UTF-8 according to the locale.
ProgressOutput StandardError();

/// Progress of a sweep.
struct ProgressState {
  std::size_t ended = 0, total = 0, bad = 0;  ///< numbers of runs
  std::optional<double> left_s = {};          ///< none: unknown
  std::string detail = {};                    ///< the current work
};

/// `12/40  30 %`
std::string ShareText(std::size_t ended, std::size_t total);
/// `5 min left`; empty if it is unknown or nothing is left.
std::string LeftText(const ProgressState& state);
/// `45 s`, `12 min`, `3 h 5 min`, `2 d 4 h`.
std::string DurationText(double seconds);

/// Drawn at most ten times a second, in one line as wide as the terminal at that time. Not
/// thread-safe.
class ProgressBar {
 public:
  explicit ProgressBar(ProgressOutput output) : output_(std::move(output)) {}

  const ProgressOutput& output() const { return output_; }
  /// Prints a line above the bar, which is cleared. Text from files is made printable.
  void Line(const std::string& text);
  /// `state` is called only if the bar is drawn now.
  void Draw(bool is_urgent, const std::function<ProgressState()>& state);
  void Clear();

 private:
  std::string Text(const ProgressState& state, std::size_t columns) const;

  ProgressOutput output_;
  std::size_t drawn_width_ = 0;  // 0: no bar on the terminal
  double drawn_s_ = 0;
};

/// The most runs for which a log has one line each.
inline constexpr std::size_t kSmallPlan = 40;

/// Decides when a line of a log is due: for plans of more than kSmallPlan runs, one for each 5 % or
/// minute, but not within 5 s of the last.
class LogPace {
 public:
  void Begin(std::size_t ended, double now_s);
  /// Counts a line that is due as written.
  bool IsDue(std::size_t ended, std::size_t total, double now_s);

 private:
  std::size_t line_ended_ = 0;
  double line_s_ = 0;
};

// Estimates the remaining time from the runs that have finished.

/// Predicts a run from the mean of similar ones (same detector, objects, cycles), or else by a
/// power law of the time of a cycle in the number of objects, fitted to the runs of its detector,
/// or else to all runs. Not thread-safe.
class TimeEstimate {
 public:
  explicit TimeEstimate(const std::vector<const plan::Run*>& to_do);

  /// `run` took `wall_s`. Pass none for a failed run, whose time predicts nothing.
  void Ended(const plan::Run& run, std::optional<double> wall_s);

  /// Seconds; none before any run has ended.
  std::optional<double> Predict(const plan::Run& run) const;
  /// The sum over all runs that have not ended.
  std::optional<double> Left() const;

 private:
  /// Runs that are alike.
  struct Kind {
    std::string detector;
    double objects, cycles;
    double timeout_s;
    auto operator<=>(const Kind&) const = default;
  };
  struct Times {
    std::size_t left = 0, ended = 0;
    double sum_s = 0;
  };
  /// Fit of log(seconds per cycle) over log(objects): least squares from running sums.
  struct Fit {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    void Add(double objects, double cycle_s);
    double CycleSeconds(double objects) const;
  };

  static Kind KindOf(const plan::Run& run);
  std::optional<double> Predict(const Kind& kind, const Times& times) const;

  std::map<Kind, Times> kinds_;
  std::map<std::string, Fit> fits_;
  Fit all_;
};

/// On a terminal, a bar: finished and total runs, percentage, time left, failures, the current run,
/// and progress of its pile if one settles. Failures and warnings are lines above it. In a log: one
/// line at the start, then one for each run, or at the pace of LogPace; one for each failure and
/// warning; and one for a pile that has been settling for 5 s, then one each minute.
class Progress : public ProgressListener {
 public:
  explicit Progress(ProgressOutput output);

  void BeginPart(std::uint64_t part, std::uint64_t parts) override;
  void Begin(const plan::Plan& plan, const std::vector<const plan::Run*>& to_do,
             const Summary& resumed, std::size_t jobs) override;
  void RunStarted(const plan::Run& run) override;
  void RunSettles(const plan::Run& run, const std::string& how_far) override;
  void RunEnded(const plan::Run& run, const results::RunResult& result, double wall_s) override;
  void Repeat(const plan::Plan& plan, const std::vector<const plan::Run*>& runs,
              const std::string& components) override;
  void RunFound(const plan::Run& run, const results::Outcome& outcome) override;
  void Warn(const std::string& text) override;
  void Tick() override;
  void End() override;

 private:
  struct Running {
    const plan::Run* run;
    double since_s;
    std::string settling = {};  ///< progress of its piles; empty if none settles
  };

  void Advance(const results::Outcome& outcome);
  std::string Name(const plan::Run& run) const;
  void TellOfSettling();
  std::optional<double> LeftSeconds() const;
  ProgressState State() const;
  void Draw(bool is_urgent);
  const ProgressOutput& output() const { return bar_.output(); }

  ProgressBar bar_;
  LogPace pace_;
  const plan::Plan* plan_ = nullptr;
  std::string part_;  // `, part 3 of 100`, or empty
  std::optional<TimeEstimate> estimate_;
  std::vector<Running> running_;
  std::size_t total_ = 0, ended_ = 0, bad_ = 0, jobs_ = 1;
  double settling_s_ = 0;  // time of the last line of a log about a pile
};

}  // namespace cdb::schedule
