#include "runtime/sweep/schedule/progress.h"

#include <fmt/format.h>
#include <langinfo.h>
#include <locale.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

#include "dsl/text/utf8.h"
#include "runtime/protocol/file_descriptor_io.h"

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
                       protocol::VerdictText(result.judgement), result.judgement.first_bad_cycle);
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

namespace {

constexpr double kDrawInterval = 0.1;  // s
constexpr std::size_t kBarCells = 20;
constexpr std::size_t kFewColumns = 50;  // columns; below this width the bar is left out, not the
                                         // figures

constexpr double kLineInterval = 5;  // s
constexpr double kLongSilence = 60;  // s
constexpr double kLineShare = 0.05;

/// Counts characters as columns: names and numbers are ASCII, our own signs are one column wide.
std::size_t Width(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; }));
}

std::string Cut(std::string text, std::size_t width, bool is_utf8) {
  if (Width(text) <= width) return text;
  const std::string_view dots = is_utf8 ? "…" : "...";
  std::size_t keep = width > Width(dots) ? width - Width(dots) : 0;
  std::size_t at = 0;
  while (at < text.size()) {
    const bool is_start = (text[at] & 0xc0) != 0x80;
    if (is_start && keep-- == 0) break;
    ++at;
  }
  text.resize(at);
  return width >= Width(dots) ? text + std::string(dots) : text;
}

std::string Bar(double share, bool is_utf8) {
  constexpr std::string_view kEighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const std::size_t steps = is_utf8 ? 8 : 1;
  const auto filled = static_cast<std::size_t>(share * static_cast<double>(kBarCells * steps));
  std::string bar;
  for (std::size_t i = 0; i < filled / steps; ++i) bar += is_utf8 ? "█" : "#";
  if (is_utf8) bar += kEighths[filled % steps];
  bar.append(kBarCells - Width(bar), is_utf8 ? ' ' : '.');
  return is_utf8 ? "▕" + bar + "▏" : "[" + bar + "]";
}

bool LocaleIsUtf8() {
  locale_t locale = newlocale(LC_CTYPE_MASK, "", nullptr);
  if (locale == nullptr) return false;
  const bool is_utf8 = std::string_view(nl_langinfo_l(CODESET, locale)) == "UTF-8";
  freelocale(locale);
  return is_utf8;
}

}  // namespace

ProgressOutput StandardError() {
  const char* term = std::getenv("TERM");
  ProgressOutput output;
  output.is_terminal = isatty(STDERR_FILENO) == 1 && term != nullptr && *term != '\0' &&
                       std::string_view(term) != "dumb";
  output.is_utf8 = LocaleIsUtf8();
  output.now_s = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  output.columns = [] {
    constexpr std::size_t kUsual = 80;
    winsize size = {};
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsual;
    return std::size_t{size.ws_col};
  };
  output.write = [](std::string_view text) {
    // Errors are ignored: a sweep does not depend on a reader of its progress.
    std::ignore = protocol::TryWriteAll(STDERR_FILENO, std::as_bytes(std::span(text)));
  };
  return output;
}

std::string DurationText(double seconds) {
  const double s = std::max(seconds, 0.0);
  if (s < 0.1) return fmt::format("{:.0f} ms", s * 1000);
  if (s < 9.95) return fmt::format("{:.1f} s", s);
  if (s < 89.5) return fmt::format("{:.0f} s", s);
  const double minutes = std::round(s / 60);
  if (minutes < 60) return fmt::format("{:.0f} min", minutes);
  if (minutes < 24 * 60)
    return fmt::format("{:.0f} h {:.0f} min", std::floor(minutes / 60), std::fmod(minutes, 60));
  const double hours = std::round(s / 3600);
  return fmt::format("{:.0f} d {:.0f} h", std::floor(hours / 24), std::fmod(hours, 24));
}

std::string ShareText(std::size_t ended, std::size_t total) {
  const std::size_t percent = total == 0 ? 100 : ended * 100 / total;
  const std::string all = std::to_string(total);
  return fmt::format("{:>{}}/{} {:>3} %", ended, all.size(), all, percent);
}

std::string LeftText(const ProgressState& state) {
  if (state.ended == state.total || !state.left_s) return {};
  // Whole seconds: a countdown in milliseconds only flickers.
  const double seconds = std::ceil(*state.left_s);
  return (seconds < 10 ? fmt::format("{:.0f} s", std::max(seconds, 1.0)) : DurationText(seconds)) +
         " left";
}

std::string ProgressBar::Text(const ProgressState& state, std::size_t columns) const {
  const double share =
      state.total == 0 ? 1 : static_cast<double>(state.ended) / static_cast<double>(state.total);
  std::string text = columns < kFewColumns ? "" : Bar(share, output_.is_utf8) + " ";
  text += ShareText(state.ended, state.total);
  if (const std::string left = LeftText(state); !left.empty()) text += "  " + left;
  if (state.bad > 0) text += fmt::format("  {} bad", state.bad);
  if (!state.detail.empty()) text += "  " + state.detail;
  // The last column stays free: a full line makes some terminals wrap.
  return Cut(std::move(text), columns > 0 ? columns - 1 : 0, output_.is_utf8);
}

void ProgressBar::Line(const std::string& text) {
  Clear();
  output_.write("cdb: " + text::Printable(text) + "\n");
}

void ProgressBar::Clear() {
  if (drawn_width_ == 0) return;
  // If the terminal has become narrower, the bar has wrapped; the cursor is in its last line.
  const std::size_t columns = std::max<std::size_t>(output_.columns(), 1);
  const std::size_t above = (drawn_width_ - 1) / columns;
  output_.write((above > 0 ? fmt::format("\x1b[{}A", above) : "") + "\r\x1b[J");
  drawn_width_ = 0;
}

void ProgressBar::Draw(bool is_urgent, const std::function<ProgressState()>& state) {
  const double now_s = output_.now_s();
  if (drawn_width_ > 0 && !is_urgent && now_s - drawn_s_ < kDrawInterval) return;
  const std::size_t columns = output_.columns();
  const std::string line = text::Printable(Text(state(), columns));
  const std::size_t above =
      drawn_width_ > 0 ? (drawn_width_ - 1) / std::max<std::size_t>(columns, 1) : 0;
  // Written in one piece, and the new line before the rest of the old one is cleared, so nothing
  // flickers.
  output_.write((above > 0 ? fmt::format("\x1b[{}A\r\x1b[J", above) : "\r") + line + "\x1b[K");
  drawn_width_ = Width(line);
  drawn_s_ = now_s;
}

void LogPace::Begin(std::size_t ended, double now_s) {
  line_ended_ = ended;
  line_s_ = now_s;
}

bool LogPace::IsDue(std::size_t ended, std::size_t total, double now_s) {
  const double silence = now_s - line_s_;
  const double step = static_cast<double>(ended - line_ended_);
  const bool is_due =
      total <= kSmallPlan || ended == total ||
      (silence >= kLineInterval &&
       (step >= kLineShare * static_cast<double>(total) || silence >= kLongSilence));
  if (is_due) Begin(ended, now_s);
  return is_due;
}

void TimeEstimate::Fit::Add(double objects, double cycle_s) {
  const double u = std::log(objects);
  const double v = std::log(cycle_s);
  n += 1;
  x += u;
  y += v;
  xx += u * u;
  xy += u * v;
}

double TimeEstimate::Fit::CycleSeconds(double objects) const {
  const double spread = n * xx - x * x;
  // Runs of similar size do not determine the slope, and no detector is steeper than testing all
  // pairs.
  constexpr double kMinSpread = 0.01;
  const double slope =
      spread > kMinSpread * n * n ? std::clamp((n * xy - x * y) / spread, 0.0, 2.0) : 1.0;
  return std::exp(y / n + slope * (std::log(objects) - x / n));
}

TimeEstimate::TimeEstimate(const std::vector<const plan::Run*>& to_do) {
  for (const plan::Run* run : to_do) ++kinds_[KindOf(*run)].left;
}

TimeEstimate::Kind TimeEstimate::KindOf(const plan::Run& run) {
  const plan::WorldSettings& world = run.scene.world;
  const bool is_limited = world.WordOr("timeout").empty();
  return {std::string(world.WordOr("detector")),
          std::max(1.0, static_cast<double>(run.scene.ObjectCount())),
          static_cast<double>(world.Count("cycles") + world.Count("warmup")),
          is_limited ? world.Real("timeout") : std::numeric_limits<double>::infinity()};
}

void TimeEstimate::Ended(const plan::Run& run, std::optional<double> wall_s) {
  const Kind kind = KindOf(run);
  Times& times = kinds_[kind];
  if (times.left > 0) --times.left;
  if (!wall_s) return;
  ++times.ended;
  times.sum_s += *wall_s;
  constexpr double kShortest = 1e-9;  // s; keeps its logarithm finite
  const double cycle_s = std::max(*wall_s, kShortest) / kind.cycles;
  fits_[kind.detector].Add(kind.objects, cycle_s);
  all_.Add(kind.objects, cycle_s);
}

std::optional<double> TimeEstimate::Predict(const Kind& kind, const Times& times) const {
  if (times.ended > 0) return times.sum_s / static_cast<double>(times.ended);
  if (all_.n == 0) return std::nullopt;
  const auto fit = fits_.find(kind.detector);
  const Fit& best = fit != fits_.end() ? fit->second : all_;
  return std::min(best.CycleSeconds(kind.objects) * kind.cycles, kind.timeout_s);
}

std::optional<double> TimeEstimate::Predict(const plan::Run& run) const {
  const Kind kind = KindOf(run);
  const auto times = kinds_.find(kind);
  return Predict(kind, times != kinds_.end() ? times->second : Times());
}

std::optional<double> TimeEstimate::Left() const {
  double sum = 0;
  for (const auto& [kind, times] : kinds_) {
    if (times.left == 0) continue;
    const auto one = Predict(kind, times);
    if (!one) return std::nullopt;
    sum += *one * static_cast<double>(times.left);
  }
  return sum;
}

}  // namespace cdb::schedule
