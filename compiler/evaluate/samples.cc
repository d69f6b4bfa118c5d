#include "compiler/evaluate/samples.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>

#include "compiler/plan/plan.h"

namespace cdb::evaluate {
namespace {

constexpr int kBits = 32;

/// A primitive polynomial, and the first direction numbers.
struct Polynomial {
  unsigned degree, coefficients;
  std::array<std::uint32_t, 7> first;
};
constexpr Polynomial kPolynomials[kMostDimensions - 1] = {
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
    {5, 7, {1, 1, 7, 11, 19}},
    {5, 11, {1, 1, 5, 1, 1}},
    {5, 13, {1, 1, 1, 3, 11}},
    {5, 14, {1, 3, 5, 5, 31}},
    {6, 1, {1, 3, 3, 9, 7, 49}},
    {6, 13, {1, 1, 1, 15, 21, 21}},
    {6, 16, {1, 3, 1, 13, 27, 49}},
    {6, 19, {1, 1, 1, 15, 7, 5}},
    {6, 22, {1, 3, 1, 15, 13, 25}},
    {6, 25, {1, 1, 5, 5, 19, 61}},
    {7, 1, {1, 3, 7, 11, 23, 15, 103}},
};

/// By bits of the index, the lowest first.
std::array<std::uint32_t, kBits> Directions(std::size_t dimension) {
  std::array<std::uint32_t, kBits> directions = {};
  for (int i = 0; i < kBits; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int shift = kBits - 1 - i;
    if (dimension == 0) {
      directions[at] = std::uint32_t{1} << shift;
      continue;
    }
    const Polynomial& polynomial = kPolynomials[dimension - 1];
    const unsigned s = polynomial.degree;
    if (at < s) {
      directions[at] = polynomial.first[at] << shift;
      continue;
    }
    std::uint32_t number = directions[at - s] ^ (directions[at - s] >> s);
    for (unsigned k = 1; k < s; ++k)
      if ((polynomial.coefficients >> (s - 1 - k)) & 1) number ^= directions[at - k];
    directions[at] = number;
  }
  return directions;
}

std::uint32_t Reversed(std::uint32_t bits) {
  std::uint32_t reversed = 0;
  for (int i = 0; i < kBits; ++i, bits >>= 1) reversed = reversed << 1 | (bits & 1);
  return reversed;
}

/// Flips each bit depending on those above it.
std::uint32_t Scrambled(std::uint32_t number, std::uint32_t seed) {
  std::uint32_t bits = Reversed(number);
  bits ^= bits * 0x3d20adeaU;
  bits += seed;
  bits *= (seed >> 16) | 1U;
  bits ^= bits * 0x05526c56U;
  bits ^= bits * 0x53a22864U;
  return Reversed(bits);
}

double MiddleOf(std::uint32_t number) { return (static_cast<double>(number) + 0.5) * 0x1p-32; }

}  // namespace

std::vector<double> SobolCoordinates(std::size_t dimension, std::size_t count) {
  const auto directions = Directions(dimension);
  const auto seed = static_cast<std::uint32_t>(plan::StreamSeed(dimension, "sobol"));
  std::vector<double> coordinates;
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; coordinates.size() < count; ++i) {
    // In the order of Antonov and Saleev's Gray code.
    if (i > 0) number ^= directions[static_cast<std::size_t>(std::countr_zero(i))];
    coordinates.push_back(MiddleOf(Scrambled(number, seed)));
  }
  return coordinates;
}

std::vector<double> LatinCoordinates(std::size_t dimension, std::size_t count) {
  const std::string stream = fmt::format("latin {} {}", dimension, count);
  std::uint64_t drawn = 0;
  const auto draw = [&] { return plan::StreamSeed(drawn++, stream); };
  std::vector<std::size_t> parts(count);
  std::iota(parts.begin(), parts.end(), std::size_t{0});
  for (std::size_t i = count; i > 1; --i) std::swap(parts[i - 1], parts[draw() % i]);
  std::vector<double> coordinates;
  for (const std::size_t part : parts)
    coordinates.push_back(
        (static_cast<double>(part) + MiddleOf(static_cast<std::uint32_t>(draw() >> 32))) /
        static_cast<double>(count));
  return coordinates;
}

}  // namespace cdb::evaluate
