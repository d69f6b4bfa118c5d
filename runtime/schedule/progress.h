// Progress of a sweep: a bar on a terminal, plain lines in a log.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/schedule/estimate.h"
#include "runtime/schedule/schedule.h"

namespace cdb::schedule {

/// Where progress goes, and what it knows of the world; tests put in their own.
struct ProgressOutput {
  bool is_terminal = false;  ///< a bar; else lines
  bool is_utf8 = false;
  std::function<double()> now_s;                ///< any origin, never backwards
  std::function<std::size_t()> columns;         ///< asked before each drawing; terminal only
  std::function<void(std::string_view)> write;  ///< in one piece; must not throw
};

/// Standard error as it is: a terminal unless TERM is dumb, UTF-8 as the locale says.
ProgressOutput StandardError();

/// The bar: runs done of all, percentage, time left, failures, the run at hand; drawn at most ten
/// times a second in one line as wide as the terminal is then, cleared at the end; of a run whose
/// pile settles also how far. Failures and
/// warnings are lines above it. In a log: one line at the start, then one for each run, or, for
/// plans of more than 40 runs, one for each 5 % or minute but not within 5 s of the last; one for
/// each failure and warning; and one for a pile that settles for 5 s, then each minute.
class Progress : public ProgressListener {
 public:
  explicit Progress(ProgressOutput output);

  void BeginPart(std::uint64_t part, std::uint64_t parts) override;
  void Begin(const plan::Plan& plan, const std::vector<const plan::Run*>& to_do,
             const Summary& resumed, std::size_t jobs) override;
  void RunStarted(const plan::Run& run) override;
  void RunSettles(const plan::Run& run, const std::string& how_far) override;
  void RunEnded(const plan::Run& run, const store::RunResult& result, double wall_s) override;
  void Repeat(const plan::Plan& plan, const std::vector<const plan::Run*>& runs,
              const std::string& components) override;
  void RunFound(const plan::Run& run, const store::Outcome& outcome) override;
  void Warn(const std::string& text) override;
  void Tick() override;
  void End() override;

 private:
  struct Running {
    const plan::Run* run;
    double since_s;
    std::string settling = {};  ///< how far its piles have settled; empty if they do not
  };

  void Advance(const store::Outcome& outcome);
  std::string Name(const plan::Run& run) const;
  void TellOfSettling();
  std::string Share() const;
  std::string TimeLeft() const;
  std::string BarLine(std::size_t columns) const;
  void Line(const std::string& text);
  void Clear();
  void Draw(bool is_urgent);

  ProgressOutput output_;
  const plan::Plan* plan_ = nullptr;
  std::string part_;  // `, part 3 of 100`, or empty
  std::optional<TimeEstimate> estimate_;
  std::vector<Running> running_;
  std::size_t total_ = 0, ended_ = 0, bad_ = 0, jobs_ = 1;
  std::size_t drawn_width_ = 0;  // 0: no bar on the terminal
  double drawn_s_ = 0;
  double line_s_ = 0;  // when, and how far, the last line of a log was
  std::size_t line_ended_ = 0;
  double settling_s_ = 0;  // when a line of a log last told of a pile
};

/// `45 s`, `12 min`, `3 h 5 min`, `2 d 4 h`.
std::string DurationText(double seconds);

}  // namespace cdb::schedule
