// Where the times of the cycles of a point become steady: after how many cycles the scene, the
// caches and the processor have settled, so that a `warmup` need not be guessed.
//
// The times of the cycles, each the median over the repeats, are pooled into at most kMostParts
// parts of equal length, each by its median, and the changes of their level are found as those over
// commits are (history/change_points.h): steps and drifts. The transient ends with the last change,
// if the rest is at least half of the cycles; otherwise there is no steady state.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/model.h"

namespace cdb::steady {

/// The parts into which cycles are pooled; fewer cycles than kLeastCycles are too few.
inline constexpr std::size_t kMostParts = 60, kLeastCycles = 30;
/// Changes of the level by less than this are none.
inline constexpr double kLeastChange = 0.03;

enum class State {
  kTooShort,
  kFromStart,    ///< there is no transient
  kAfterWarmup,  ///< from a cycle on
  kNever,        ///< the times change in the second half
};

struct SteadyState {
  State state = State::kTooShort;
  /// The cycles of the transient, to a whole part.
  std::size_t warmup = 0;
  /// The mean time of all cycles, and of those after the transient, ns; NaN without.
  double all = figures::kNone, rest = figures::kNone;
};

/// `cycles`: the time of each cycle, all finite and above 0.
SteadyState FindSteadyState(std::span<const double> cycles);

inline constexpr std::size_t kMostPoints = 1000;

struct PointState {
  const figures::MeasuredPoint* point;
  SteadyState steady;
};
/// Of the step, at each sound point; none for more than kMostPoints. `model` must outlive them.
/// Throws StoreError.
std::vector<PointState> FindSteadyStates(const figures::Model& model);

/// `from_start`, `after_warmup`: as in documents.
std::string_view StateName(State state);
/// Where the step is steady, in a sentence, with advice; empty if every run is too short to tell.
std::string SteadyText(const std::vector<PointState>& states);

}  // namespace cdb::steady
