// Progress of a sweep: a bar on a terminal, plain lines in a log.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/sweep/schedule/estimate.h"
#include "runtime/sweep/schedule/progress_bar.h"
#include "runtime/sweep/schedule/schedule.h"

namespace cdb::schedule {

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
