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
#include <vector>

#include "dsl/diagnostics.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/options/pose_files.h"
#include "runtime/terminal/console.h"

namespace {

using cdb::options::CommandError;
using cdb::options::ExitStatus;

/// Throws CommandError if there is no command `name`.
void CheckCommandName(std::string_view name) {
  std::vector<std::string_view> names;
  for (const cdb::options::Command& command : cdb::cli::Commands()) names.push_back(command.name);
  if (std::ranges::find(names, name) != names.end()) return;
  throw CommandError(fmt::format("there is no command '{}'; {}", name,
                                 cdb::options::Suggestion(name, names, "`cdb --help` lists them")));
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
  if (argc > 1 && argv[1][0] != '-') CheckCommandName(argv[1]);
  try {
    app.parse(argc, argv);
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
