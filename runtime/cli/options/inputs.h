// Files that commands take: scenarios, plans, and where the library lies.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/compile.h"
#include "compiler/plan/plan.h"
#include "dsl/render.h"

namespace cdb::options {

/// The folder of the scenarios that come with cdb: beside the program that was built, or installed
/// with it. Empty where there is none.
std::string ScenarioLibrary();

/// What standard input is called in messages and plans.
inline constexpr std::string_view kStandardInput = "<stdin>";
/// `-` as kStandardInput, other names as they are: for commands that can read it.
std::string FileOrStandardInput(const std::string& file);

/// compiler::ReadFromDisk, and standard input, which is read once.
std::optional<std::string> ReadInput(const std::string& path, std::string& why);

/// The scenario file that a command line names: kStandardInput, the file itself, else the library's
/// of that name, with or without `.cdb`. Throws CommandError.
std::string FindScenario(const std::string& file);

/// How much is said of numbers that Bullet cannot follow (compiler/lints.h).
enum class LintText { kNone, kOneLine, kWhole };

/// In colour on a terminal, and at most 20 errors.
dsl::RenderOptions RenderOptionsForTerminal();

/// The library of scenarios in the folder `library`, plug-ins and traces. `lists_runs`: as in
/// compiler::CompileOptions.
compiler::CompileOptions OptionsOf(const std::string& library,
                                   const std::optional<std::string>& benchmark,
                                   const std::vector<std::string>& plugins, bool lists_runs);

/// Compiles `file` as `read` gives it, with the library of scenarios, plug-ins and traces.
/// `lists_runs`: as in compiler::CompileOptions. Throws ScheduleError.
compiler::Compilation CompileWith(const std::string& file, const scenario::ReadFile& read,
                                  const std::optional<std::string>& benchmark,
                                  const std::vector<std::string>& plugins = {},
                                  bool lists_runs = true);

/// Compiles the file that FindScenario finds, and prints every diagnostic on standard error.
/// `plugins`: shared libraries with detectors, beside those that the file names. Throws
/// CommandError, ScheduleError (no worker program to look into a library).
compiler::Compilation CompileAndReport(const std::string& file,
                                       const std::optional<std::string>& benchmark, LintText lints,
                                       const std::vector<std::string>& plugins = {},
                                       bool lists_runs = true,
                                       const scenario::ReadFile& read = ReadInput);

/// The plans of a `.cdb` file, here or in the library, or of a plan as YAML. Empty after
/// diagnostics were printed (exit status 1). A plan names its own plug-ins. `named`: gets the
/// detectors of all plug-ins that the file and `plugins` bring, used or not. Throws CommandError,
/// ScheduleError, compiler::PlanError.
std::vector<plan::Plan> LoadPlans(const std::string& file,
                                  const std::optional<std::string>& benchmark,
                                  LintText lints = LintText::kOneLine,
                                  const std::vector<std::string>& plugins = {},
                                  std::vector<schema::PluginDetector>* named = nullptr);

/// The grids of a `.cdb` file, as LoadPlans; their runs are not listed. `read`: in place of the
/// disk.
std::vector<grid::Grid> LoadGrids(const std::string& file,
                                  const std::optional<std::string>& benchmark, LintText lints,
                                  const std::vector<std::string>& plugins,
                                  const scenario::ReadFile& read = ReadInput);

/// A plan as YAML, by its name.
bool IsPlanFile(const std::string& file);
/// Throws CommandError for options that do not go with a plan of the benchmark `planned`.
void CheckPlanFile(const std::string& file, const std::optional<std::string>& benchmark,
                   const std::vector<std::string>& plugins, const std::string& planned);

/// Throws CommandError for a word that neither the parameter nor, where it takes detectors,
/// `plugins` has, or that is there twice.
void CheckWords(schema::WorldParameter parameter, const std::vector<std::string>& words,
                std::span<const schema::PluginDetector> plugins = {});

/// `5%`, `5 %` or `5` as the fraction 0.05. Throws CommandError that names the option.
double ParsePercent(const std::string& option, const std::string& text);

/// The whole text of a file. Throws CommandError.
std::string ReadText(const std::string& file);

}  // namespace cdb::options
