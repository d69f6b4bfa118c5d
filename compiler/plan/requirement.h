// Conditions on the figures of a result: `require p99(step) < 4 ms`. The compiler reads them from a
// scenario, plans and results hold them, and runtime/figures/requirements.h judges them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cdb::plan {

/// Statistics over the cycles of a run, in the order of figures::CycleStatistic. The last is for
/// times only.
inline constexpr std::string_view kCycleStatistics[] = {"mean", "median", "p5",  "p95",
                                                        "p99",  "min",    "max", "worst"};
/// The value in the last cycle: of a series, not of a time.
inline constexpr std::string_view kFinal = "final";

/// The least number of repeats that tell how well a measured figure is known.
inline constexpr std::uint64_t kLeastRepeats = 5;

enum class FigureKind {
  kVerdict,  ///< `verdict`: the worst of the repeats
  kTime,     ///< `p99(step)`: a statistic of the times of a phase
  kSeries,   ///< `max(escaped)`: a statistic of a series with one value in each cycle
  kError,    ///< `error(energy)`: a row of schema::Errors()
  kScalar,   ///< `peak_rss`: a row of schema::kRunScalars
};

/// A figure of a point of the grid.
struct Figure {
  FigureKind kind = FigureKind::kVerdict;
  std::string name = "verdict";  ///< of the phase, the series, the error or the scalar
  std::string statistic = {};    ///< of a time or a series

  /// `p99(step)`, `error(energy)`, `verdict`.
  std::string Text() const;
  /// The unit of its values, as in results: `ns`, `J`, `bytes`; empty if it has none.
  std::string_view Unit() const;
  /// True if its value is measured with noise, so that only repeats tell how well it is known.
  bool IsMeasured() const;
  bool operator==(const Figure&) const = default;
};

/// The statistics that a figure of this kind may have; empty for those without.
std::span<const std::string_view> StatisticsOf(FigureKind kind);

/// A figure from its text; nullopt if there is none.
std::optional<Figure> FindFigure(std::string_view text);

enum class Comparison : std::uint8_t { kEqual, kNotEqual, kLess, kAtMost, kGreater, kAtLeast };
/// `==`, `!=`, `<`, `<=`, `>`, `>=`.
std::string_view ComparisonText(Comparison comparison);
std::optional<Comparison> FindComparison(std::string_view text);
/// `<` for `>`: the comparison of the two sides in the other order.
Comparison Reversed(Comparison comparison);
bool Holds(double value, Comparison comparison, double limit);

/// A comparison of a figure with a value.
struct Requirement {
  std::string text;  ///< as written: `p99(step) < 4 ms`
  Figure figure;
  Comparison comparison = Comparison::kLess;
  double limit = 0;  ///< in the unit of the figure; of a verdict, its number in schema::Verdict

  /// The same condition, however it is written.
  bool IsSame(const Requirement& other) const {
    return figure == other.figure && comparison == other.comparison && limit == other.limit;
  }
  bool operator==(const Requirement&) const = default;
};

}  // namespace cdb::plan
