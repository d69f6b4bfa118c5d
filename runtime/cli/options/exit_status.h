// How a command ends.
#pragma once

#include <stdexcept>

namespace cdb::options {

/// The exit status of the program; a larger one is the worse of two.
enum class ExitStatus {
  kGood = 0,
  kScenario = 1,  ///< an error in the scenario
  kWorld = 2,     ///< environment or usage error
  kRuns = 3,      ///< complete, but with failed runs
  kWorse = 4,  ///< `cdb compare` found something worse, or `cdb suite --against` something untrue
};

/// The status of a command that `signal` stopped.
constexpr ExitStatus StoppedBy(int signal) { return static_cast<ExitStatus>(128 + signal); }

/// Environment or usage error: printed on standard error, then exit status 2.
class CommandError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cdb::options
