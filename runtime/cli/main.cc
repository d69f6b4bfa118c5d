// The command line of cdb.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <exception>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsl/diagnostics.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/options/pose_files.h"
#include "runtime/terminal/console.h"

namespace {

using cdb::options::CommandError;
using cdb::options::ExitStatus;

/// Commands of other programs, with ours.
constexpr std::pair<std::string_view, std::string_view> kOtherCommands[] = {
    {"plot", "report"}, {"graph", "report"}, {"bench", "run"},    {"benchmark", "run"},
    {"exec", "run"},    {"start", "run"},    {"sweep", "run"},    {"validate", "check"},
    {"lint", "check"},  {"test", "verify"},  {"diff", "compare"}, {"open", "view"},
    {"render", "view"}, {"edit", "view"},    {"inspect", "show"}, {"info", "show"},
    {"print", "show"},  {"csv", "show"},     {"docs", "doc"},     {"man", "doc"},
    {"ls", "list"},     {"expand", "plan"},  {"compile", "plan"}, {"format", "fmt"},
};

/// Throws CommandError if there is no command `name`.
void CheckCommandName(std::string_view name) {
  std::vector<std::string_view> names;
  for (const cdb::options::Command& command : cdb::cli::Commands()) names.push_back(command.name);
  if (std::ranges::find(names, name) != names.end()) return;
  const auto* other =
      std::ranges::find(kOtherCommands, name, [](const auto& pair) { return pair.first; });
  names.insert(names.end(), {"help", "version"});
  throw CommandError(
      fmt::format("there is no command '{}'; {}", name,
                  other != std::end(kOtherCommands)
                      ? fmt::format("did you mean '{}'?", other->second)
                      : cdb::options::Suggestion(name, names, "`cdb --help` lists them")));
}

/// The arguments with `help`, `help COMMAND` and `version` as the options of these names.
std::vector<std::string> WithOptionsForWords(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty()) return arguments;
  if (arguments[0] == "version") arguments[0] = "--version";
  if (arguments[0] == "help") {
    arguments.erase(arguments.begin());
    arguments.insert(arguments.begin() + (arguments.empty() ? 0 : 1), "--help");
  }
  return arguments;
}

/// The reason why `command` does not take the arguments that are left over.
std::string WhyNotTaken(const CLI::App& command) {
  const std::vector<std::string> rest = command.remaining();
  const auto option = std::ranges::find_if(rest, [](const auto& each) { return each[0] == '-'; });
  const std::string name = command.get_name();
  if (option == rest.end())
    return fmt::format("cdb {} takes no further argument '{}'; `cdb {} --help` lists its options\n",
                       name, rest.empty() ? "" : rest.front(), name);
  const std::string written = option->substr(0, option->find('='));
  const std::string bare = written.substr(std::min(written.find_first_not_of('-'), written.size()));
  std::vector<std::string> names;
  for (const CLI::Option* known : command.get_options())
    for (const std::string& one : known->get_lnames()) names.push_back(one);
  const auto begun = std::ranges::find_if(names, [&](const std::string& known) {
    return known.size() > 2 &&
           (bare.starts_with(known) || (bare.size() > 2 && known.starts_with(bare)));
  });
  const std::string near =
      begun != names.end() ? *begun
                           : std::string(cdb::dsl::DidYouMean(bare, {names.begin(), names.end()}));
  return fmt::format("cdb {}: there is no option '{}'; {}`cdb {} --help` lists them\n", name,
                     written, near.empty() ? "" : fmt::format("did you mean '--{}'? ", near), name);
}

ExitStatus Main(int argc, char** argv) {
  CLI::App app("cdb: a benchmark for collision detection. Begin with `cdb run FILE.cdb`.");
  app.set_version_flag("--version", "cdb " CDB_VERSION);
  app.require_subcommand(1);
  app.fallthrough(false);
  ExitStatus status = ExitStatus::kGood;
  for (const cdb::options::Command& row : cdb::cli::Commands()) {
    cdb::options::Subcommand command(app, row, status);
    row.declare(command);
  }
  cdb::layouts::SetPoseReader(cdb::options::ReadHdf5Poses);
  std::vector<std::string> arguments = WithOptionsForWords(argc, argv);
  if (!arguments.empty() && !arguments[0].starts_with('-')) CheckCommandName(arguments[0]);
  app.name(argc > 0 ? argv[0] : "cdb");
  try {
    // CLI11 takes them from the back.
    std::ranges::reverse(arguments);
    app.parse(std::move(arguments));
  } catch (const CLI::ExtrasError&) {
    const auto commands = app.get_subcommands();
    cdb::terminal::Say(WhyNotTaken(commands.empty() ? app : *commands.front()));
    return ExitStatus::kEnvironmentError;
  } catch (const CLI::RequiredError& error) {
    const auto commands = app.get_subcommands();
    if (commands.empty()) {
      cdb::terminal::Say(app.help());
    } else {
      const std::string name = commands.front()->get_name();
      cdb::terminal::Say(fmt::format("cdb {}: {}; `cdb {} --help`\n", name, error.what(), name));
    }
    return ExitStatus::kEnvironmentError;
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, err;
    const int code = app.exit(error, out, err);
    cdb::terminal::Print(out.str());
    cdb::terminal::Say(err.str());
    return code == 0 ? ExitStatus::kGood : ExitStatus::kEnvironmentError;
  }
  return status;
}

ExitStatus MainWithErrors(int argc, char** argv) {
  try {
    return Main(argc, argv);
  } catch (const std::exception& error) {
    cdb::terminal::Say(fmt::format("cdb: {}\n", error.what()));
  }
  return ExitStatus::kEnvironmentError;
}

/// Opens closed standard descriptors. Otherwise the next file to be opened would get such a
/// descriptor, and output would be written into it.
void KeepStandardDescriptors() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    // Read-only as standard input and output: writing to it fails, and the failure is reported.
    if (fcntl(fd, F_GETFD) < 0) open("/dev/null", fd == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

/// Undoes what the starter of this program may have set: with SIGCHLD ignored, no child can be
/// waited for, and a blocked signal would not stop a sweep or end work at its limit. Other ignored
/// signals stay so (nohup).
void KeepSignals() {
  std::signal(SIGCHLD, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

/// Reports an error if some of the output could not be written.
ExitStatus CheckOutput(ExitStatus status) {
  const auto fault = cdb::terminal::FinishOutput();
  if (!fault) return status;
  cdb::terminal::Say(
      fmt::format("cdb: cannot write standard output: {}; the output is incomplete\n", *fault));
  return ExitStatus::kEnvironmentError;
}

}  // namespace

int main(int argc, char** argv) {
  KeepStandardDescriptors();
  KeepSignals();
  // A write beyond the limit on the size of files must fail with an error and a message, not end
  // the program.
  std::signal(SIGXFSZ, SIG_IGN);
  return static_cast<int>(CheckOutput(MainWithErrors(argc, argv)));
}
