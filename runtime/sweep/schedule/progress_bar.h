// A progress bar on a terminal, with lines above it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace cdb::schedule {

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

}  // namespace cdb::schedule
