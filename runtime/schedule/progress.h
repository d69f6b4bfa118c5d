// Progress of a sweep: a bar on a terminal, plain lines in a log.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/schedule/estimate.h"
#include "runtime/schedule/progress_bar.h"
#include "runtime/schedule/schedule.h"

namespace cdb::schedule {

/// The bar: runs done of all, percentage, time left, failures, the run at hand; of a run whose pile
/// settles also how far. Failures and warnings are lines above it. In a log: one line at the start,
/// then one for each run, or at the pace of LogPace; one for each failure and warning; and one for
/// a pile that settles for 5 s, then each minute.
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
  double settling_s_ = 0;  // when a line of a log last told of a pile
};

}  // namespace cdb::schedule
