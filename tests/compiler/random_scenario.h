// Random benchmarks generated from the schema table, for property tests.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace cdb::tests {

/// A benchmark as lines of settings, with its expected number of points.
struct RandomScenario {
  std::vector<std::string> settings;  ///< `objects.size sweep(…)`; their order does not matter
  std::size_t points = 1;             ///< product of the axes
  std::string Text() const;
};

/// The only files, beside the scenario, that its models and height fields come from.
inline constexpr const char *kModelFile = "rock.obj", *kHeightsFile = "hill.csv";

/// Generates a valid benchmark: each parameter at most once, as a constant, a distribution or a
/// sweep within its domain.
RandomScenario MakeRandomScenario(std::mt19937_64& random);

}  // namespace cdb::tests
