// Names of sets of points, by the values that tell them apart; and where the states of points
// change along an axis of numbers, in sentences: verdicts, and whether a configuration stays within
// a budget.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "runtime/figures/points.h"
#include "runtime/results/store.h"

namespace cdb::figures {

/// `mu 0.4 .. 1`, `contact bullet`, `hz 240 and iterations 100`: the values, on one or two of
/// `axes`, of the points `some` and of no other of `all`. Empty if there are none, or many.
std::string ValuesOfOnly(const results::ResultFile& file, const std::vector<std::size_t>& axes,
                         const std::set<Point>& some, const std::set<Point>& all);
/// `values of mu`, `combinations of mu and iterations`: points on several axes, as a noun.
std::string PointsNoun(const results::ResultFile& file, const std::vector<std::size_t>& axes);
/// The same points by their values, or else one by one if they are few, or by their number: `3 of
/// the 26 combinations of mu and iterations`.
std::string PointsText(const results::ResultFile& file, const std::vector<std::size_t>& axes,
                       const std::set<Point>& some, const std::set<Point>& all);

struct BoundaryWords {
  std::string good;  ///< the state whose limits are given if there are many different lines
  /// A state that holds for all values of the axis, if it is not `state everywhere`.
  std::map<std::string, std::string> everywhere = {};
  std::size_t most_lines = 2;  ///< limit of different lines that are given in full
};

/// ` Along quantity, dbvt: stable up to 90, tunnelled from 120.`: a sentence for the axis of
/// numbers along which the states are explained in the fewest words; or, if the states are those of
/// values of other axes, ` That is: drifting with contact bullet and stable with contact faithful.`
/// `states`: by points on all axes. Empty if neither explains them. Throws StoreError.
std::string BoundaryText(const results::ResultFile& file,
                         const std::map<Point, std::string>& states, const BoundaryWords& words);

}  // namespace cdb::figures
