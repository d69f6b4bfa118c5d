// Random benchmarks made from the schema table, for property tests.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace cdb::tests {

/// A benchmark as lines of settings, with what it should come to.
struct RandomScenario {
  std::vector<std::string> settings;  ///< `objects.size sweep(…)`: any order means the same scenes
  std::size_t points = 1;             ///< product of the axes
  std::string Text() const;
};

/// The one file, beside the scenario, that its models come from.
inline constexpr const char* kModelFile = "rock.obj";

/// Valid by construction: each parameter at most once, a constant, a distribution or a sweep within
/// its domain.
RandomScenario MakeRandomScenario(std::mt19937_64& random);

}  // namespace cdb::tests
