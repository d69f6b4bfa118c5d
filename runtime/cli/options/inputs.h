// Input files of commands: scenarios and plans, and the location of the library.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/compile.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"
#include "library/objects/solid_factory.h"

namespace cdb::options {

/// The folder of the scenarios that come with cdb: beside the program in the build tree, or
/// installed with it. Empty if there is none.
std::string ScenarioLibrary();

/// The name of standard input in messages and plans.
inline constexpr std::string_view kStandardInput = "<stdin>";
/// Turns `-` into kStandardInput; other names stay as they are. For commands that can read standard
/// input.
std::string FileOrStandardInput(const std::string& file);

/// Lets FindScenario return, in place of `file`, a scenario that extends its benchmarks, or the one
/// that is asked for, by `settings`: each is NAME=VALUE, as of `--set`. Throws CommandError. Does
/// nothing without settings.
void SetInScenario(const std::string& file, const std::optional<std::string>& benchmark,
                   const std::vector<std::string>& settings);

/// compiler::ReadFromDisk, extended by standard input, which is read once, and by the scenario of
/// SetInScenario.
std::optional<std::string> ReadInput(const std::string& path, std::string& why);

/// The scenario file for a name on the command line: kStandardInput, the file itself, or else the
/// file of that name in the library, with or without `.cdb`. Throws CommandError.
std::string FindScenario(const std::string& file);

/// The same, ignoring SetInScenario.
std::string FindScenarioFile(const std::string& file);
/// The names of the benchmarks that a scenario file itself has, in its order. Errors in it are not
/// reported. Throws CommandError.
std::vector<std::string> BenchmarksOf(const std::string& file);

/// The detail in which lints (compiler/lints/lints.h) are printed.
enum class LintText { kNone, kOneLine, kWhole };

/// In colour on a terminal, and at most 20 errors.
dsl::RenderOptions RenderOptionsForTerminal();

/// Options with the library of scenarios in the folder `library`, plug-ins and traces.
/// `lists_runs`: as in compiler::CompileOptions.
compiler::CompileOptions OptionsOf(const std::string& library,
                                   const std::optional<std::string>& benchmark,
                                   const std::vector<std::string>& plugins, bool lists_runs,
                                   const objects::Reading& models = {.decomposes = false});

/// Compiles `file` as returned by `read`, with the library of scenarios, plug-ins and traces.
/// `lists_runs`: as in compiler::CompileOptions. Throws ScheduleError.
compiler::Compilation CompileWith(const std::string& file, const scenario::ReadFile& read,
                                  const std::optional<std::string>& benchmark,
                                  const std::vector<std::string>& plugins = {},
                                  bool lists_runs = true,
                                  const objects::Reading& models = {.decomposes = false});

/// Compiles the file that FindScenario finds, and prints every diagnostic on standard error. If
/// lints are printed, meshes are decomposed, with a line of progress on a terminal.
/// `plugins`: shared libraries with detectors, in addition to those that the file names. Throws
/// CommandError, and ScheduleError if there is no worker program to load a library.
compiler::Compilation CompileAndReport(const std::string& file,
                                       const std::optional<std::string>& benchmark, LintText lints,
                                       const std::vector<std::string>& plugins = {},
                                       bool lists_runs = true,
                                       const scenario::ReadFile& read = ReadInput);

/// The plans of a `.cdb` file, given by path or from the library, or of a plan in YAML. Empty after
/// diagnostics were printed (exit status 1). A plan names its own plug-ins. `named` receives the
/// detectors of all plug-ins in the file and in `plugins`, used or not. Throws CommandError,
/// ScheduleError, yaml::PlanError.
std::vector<plan::Plan> LoadPlans(const std::string& file,
                                  const std::optional<std::string>& benchmark,
                                  LintText lints = LintText::kOneLine,
                                  const std::vector<std::string>& plugins = {},
                                  std::vector<schema::PluginDetector>* named = nullptr);

/// The grids of a `.cdb` file, found as by LoadPlans; their runs are not listed. `read` replaces
/// the disk.
std::vector<grid::Grid> LoadGrids(const std::string& file,
                                  const std::optional<std::string>& benchmark, LintText lints,
                                  const std::vector<std::string>& plugins,
                                  const scenario::ReadFile& read = ReadInput);

/// True if the name of the file is that of a plan in YAML.
bool IsPlanFile(const std::string& file);
/// Throws CommandError for options that cannot be used with a plan of the benchmark `planned`.
void CheckPlanFile(const std::string& file, const std::optional<std::string>& benchmark,
                   const std::vector<std::string>& plugins, const std::string& planned);

/// Throws CommandError for a duplicate word, and for a word that is unknown to the parameter and,
/// if it takes detectors, to `plugins`.
void CheckWords(schema::WorldParameter parameter, const std::vector<std::string>& words,
                std::span<const schema::PluginDetector> plugins = {});

/// `5%`, `5 %` or `5` as the fraction 0.05. Throws CommandError that names the option.
double ParsePercent(const std::string& option, const std::string& text);

/// Throws CommandError if several of these forms of output, each with whether
/// it was asked for, are asked for.
void CheckOneForm(std::initializer_list<std::pair<const char*, bool>> forms);

/// The whole text of a file. Throws CommandError.
std::string ReadText(const std::string& file);

}  // namespace cdb::options
