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
/// Writes one page of all files. Exit status 3 if a run failed, or its timings do not count.
void AddReportCommand(CLI::App& app, ExitStatus& status);
/// What changed between results files. Exit status 4 if something is worse by more than
/// --fail-above.
void AddCompareCommand(CLI::App& app, ExitStatus& status);
/// Runs the suite and prints the map. Safe to rerun: finished runs are skipped. Failed runs are
/// expected here: exit status 0.
void AddStabilityCommand(CLI::App& app, ExitStatus& status);
/// Runs the standard suite and prints a score for each configuration and kind of application, or
/// checks results of it. Safe to rerun: finished runs are skipped. Exit status 3 if runs failed or
/// a submission is not comparable, 4 if another machine's results are not borne out.
void AddSuiteCommand(CLI::App& app, ExitStatus& status);
/// Compares the pairs and contacts of detectors with exact ones in each cycle, and prints a table.
/// Exit status 3 for a missed pair or a failed run.
void AddVerifyCommand(CLI::App& app, ExitStatus& status);
/// A page with the bodies of a run in 3-D, or those of a scenario at its start.
void AddViewCommand(CLI::App& app, ExitStatus& status);
/// Job arrays of a Slurm cluster, and a merge after each. Exit status 2 if runs are missing at the
/// end.
void AddSubmitCommand(CLI::App& app, ExitStatus& status);
void AddMergeCommand(CLI::App& app, ExitStatus& status);
/// A kind of diagnostic, with a wrong and a right example.
void AddExplainCommand(CLI::App& app, ExitStatus& status);
void AddFormatCommand(CLI::App& app, ExitStatus& status);
/// The language server, until the editor ends it.
void AddLspCommand(CLI::App& app, ExitStatus& status);
/// Files for editors, shells and man, made from the tables of the language.
void AddGenerateCommand(CLI::App& app, ExitStatus& status);
/// What makes timings doubtful here. Exit status 3 if a fixed loop does not run steadily.
void AddDoctorCommand(CLI::App& app, ExitStatus& status);
void AddDocCommand(CLI::App& app, ExitStatus& status);
void AddListCommand(CLI::App& app, ExitStatus& status);

}  // namespace cdb::cli
