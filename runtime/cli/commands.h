// The subcommands of `cdb`. Each function declares the options of one; parsing a command line that
// names it runs it and sets `status`. Commands throw CommandError and the errors of what they use.
#pragma once

#include "runtime/cli/exit_status.h"

namespace CLI {
class App;
}

namespace cdb::cli {

void AddCheckCommand(CLI::App& app, ExitStatus& status);
void AddPlanCommand(CLI::App& app, ExitStatus& status);
void AddRunCommand(CLI::App& app, ExitStatus& status);
/// Runs each point once for its boxes and poses, and writes a trace of each. Safe to rerun:
/// finished traces are skipped.
void AddTraceCommand(CLI::App& app, ExitStatus& status);
void AddShowCommand(CLI::App& app, ExitStatus& status);
/// What changed between results files. Exit status 4 if something is worse by more than
/// --fail-above.
void AddCompareCommand(CLI::App& app, ExitStatus& status);
/// Runs the suite and prints the map. Safe to rerun: finished runs are skipped. Failed runs are
/// expected here: exit status 0.
void AddStabilityCommand(CLI::App& app, ExitStatus& status);
/// Compares the pairs and contacts of detectors with exact ones in each cycle, and prints a table.
/// Exit status 3 for a missed pair or a failed run.
void AddVerifyCommand(CLI::App& app, ExitStatus& status);
void AddMergeCommand(CLI::App& app, ExitStatus& status);
void AddFormatCommand(CLI::App& app, ExitStatus& status);
void AddDocCommand(CLI::App& app, ExitStatus& status);
void AddListCommand(CLI::App& app, ExitStatus& status);

}  // namespace cdb::cli
