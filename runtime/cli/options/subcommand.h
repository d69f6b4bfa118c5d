// A subcommand: its row and its options. Commands do not include CLI11, as its headers take long to
// compile.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::options {

// Exit status of a command.

/// The exit status of the program. Of two, the larger one is the worse.
enum class ExitStatus {
  kGood = 0,
  kScenarioError = 1,     ///< an error in the scenario
  kEnvironmentError = 2,  ///< environment or usage error
  kFailedRuns = 3,        ///< complete, but with failed runs
  /// `cdb compare` or `cdb history` found something worse, or `cdb suite --against` something
  /// untrue
  kWorse = 4,
  kOtherScenes = 5,  ///< `cdb compare` did not compare a benchmark, whose scenes differ
  kNotMet = 5,       ///< `cdb run` or `cdb show`: a requirement of the scenario is not met
};

/// The exit status of results with so many bad runs, and points that do not meet a requirement.
constexpr ExitStatus StatusOf(std::size_t bad, std::size_t not_met) {
  return not_met > 0 ? ExitStatus::kNotMet : bad > 0 ? ExitStatus::kFailedRuns : ExitStatus::kGood;
}

/// The exit status of a command that was stopped by `signal`.
constexpr ExitStatus StoppedBy(int signal) { return static_cast<ExitStatus>(128 + signal); }

/// Environment or usage error: printed on standard error, then exit status 2.
class CommandError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The end of a message about an unknown word: "did you mean 'run'?", or `otherwise` if the word is
/// like none of those that are known.
std::string Suggestion(std::string_view word, const std::vector<std::string_view>& known,
                       std::string otherwise);

}  // namespace cdb::options

namespace CLI {
class App;
}

namespace cdb::options {

class Subcommand;

/// A row of THE table of commands (runtime/cli/commands.h).
struct Command {
  std::string name;
  std::string help;                          ///< one line
  void (*declare)(Subcommand& command);      ///< its arguments, options and action
  std::vector<std::string> (*words)() = {};  ///< that its argument accepts; null if it takes files
};

/// `--help` lists options in the order of their declaration. Each is parsed into a variable, which
/// must live until the command has run. Names are those of CLI11: `-o,--out`, or `FILE` for a
/// positional argument.
class Subcommand {
 public:
  Subcommand(CLI::App& program, const Command& row, ExitStatus& status);

  void Required(const std::string& name, std::string& value, const std::string& help);
  void Required(const std::string& name, std::vector<std::string>& values, const std::string& help);
  void Optional(const std::string& name, std::string& value, const std::string& help);
  void Optional(const std::string& name, std::vector<std::string>& values, const std::string& help);
  /// `a,b,c`
  void List(const std::string& name, std::vector<std::string>& values, const std::string& help);
  /// An option that is given once for each value.
  void Repeated(const std::string& name, std::vector<std::string>& values, const std::string& help);
  /// `a,b,c` in one argument; the arguments after it may be files. May be given several times.
  void ShortList(const std::string& name, std::vector<std::string>& values,
                 const std::string& help);
  /// A whole number, from `least` to 2147483647.
  void Count(const std::string& name, std::uint64_t& value, const std::string& help, int least = 1);
  void Flag(const std::string& name, bool& value, const std::string& help);

  // Options of several commands.
  void Benchmark(std::optional<std::string>& benchmark);
  void Out(std::string& out, const std::string& help);
  void Jobs(std::uint64_t& jobs, const std::string& help);
  void Fresh(bool& fresh, const std::string& help);
  void Quiet(bool& quiet, const std::string& help);
  void Plugins(std::vector<std::string>& plugins);
  void Set(std::vector<std::string>& settings);
  void Baseline(std::string& baseline);
  void Sound(bool& only_sound);
  void Retry(std::vector<std::string>& retry, const std::string& files);
  void RetryNoisy(std::uint64_t& retries);
  void Cycles(std::optional<std::uint64_t>& cycles, const std::string& help);

  /// Runs once the command line is parsed, and sets the status, which must live until then.
  void Action(std::function<ExitStatus()> action);
  /// The whole command line; lives until the command has run.
  const CLI::App& program() const { return program_; }

 private:
  CLI::App& program_;
  CLI::App& command_;
  ExitStatus& status_;
};

}  // namespace cdb::options
