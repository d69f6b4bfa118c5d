#include "runtime/cli/commands.h"

namespace cdb::cli {

using MakeCommand = options::Command();

// Each is in the file of its name.
MakeCommand NewCommand, CheckCommand, PlanCommand, RunCommand, SubmitCommand, TraceCommand,
    ShowCommand, ReportCommand, ViewCommand, CompareCommand, HistoryCommand, StabilityCommand,
    SuiteCommand, VerifyCommand, MergeCommand, DoctorCommand, FormatCommand, LspCommand;
MakeCommand ExplainCommand, DocCommand, ListCommand, GenerateCommand;

std::span<const options::Command> Commands() {
  static const options::Command kCommands[] = {
      NewCommand(),     CheckCommand(),    ExplainCommand(),   PlanCommand(),   RunCommand(),
      SubmitCommand(),  TraceCommand(),    ShowCommand(),      ReportCommand(), ViewCommand(),
      CompareCommand(), HistoryCommand(),  StabilityCommand(), SuiteCommand(),  VerifyCommand(),
      MergeCommand(),   DoctorCommand(),   FormatCommand(),    LspCommand(),    DocCommand(),
      ListCommand(),    GenerateCommand(),
  };
  return kCommands;
}

}  // namespace cdb::cli
