// The races of a scenario (`race( )`): which runs they need next, and how each configuration did,
// for each point of the other axes. Throws StoreError. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/points.h"
#include "runtime/figures/races/race.h"
#include "runtime/results/store.h"

namespace cdb::races {

using figures::Cell;
using figures::Point;

/// The race at one point of the other axes.
struct PlacedRace {
  Point place;                ///< on the axes without a race
  std::vector<Point> racers;  ///< on all axes, in grid order; those that have runs
  Race race;                  ///< by positions in `racers`

  /// Those with this outcome: the leader first, then by their ratios.
  std::vector<std::size_t> With(Outcome outcome) const;
};

/// The axes without a race.
std::vector<std::size_t> PlaceAxes(const std::vector<plan::Axis>& axes);

/// All of the file, in grid order; empty if its scenario has no race. Throws StoreError.
std::vector<PlacedRace> RunRaces(const results::ResultFile& file);

/// The runs to be executed next, in grid order; empty once all races have ended.
std::vector<Cell> NextCells(const std::vector<PlacedRace>& races);

/// What a merged file stores.
results::StoredAnswers::Races RacesToStore(const results::ResultFile& file,
                                           const std::vector<PlacedRace>& races);

/// The least number of runs of a plan with races: if all end at the first look. `head`: the plan
/// without its runs; `runs`: their number.
std::uint64_t LeastRuns(const plan::Plan& head, std::uint64_t runs);

/// `dbvt`, `(detector dbvt, threads 4)`: a racer by its values on the axes with
/// a race.
std::string RacerText(const results::ResultFile& file, const Point& racer);
/// `won`, `not_known`: as in results.
std::string_view OutcomeName(Outcome outcome);
/// `won`, `slower than dbvt`, `cannot be told apart from dbvt`.
std::string OutcomeText(const results::ResultFile& file, const PlacedRace& race, std::size_t racer);
/// `1.31 (1.22 .. 1.44)`; empty where there is none, and of the leader.
std::string RatioText(const PlacedRace& race, std::size_t racer);
/// Who is the fastest where. `races`: not empty.
figures::Conclusion ConcludeRaces(const results::ResultFile& file,
                                  const std::vector<PlacedRace>& races);

}  // namespace cdb::races
