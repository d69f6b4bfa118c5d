// Points that fill the unit cube of several parameters evenly: one coordinate of each at a time, in
// the order of the points. The same on every machine. Threads: any.
#pragma once

#include <cstddef>
#include <vector>

namespace cdb::evaluate {

/// Of the cube.
inline constexpr std::size_t kMostDimensions = 20;

/// Those of the first `count` points of Sobol's sequence in dimension 0 to kMostDimensions - 1,
/// between 0 and 1. More points keep the first ones, and 2^k of them have one in each 2^k-th part
/// of every dimension. Source: S. Joe & F. Y. Kuo, Constructing Sobol sequences with better
/// two-dimensional projections, 2008, whose direction numbers these are; scrambled as by A. B.
/// Owen, 1998, by a hash (B. Burley, Practical hash-based Owen scrambling, 2020; N. Vegdahl, 2021).
std::vector<double> SobolCoordinates(std::size_t dimension, std::size_t count);

/// Those of a Latin hypercube: in each dimension, one point in each of `count` equal parts, at a
/// random place of it, in random order. Another count has other points. Source: McKay, Beckman &
/// Conover, 1979.
std::vector<double> LatinCoordinates(std::size_t dimension, std::size_t count);

}  // namespace cdb::evaluate
