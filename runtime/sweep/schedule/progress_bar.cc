#include "runtime/sweep/schedule/progress_bar.h"

#include <fmt/format.h>
#include <langinfo.h>
#include <locale.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <span>
#include <tuple>

#include "dsl/text/utf8.h"
#include "runtime/protocol/file_descriptor_io.h"

namespace cdb::schedule {
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

}  // namespace cdb::schedule
