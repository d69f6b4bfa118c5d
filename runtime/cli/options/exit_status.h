// Exit status of a command.
#pragma once

#include <stdexcept>

namespace cdb::options {

/// The exit status of the program. Of two, the larger one is the worse.
enum class ExitStatus {
  kGood = 0,
  kScenarioError = 1,     ///< an error in the scenario
  kEnvironmentError = 2,  ///< environment or usage error
  kFailedRuns = 3,        ///< complete, but with failed runs
  kWorse = 4,  ///< `cdb compare` found something worse, or `cdb suite --against` something untrue
};

/// The exit status of a command that was stopped by `signal`.
constexpr ExitStatus StoppedBy(int signal) { return static_cast<ExitStatus>(128 + signal); }

/// Environment or usage error: printed on standard error, then exit status 2.
class CommandError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cdb::options
