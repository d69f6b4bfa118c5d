// What each subcommand of `cdb` does, once its arguments are parsed.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cdb::cli {

/// Exit statuses of every command.
enum ExitStatus {
  kExitGood = 0,
  kExitScenario = 1,  ///< the scenario is wrong
  kExitWorld = 2,     ///< the world refused, or the command line is wrong
  kExitRuns = 3,      ///< complete, but a run ended badly
};

/// The world refused: said on standard error, exit status 2.
class CommandError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct PlanArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::string out;                   ///< empty: a table on standard output; `-`: YAML there
  bool why = false;                  ///< what each run leaves out, in place of the table
  std::string only;                  ///< the id of the one run that `why` is about, or empty
  std::vector<std::string> plugins;  ///< shared libraries with detectors
};

struct RunArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::string out;  ///< empty: `<benchmark>.h5` in the current folder
  std::uint64_t jobs = 1;
  std::string shard;                 ///< `K/N`, or empty
  std::string only;                  ///< the id of one run, or empty
  std::vector<std::string> plugins;  ///< shared libraries with detectors
  bool fresh = false;
  bool quiet = false;
};

struct TraceArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::string
      out;  ///< a file for one point, a folder for several; empty: named after the benchmark
  std::vector<std::string> plugins;  ///< shared libraries with detectors
  bool fresh = false;
  bool quiet = false;
};

struct ShowArguments {
  std::string file;
  std::vector<std::string> by;  ///< axes that make the rows
  std::string error;            ///< an array of /accuracy to set against run time; empty: a summary
  std::vector<std::string> each;  ///< with `error`: axes with a table for each value
};

struct StabilityArguments {
  std::vector<std::string> scenes;  ///< of the suite; empty: all
  std::vector<std::string> precisions = {"single", "double"}, detectors = {"dbvt"};
  std::string out = "stability";  ///< folder of the results
  std::uint64_t jobs = 1;
  bool fresh = false;
  bool quiet = false;
};

struct VerifyArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::vector<std::string> detectors;   ///< empty: the file's own; `all`: every one that can
  std::optional<std::uint64_t> cycles;  ///< nullopt: the file's own
  std::vector<std::string> plugins;     ///< shared libraries with detectors
  std::string out;                      ///< folder of the results; empty: the current one
  std::uint64_t jobs = 1;
  bool fresh = false;
  bool quiet = false;
};

int CheckCommand(const std::vector<std::string>& files, const std::vector<std::string>& plugins);
int PlanCommand(const PlanArguments& arguments);
int RunCommand(const RunArguments& arguments);
/// Runs each point once for its boxes and poses, and writes a trace of each; goes on where it
/// stopped.
int TraceCommand(const TraceArguments& arguments);
int ShowCommand(const ShowArguments& arguments);
/// Runs the suite, going on where it stopped, and prints the map. What ends badly there is what it
/// is for: exit status 0.
int StabilityCommand(const StabilityArguments& arguments);
/// Holds what detectors find in each cycle against exact pairs and contacts, and prints a table.
/// Exit status 3 where a pair was missed or a run did not end well.
int VerifyCommand(const VerifyArguments& arguments);
int MergeCommand(const std::string& out, const std::vector<std::string>& shards);
/// `check`: change nothing, exit status 1 where something would change.
int FormatCommand(const std::vector<std::string>& files, bool check);
/// A topic or a parameter; empty for the list of them.
int DocCommand(const std::string& name);
/// `objects`, `detectors`, `layouts`, `scenarios`, or empty for all.
int ListCommand(const std::string& what);

}  // namespace cdb::cli
