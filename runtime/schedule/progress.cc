#include "runtime/schedule/progress.h"

#include <fmt/format.h>
#include <langinfo.h>
#include <locale.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "dsl/utf8.h"
#include "runtime/measure/file_descriptor_io.h"

namespace cdb::schedule {
namespace {

constexpr double kDrawInterval = 0.1;  // s
constexpr std::size_t kBarCells = 20;
constexpr std::size_t kFewColumns = 50;  // columns; below, the bar gives way to the figures

constexpr std::size_t kSmallPlan = 40;  // runs, each worth a line of a log
constexpr double kLineInterval = 5;     // s
constexpr double kLongSilence = 60;     // s
constexpr double kLineShare = 0.05;

/// Characters, taken as columns: names and numbers are ASCII, our own signs one column wide.
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

std::string Ended(const store::RunResult& result, double wall_s) {
  if (result.outcome().IsGood()) return "done in " + DurationText(wall_s);
  if (result.status == store::Status::kDone)
    return fmt::format("{} from cycle {} on: its timings do not count",
                       measure::VerdictName(result.judgement.verdict),
                       result.judgement.first_bad_cycle);
  return fmt::format("{}: {}",
                     result.status == store::Status::kTimedOut ? std::string_view("timed out")
                                                               : store::StatusName(result.status),
                     result.message);
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
    // A sweep does not end because nobody reads its progress.
    std::ignore = measure::TryWriteAll(STDERR_FILENO, std::as_bytes(std::span(text)));
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

Progress::Progress(ProgressOutput output) : output_(std::move(output)) {}

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
  line_ended_ = ended_;
  line_s_ = output_.now_s();
  drawn_s_ = line_s_ - kDrawInterval;
  settling_s_ = line_s_ - kLongSilence;
  if (output_.is_terminal && part_.empty()) return Draw(true);
  std::string text =
      fmt::format("{}{}: {} run{}", plan.benchmark, part_, total_, total_ == 1 ? "" : "s");
  if (ended_ > 0) text += fmt::format(", {} of them there already", ended_);
  if (jobs > 1) text += fmt::format(", {} at a time", jobs);
  Line(text);
}

void Progress::RunStarted(const plan::Run& run) {
  running_.push_back({&run, output_.now_s()});
  if (output_.is_terminal) Draw(false);
}

void Progress::RunSettles(const plan::Run& run, const std::string& how_far) {
  for (Running& one : running_)
    if (one.run == &run) one.settling = how_far;
  if (output_.is_terminal) Draw(false);
}

/// In a log, where nothing else is said until the run ends.
void Progress::TellOfSettling() {
  const double now_s = output_.now_s();
  for (const Running& one : running_) {
    const double since_s = std::max(settling_s_ + kLongSilence, one.since_s + kLineInterval);
    if (one.settling.empty() || now_s < since_s) continue;
    Line(fmt::format("{}  {}: its pile settles, {}", Share(), Name(*one.run), one.settling));
    settling_s_ = now_s;
  }
}

void Progress::RunEnded(const plan::Run& run, const store::RunResult& result, double wall_s) {
  std::erase_if(running_, [&run](const Running& one) { return one.run == &run; });
  const bool is_telling =
      result.status == store::Status::kDone || result.status == store::Status::kTimedOut;
  estimate_->Ended(run, is_telling ? std::optional(wall_s) : std::nullopt);
  Advance(result.outcome());
  const bool is_bad = !result.outcome().IsGood();
  if (output_.is_terminal) {
    if (is_bad) Line(fmt::format("{}: {}", Name(run), Ended(result, wall_s)));
    return Draw(ended_ == total_);
  }
  const double now_s = output_.now_s();
  const double silence = now_s - line_s_;
  const double step = static_cast<double>(ended_ - line_ended_);
  const bool is_due =
      total_ <= kSmallPlan || ended_ == total_ ||
      (silence >= kLineInterval &&
       (step >= kLineShare * static_cast<double>(total_) || silence >= kLongSilence));
  if (!is_due && !is_bad) return;
  std::string text = fmt::format("{}  {}: {}", Share(), Name(run), Ended(result, wall_s));
  if (is_due) {
    line_s_ = now_s;
    line_ended_ = ended_;
    if (!is_bad && total_ > kSmallPlan && ended_ < total_) {
      if (const std::string left = TimeLeft(); !left.empty()) text += "; " + left;
    }
  }
  Line(text);
}

void Progress::Repeat(const plan::Plan&, const std::vector<const plan::Run*>& runs,
                      const std::string& components) {
  Line(fmt::format("{} run{} once more, now with {}: runs that they are compared with keep it",
                   runs.size(), runs.size() == 1 ? "" : "s", components));
  estimate_.emplace(runs);
  total_ += runs.size();
}

void Progress::RunFound(const plan::Run& run, const store::Outcome& outcome) {
  estimate_->Ended(run, std::nullopt);
  Advance(outcome);
  if (output_.is_terminal) Draw(false);
}

void Progress::Warn(const std::string& text) {
  Line("warning: " + text);
  if (output_.is_terminal && plan_ != nullptr) Draw(true);
}

void Progress::Tick() {
  if (output_.is_terminal) return Draw(false);
  TellOfSettling();
}

void Progress::End() { Clear(); }

void Progress::Advance(const store::Outcome& outcome) {
  ++ended_;
  bad_ += outcome.IsGood() ? 0 : 1;
}

std::string Progress::Name(const plan::Run& run) const { return plan::Describe(*plan_, run); }

std::string Progress::Share() const {
  const std::size_t percent = total_ == 0 ? 100 : ended_ * 100 / total_;
  const std::string total = std::to_string(total_);
  return fmt::format("{:>{}}/{} {:>3} %", ended_, total.size(), total, percent);
}

std::string Progress::TimeLeft() const {
  if (ended_ == total_) return {};
  auto left = estimate_->Left();
  if (!left) return {};
  const double now_s = output_.now_s();
  for (const Running& one : running_)
    *left -= std::min(now_s - one.since_s, estimate_->Predict(*one.run).value_or(0));
  const std::size_t at_a_time = std::min(jobs_, total_ - ended_);
  // Whole seconds: a bar that counts down milliseconds only flickers.
  const double seconds =
      std::ceil(*left / static_cast<double>(std::max<std::size_t>(at_a_time, 1)));
  return (seconds < 10 ? fmt::format("{:.0f} s", std::max(seconds, 1.0)) : DurationText(seconds)) +
         " left";
}

std::string Progress::BarLine(std::size_t columns) const {
  const double share = total_ == 0 ? 1 : static_cast<double>(ended_) / static_cast<double>(total_);
  std::string text = columns < kFewColumns ? "" : Bar(share, output_.is_utf8) + " ";
  text += Share();
  if (const std::string left = TimeLeft(); !left.empty()) text += "  " + left;
  if (bad_ > 0) text += fmt::format("  {} bad", bad_);
  if (!running_.empty()) {
    const Running& last = running_.back();
    if (!last.settling.empty()) text += "  settling, " + last.settling + ":";
    text += "  " + Name(*last.run);
  }
  // The last column stays free: a full line makes some terminals wrap.
  return Cut(std::move(text), columns > 0 ? columns - 1 : 0, output_.is_utf8);
}

void Progress::Line(const std::string& text) {
  Clear();
  output_.write("cdb: " + dsl::Printable(text) + "\n");
}

void Progress::Clear() {
  if (drawn_width_ == 0) return;
  // A terminal made narrower since has wrapped the bar; we stand in the last of its lines.
  const std::size_t columns = std::max<std::size_t>(output_.columns(), 1);
  const std::size_t above = (drawn_width_ - 1) / columns;
  output_.write((above > 0 ? fmt::format("\x1b[{}A", above) : "") + "\r\x1b[J");
  drawn_width_ = 0;
}

void Progress::Draw(bool is_urgent) {
  const double now_s = output_.now_s();
  if (drawn_width_ > 0 && !is_urgent && now_s - drawn_s_ < kDrawInterval) return;
  const std::size_t columns = output_.columns();
  const std::string line = dsl::Printable(BarLine(columns));
  const std::size_t above =
      drawn_width_ > 0 ? (drawn_width_ - 1) / std::max<std::size_t>(columns, 1) : 0;
  // In one piece, the new line before the rest of the old is cleared: nothing flickers.
  output_.write((above > 0 ? fmt::format("\x1b[{}A\r\x1b[J", above) : "\r") + line + "\x1b[K");
  drawn_width_ = Width(line);
  drawn_s_ = now_s;
}

}  // namespace cdb::schedule
