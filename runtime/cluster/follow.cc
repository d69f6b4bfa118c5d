#include "runtime/cluster/follow.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "runtime/cluster/slurm.h"
#include "runtime/schedule/folder.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"

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
  Watch(const plan::Plan& plan, const fs::path& shards, const Submission& submission,
        const schedule::ProgressOutput& output, bool is_quiet)
      : shards_(plan, shards), submission_(submission), bar_(output), is_quiet_(is_quiet) {
    shards_.Update();
    begin_ended_ = told_ = shards_.ended();
    begin_s_ = output.now_s();
    pace_.Begin(begin_ended_, begin_s_);
    if (is_quiet_ || output.is_terminal) return;
    std::string text = fmt::format("{}: {} run{}", plan.benchmark, shards_.total(),
                                   shards_.total() == 1 ? "" : "s");
    if (begin_ended_ > 0) text += fmt::format(", {} of them there already", begin_ended_);
    bar_.Line(text + fmt::format("; job {}", submission.array));
  }
  ~Watch() { bar_.Clear(); }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  /// True if every run has a shard.
  bool IsMerging() const { return shards_.ended() == shards_.total(); }

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
    shards_.Update();
    if (!is_quiet_) Show();
    return !active || active_.count() > 0;
  }

 private:
  schedule::ProgressState State() const {
    schedule::ProgressState state = {shards_.ended(), shards_.total(), shards_.bad(), {}, {}};
    const double elapsed_s = bar_.output().now_s() - begin_s_;
    const auto came = static_cast<double>(shards_.ended() - begin_ended_);
    if (came > 0 && active_.running > 0)
      state.left_s = elapsed_s / came * static_cast<double>(shards_.total() - shards_.ended());
    state.detail = !is_answered_ ? "Slurm does not answer"
                   : IsMerging() ? fmt::format("merging, job {}", submission_.merge)
                                 : TaskText(active_);
    return state;
  }

  void Show() {
    if (bar_.output().is_terminal) return bar_.Draw(true, [this] { return State(); });
    // No line if nothing has changed.
    if (shards_.ended() == told_) return;
    if (!pace_.IsDue(shards_.ended(), shards_.total(), bar_.output().now_s())) return;
    told_ = shards_.ended();
    const schedule::ProgressState state = State();
    std::string text = schedule::ShareText(state.ended, state.total);
    if (const std::string left = schedule::LeftText(state); !left.empty()) text += "  " + left;
    if (state.bad > 0) text += fmt::format("  {} bad", state.bad);
    bar_.Line(text + "  " + state.detail);
  }

  ShardCount shards_;
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

ShardCount::ShardCount(const plan::Plan& plan, fs::path folder) : folder_(std::move(folder)) {
  if (plan.whole) {
    total_ = plan.RunCount();
    return;
  }
  std::unordered_set<std::string_view> ids;
  for (const auto* runs : {&plan.runs, &plan.references})
    for (const plan::Run& run : *runs) ids.insert(run.id);
  total_ = ids.size();
}

void ShardCount::Update() {
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::string id = schedule::RunIdOfShard(name);
    if (id.empty() || seen_.contains(id)) continue;
    if (!is_first_) {
      try {
        bad_ += !shards::ReadShardInfo(entry->path()).outcome.IsGood();
      } catch (const std::runtime_error&) {
        continue;  // is being written and not yet visible, or was just merged
      }
    }
    seen_.insert(std::move(id));
  }
  is_first_ = false;
  ended_ = std::min(seen_.size(), total_);
}

void Follow(const plan::Plan& plan, const fs::path& shards, const Submission& submission,
            const process::StopFlag& stop, const schedule::ProgressOutput& output, bool is_quiet) {
  Watch watch(plan, shards, submission, output, is_quiet);
  double pause_s = kFirstPause;
  while (!stop.requested() && watch.Look()) {
    Pause(pause_s, stop);
    // Merging takes little time, so look often.
    pause_s = watch.IsMerging() ? kFirstPause : std::min(pause_s * kPauseGrowth, kLongestPause);
  }
}

}  // namespace cdb::cluster
