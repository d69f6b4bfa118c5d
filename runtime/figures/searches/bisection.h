// A search for the first of many ordered values at which a condition holds, if it holds from some
// value on: which values to run next, and what is known of the boundary. Pure functions of what has
// been run, so that a search resumes wherever it was stopped. Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace cdb::searches {

/// What is known of the condition at one value.
struct Probe {
  enum class State : std::int8_t { kNotRun, kNo, kYes };
  State state = State::kNotRun;
  /// False where the figure is too noisy to tell, or where a run has none.
  bool is_sure = false;
};

/// `flag_values` of the array `boundary/outcome`, in this order.
enum class Outcome : std::int8_t {
  kNotKnown,   ///< runs are missing
  kBetween,    ///< between two neighbouring values
  kAtFirst,    ///< the condition holds at the first value already
  kNowhere,    ///< it holds at no value that was run, up to the last
  kUncertain,  ///< one of these three, but the runs from which it follows do not tell
};

struct Bracket {
  Outcome outcome = Outcome::kNotKnown;
  std::size_t last_no = 0, first_yes = 0;  ///< if HasNeighbours(): neighbouring values
  bool starts_with_yes = false;            ///< the condition holds, or may hold, at the first value
  /// The nearest values that surely lie before and past the boundary; none if no run is sure.
  std::optional<std::size_t> sure_no = {}, sure_yes = {};
  std::size_t changes = 0;  ///< from a value that was run to the next; more than 1: not monotone
  std::size_t probes = 0;   ///< values that were run
  /// Values to be run next, ascending; empty once the search has ended.
  std::vector<std::size_t> next = {};

  bool HasNeighbours() const { return first_yes > last_no; }
  bool IsMonotone() const { return changes <= 1; }
};

/// `line`: the values in the order of the search, at least one. It first asks for both ends and
/// three values between them, a quarter of the way each, so that a condition that changes several
/// times is noticed; then it halves the first interval in which the condition begins to hold, until
/// its ends are neighbours; then, if runs there do not tell, the intervals to the nearest ones that
/// do. A line of n values takes about log2(n) + 3 runs, at most twice as many where runs do not
/// tell.
Bracket Locate(const std::vector<Probe>& line);

/// The values that a search among `values` runs if every run tells, and the boundary is between
/// two.
std::size_t UsualProbes(std::size_t values);

}  // namespace cdb::searches
