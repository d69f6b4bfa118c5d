// The subcommands of `cdb`. Each function declares the options of one subcommand. When the parsed
// command line names that subcommand, it is executed and sets `status`. Commands throw CommandError
// and the errors of the functions that they use.
#pragma once

#include "runtime/cli/options/exit_status.h"

namespace CLI {
class App;
}

namespace cdb::cli {

void AddCheckCommand(CLI::App& app, options::ExitStatus& status);
void AddPlanCommand(CLI::App& app, options::ExitStatus& status);
void AddRunCommand(CLI::App& app, options::ExitStatus& status);
/// Runs each point once for its boxes and poses, and writes a trace of each. Safe to rerun:
/// finished traces are skipped.
void AddTraceCommand(CLI::App& app, options::ExitStatus& status);
void AddShowCommand(CLI::App& app, options::ExitStatus& status);
/// Writes one page of all files. Exit status 3 if a run failed, or its timings do not count.
void AddReportCommand(CLI::App& app, options::ExitStatus& status);
/// Prints the changes between results files. Exit status 4 if something is worse by more than
/// --fail-above.
void AddCompareCommand(CLI::App& app, options::ExitStatus& status);
/// Runs the suite and prints the map. Safe to rerun: finished runs are skipped. Failed runs are
/// expected here: exit status 0.
void AddStabilityCommand(CLI::App& app, options::ExitStatus& status);
/// Runs the standard suite and prints a score for each configuration and kind of application, or
/// checks results of the suite. Safe to rerun: finished runs are skipped. Exit status 3 if runs
/// failed or a submission is not comparable, 4 if the results of another machine disagree.
void AddSuiteCommand(CLI::App& app, options::ExitStatus& status);
/// Compares the pairs and contacts of detectors with exact ones in each cycle, and prints a table.
/// Exit status 3 for a missed pair or a failed run.
void AddVerifyCommand(CLI::App& app, options::ExitStatus& status);
/// Writes a page with the bodies of a run in 3-D, or those of a scenario at its start.
void AddViewCommand(CLI::App& app, options::ExitStatus& status);
/// Submits job arrays to a Slurm cluster, each followed by a merge job. Exit status 2 if runs are
/// missing at the end.
void AddSubmitCommand(CLI::App& app, options::ExitStatus& status);
void AddMergeCommand(CLI::App& app, options::ExitStatus& status);
void AddFormatCommand(CLI::App& app, options::ExitStatus& status);
/// Runs the language server until the editor ends it.
void AddLspCommand(CLI::App& app, options::ExitStatus& status);
/// Prints the conditions of this machine that make timings doubtful. Exit status 3 if a fixed loop
/// does not run steadily.
void AddDoctorCommand(CLI::App& app, options::ExitStatus& status);

}  // namespace cdb::cli
