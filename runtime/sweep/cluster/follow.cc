#include "runtime/sweep/cluster/follow.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "runtime/results/journal/journals.h"
#include "runtime/sweep/cluster/slurm.h"

namespace cdb::cluster {
namespace {

namespace fs = std::filesystem;

/// Pauses between queries, s: a cluster has one controller for all its users.
constexpr double kFirstPause = 1, kLongestPause = 5, kPauseGrowth = 1.3;

void Pause(double seconds, const process::StopFlag& stop) {
  pollfd watched = {stop.fd(), POLLIN, 0};
  poll(&watched, 1, static_cast<int>(1000 * seconds));
}

/// `12 tasks running, 52 waiting (Resources)`
std::string TaskText(const ActiveTasks& active) {
  std::string text =
      fmt::format("{} task{} running", active.running, active.running == 1 ? "" : "s");
  if (active.waiting > 0) text += fmt::format(", {} waiting", active.waiting);
  if (active.waiting > 0 && !active.reason.empty()) text += fmt::format(" ({})", active.reason);
  return text;
}

class Watch {
 public:
  Watch(const plan::Plan& plan, const fs::path& folder, const Submission& submission,
        const schedule::ProgressOutput& output, bool is_quiet)
      : runs_(plan, folder), submission_(submission), bar_(output), is_quiet_(is_quiet) {
    runs_.Update();
    begin_ended_ = told_ = runs_.ended();
    begin_s_ = output.now_s();
    pace_.Begin(begin_ended_, begin_s_);
    if (is_quiet_ || output.is_terminal) return;
    std::string text =
        fmt::format("{}: {} run{}", plan.benchmark, runs_.total(), runs_.total() == 1 ? "" : "s");
    if (begin_ended_ > 0) text += fmt::format(", {} of them already done", begin_ended_);
    bar_.Line(text + fmt::format("; job {}", submission.array));
  }
  ~Watch() { bar_.Clear(); }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  /// True if every run has finished.
  bool IsMerging() const { return runs_.ended() == runs_.total(); }

  /// Queries folder and Slurm. False if Slurm no longer lists the jobs.
  bool Look() {
    std::string why;
    const auto active = FindActive(submission_.array, submission_.merge, why);
    if (active) {
      active_ = *active;
      is_answered_ = true;
    } else if (std::exchange(is_answered_, false) && !is_quiet_) {
      bar_.Line(fmt::format("warning: Slurm does not answer ({}); waiting for it", why));
    }
    runs_.Update();
    if (!is_quiet_) Show();
    return !active || active_.count() > 0;
  }

 private:
  schedule::ProgressState State() const {
    schedule::ProgressState state = {runs_.ended(), runs_.total(), runs_.bad(), {}, {}};
    const double elapsed_s = bar_.output().now_s() - begin_s_;
    const auto came = static_cast<double>(runs_.ended() - begin_ended_);
    if (came > 0 && active_.running > 0)
      state.left_s = elapsed_s / came * static_cast<double>(runs_.total() - runs_.ended());
    state.detail = !is_answered_ ? "Slurm does not answer"
                   : IsMerging() ? fmt::format("merging, job {}", submission_.merge)
                                 : TaskText(active_);
    return state;
  }

  void Show() {
    if (bar_.output().is_terminal) return bar_.Draw(true, [this] { return State(); });
    // No line if nothing has changed.
    if (runs_.ended() == told_) return;
    if (!pace_.IsDue(runs_.ended(), runs_.total(), bar_.output().now_s())) return;
    told_ = runs_.ended();
    const schedule::ProgressState state = State();
    std::string text = schedule::ShareText(state.ended, state.total);
    if (const std::string left = schedule::LeftText(state); !left.empty()) text += "  " + left;
    if (state.bad > 0) text += fmt::format("  {} bad", state.bad);
    bar_.Line(text + "  " + state.detail);
  }

  RunCount runs_;
  const Submission& submission_;
  schedule::ProgressBar bar_;
  schedule::LogPace pace_;
  const bool is_quiet_;
  std::size_t begin_ended_ = 0, told_ = 0;
  double begin_s_ = 0;
  ActiveTasks active_;
  bool is_answered_ = true;
};

}  // namespace

RunCount::RunCount(const plan::Plan& plan, fs::path folder) : folder_(std::move(folder)) {
  if (plan.whole) {
    total_ = plan.RunCount();
    return;
  }
  std::unordered_set<std::string_view> ids;
  for (const auto* runs : {&plan.runs, &plan.references})
    for (const plan::Run& run : *runs) ids.insert(run.id);
  total_ = ids.size();
}

void RunCount::Update() {
  for (const fs::path& file : journal::JournalsIn(folder_)) try {
      auto journal = journal::Journal::OpenToRead(file);
      std::int64_t& last = last_row_[file];
      std::vector<std::int64_t> added;
      journal.ForEachRun(
          [&](const journal::Journal::Row& row) {
            last = row.number;
            if (seen_.insert(row.run_id).second && !is_first_) added.push_back(row.number);
          },
          last);
      for (const std::int64_t row : added)
        if (const auto record = journal.ReadRow(row))
          bad_ += !journal::InfoOf(*record).outcome.IsGood();
    } catch (const std::runtime_error&) {
      // is being written and not yet visible, or was just merged
    }
  is_first_ = false;
  ended_ = std::min(seen_.size(), total_);
}

void Follow(const plan::Plan& plan, const fs::path& folder, const Submission& submission,
            const process::StopFlag& stop, const schedule::ProgressOutput& output, bool is_quiet) {
  Watch watch(plan, folder, submission, output, is_quiet);
  double pause_s = kFirstPause;
  while (!stop.requested() && watch.Look()) {
    Pause(pause_s, stop);
    // Merging takes little time, so look often.
    pause_s = watch.IsMerging() ? kFirstPause : std::min(pause_s * kPauseGrowth, kLongestPause);
  }
}

}  // namespace cdb::cluster
