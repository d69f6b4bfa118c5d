#include "runtime/sweep/schedule/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace cdb::schedule {
namespace {

constexpr double kFirstOfPile_s = 5, kNextOfPile_s = 60;  // between lines of a log

std::string Ended(const results::RunResult& result, double wall_s) {
  if (result.outcome().IsGood() && result.scalars.attempts > 1)
    return fmt::format(
        "done in {}, {} of {:.0f} attempts", DurationText(wall_s),
        result.noise.noise == machine::Noise::kNoisy ? "the least noisy" : "the last",
        result.scalars.attempts);
  if (result.outcome().IsGood()) return "done in " + DurationText(wall_s);
  if (result.status == results::Status::kDone)
    return fmt::format("{} from cycle {} on: its timings do not count",
                       protocol::VerdictName(result.judgement.verdict),
                       result.judgement.first_bad_cycle);
  return fmt::format("{}: {}",
                     result.status == results::Status::kTimedOut
                         ? std::string_view("timed out")
                         : results::StatusName(result.status),
                     result.message);
}

}  // namespace

Progress::Progress(ProgressOutput output) : bar_(std::move(output)) {}

void Progress::BeginPart(std::uint64_t part, std::uint64_t parts) {
  part_ = parts > 1 ? fmt::format(", part {} of {}", part + 1, parts) : std::string();
}

void Progress::Begin(const plan::Plan& plan, const std::vector<const plan::Run*>& to_do,
                     const Summary& resumed, std::size_t jobs) {
  plan_ = &plan;
  estimate_.emplace(to_do);
  jobs_ = jobs;
  ended_ = resumed.ended();
  bad_ = ended_ - resumed.done + resumed.spoiled;
  total_ = to_do.size() + ended_;
  pace_.Begin(ended_, output().now_s());
  settling_s_ = output().now_s() - kNextOfPile_s;
  if (output().is_terminal && part_.empty()) return Draw(true);
  std::string text =
      fmt::format("{}{}: {} run{}", plan.benchmark, part_, total_, total_ == 1 ? "" : "s");
  if (ended_ > 0) text += fmt::format(", {} of them already done", ended_);
  if (jobs > 1) text += fmt::format(", {} at a time", jobs);
  bar_.Line(text);
}

void Progress::RunStarted(const plan::Run& run) {
  running_.push_back({&run, output().now_s()});
  if (output().is_terminal) Draw(false);
}

void Progress::RunSettles(const plan::Run& run, const std::string& how_far) {
  for (Running& one : running_)
    if (one.run == &run) one.settling = how_far;
  if (output().is_terminal) Draw(false);
}

/// In a log, which otherwise has no line until the run ends.
void Progress::TellOfSettling() {
  const double now_s = output().now_s();
  for (const Running& one : running_) {
    const double since_s = std::max(settling_s_ + kNextOfPile_s, one.since_s + kFirstOfPile_s);
    if (one.settling.empty() || now_s < since_s) continue;
    bar_.Line(fmt::format("{}  {}: its pile settles, {}", ShareText(ended_, total_), Name(*one.run),
                          one.settling));
    settling_s_ = now_s;
  }
}

void Progress::RunEnded(const plan::Run& run, const results::RunResult& result, double wall_s) {
  std::erase_if(running_, [&run](const Running& one) { return one.run == &run; });
  const bool is_telling =
      result.status == results::Status::kDone || result.status == results::Status::kTimedOut;
  estimate_->Ended(run, is_telling ? std::optional(wall_s) : std::nullopt);
  Advance(result.outcome());
  const bool is_bad = !result.outcome().IsGood();
  if (output().is_terminal) {
    if (is_bad) bar_.Line(fmt::format("{}: {}", Name(run), Ended(result, wall_s)));
    return Draw(ended_ == total_);
  }
  const bool is_due = pace_.IsDue(ended_, total_, output().now_s());
  if (!is_due && !is_bad) return;
  std::string text =
      fmt::format("{}  {}: {}", ShareText(ended_, total_), Name(run), Ended(result, wall_s));
  if (is_due && !is_bad && total_ > kSmallPlan)
    if (const std::string left = LeftText(State()); !left.empty()) text += "; " + left;
  bar_.Line(text);
}

void Progress::Repeat(const plan::Plan&, const std::vector<const plan::Run*>& runs,
                      const std::string& components) {
  bar_.Line(fmt::format("{} run{} again, now with {}: runs that they are compared with keep it",
                        runs.size(), runs.size() == 1 ? "" : "s", components));
  estimate_.emplace(runs);
  total_ += runs.size();
}

void Progress::RunFound(const plan::Run& run, const results::Outcome& outcome) {
  estimate_->Ended(run, std::nullopt);
  Advance(outcome);
  if (output().is_terminal) Draw(false);
}

void Progress::Warn(const std::string& text) {
  bar_.Line("warning: " + text);
  if (output().is_terminal && plan_ != nullptr) Draw(true);
}

void Progress::Tick() {
  if (output().is_terminal) return Draw(false);
  TellOfSettling();
}

void Progress::End() { bar_.Clear(); }

void Progress::Advance(const results::Outcome& outcome) {
  ++ended_;
  bad_ += outcome.IsGood() ? 0 : 1;
}

std::string Progress::Name(const plan::Run& run) const { return plan::Describe(*plan_, run); }

std::optional<double> Progress::LeftSeconds() const {
  if (ended_ == total_) return std::nullopt;
  auto left = estimate_->Left();
  if (!left) return std::nullopt;
  const double now_s = output().now_s();
  for (const Running& one : running_)
    *left -= std::min(now_s - one.since_s, estimate_->Predict(*one.run).value_or(0));
  const std::size_t at_a_time = std::min(jobs_, total_ - ended_);
  return *left / static_cast<double>(std::max<std::size_t>(at_a_time, 1));
}

ProgressState Progress::State() const {
  ProgressState state = {ended_, total_, bad_, LeftSeconds(), {}};
  if (running_.empty()) return state;
  const Running& last = running_.back();
  if (!last.settling.empty()) state.detail = "settling, " + last.settling + ":  ";
  state.detail += Name(*last.run);
  return state;
}

void Progress::Draw(bool is_urgent) {
  bar_.Draw(is_urgent, [this] { return State(); });
}

}  // namespace cdb::schedule
