#include "runtime/cli/options/inputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <set>

#include "compiler/lints/lints.h"
#include "compiler/plan/input_file.h"
#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "dsl/parser.h"
#include "dsl/text/utf8.h"
#include "library/closed_forms/scene_fault.h"
#include "library/detectors/plugin.h"
#include "library/layouts/pose_table.h"
#include "library/robots/reader.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/results/trace_file.h"
#include "runtime/sweep/process/worker.h"
#include "runtime/terminal/console.h"

namespace cdb::options {
namespace {

namespace fs = std::filesystem;

void CheckBenchmarkName(const std::string& name, const std::vector<std::string>& names,
                        const std::string& file) {
  for (const std::string& known : names)
    if (known == name) return;
  throw CommandError(fmt::format("{} has no benchmark '{}'; {}", file, name,
                                 Suggestion(name, {names.begin(), names.end()},
                                            fmt::format("there are {}", fmt::join(names, ", ")))));
}

/// The name of each lint, once, with the line of the first. Empty if there are none.
std::string LintsInOneLine(const dsl::Diagnostics& diagnostics, const std::string& file) {
  std::vector<std::string> names;
  std::set<std::string_view> named;
  for (const dsl::Diagnostic& diagnostic : diagnostics.all()) {
    if (!lints::IsLint(*diagnostic.kind) || !named.insert(diagnostic.kind->id).second) continue;
    const text::Span& span = diagnostic.span;
    names.push_back(span.source == nullptr ? std::string(diagnostic.kind->id)
                                           : fmt::format("{} (line {})", diagnostic.kind->id,
                                                         span.source->PositionAt(span.begin).line));
  }
  if (names.empty()) return {};
  return fmt::format(
      "{}: Bullet may not simulate this accurately: {}; `cdb check {}` explains why\n", file,
      fmt::join(names, ", "), file);
}

/// Warnings by kind: the first ones in full, the lines of the others.
std::string GroupedText(std::span<const dsl::Diagnostic* const> warnings) {
  constexpr std::size_t kInFull = 2, kMostPlaces = 8;
  std::vector<std::pair<const dsl::DiagnosticKind*, std::vector<const dsl::Diagnostic*>>> kinds;
  for (const dsl::Diagnostic* warning : warnings) {
    auto kind =
        std::ranges::find(kinds, warning->kind, [](const auto& each) { return each.first; });
    if (kind == kinds.end()) kind = kinds.insert(kinds.end(), {warning->kind, {}});
    kind->second.push_back(warning);
  }
  std::string text;
  for (const auto& [kind, alike] : kinds) {
    std::vector<std::string> places;
    for (std::size_t i = 0; i < alike.size(); ++i) {
      const text::Span& span = alike[i]->span;
      if (i < kInFull)
        text += dsl::Render(*alike[i], RenderOptionsForTerminal());
      else if (places.size() < kMostPlaces && span.source != nullptr)
        places.push_back(
            fmt::format("{}:{}", span.source->name(), span.source->PositionAt(span.begin).line));
    }
    if (alike.size() <= kInFull) continue;
    const std::size_t rest = alike.size() - kInFull;
    text += fmt::format("… and {} more of {} {}: {}{}\n", rest, kind->code, kind->id,
                        fmt::join(places, ", "), places.size() < rest ? ", …" : "");
  }
  return text;
}

/// The path is removed from the message, because the compiler names the file itself.
std::optional<analysis::TraceFacts> ReadTraceAt(const std::string& path, std::string& why) {
  try {
    return results::ReadTraceFacts(path);
  } catch (const files::StoreError& error) {
    why = error.what();
    if (why.starts_with(path + ": ")) why.erase(0, path.size() + 2);
    return std::nullopt;
  }
}

}  // namespace

bool IsPlanFile(const std::string& file) {
  return file.ends_with(".yaml") || file.ends_with(".yml");
}

std::string ScenarioLibrary() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder :
       {program / "scenarios", program / ".." / "share" / "cdb" / "scenarios"})
    if (fs::is_directory(folder, error)) return fs::canonical(folder, error).string();
  return {};
}

std::string FileOrStandardInput(const std::string& file) {
  return file == "-" ? std::string(kStandardInput) : file;
}

namespace {

/// The scenario of SetInScenario.
struct Extended {
  std::string file;        ///< as the user named it
  std::string path, text;  ///< of the scenario that extends it
};
std::optional<Extended>& TheExtended() {
  static std::optional<Extended> extended;
  return extended;
}

/// The file as it is written. Its errors are reported when the scenario is compiled.
dsl::File ParseItself(const std::string& file) {
  dsl::Diagnostics ignored;
  return dsl::Parse(std::make_shared<const text::Source>(file, ReadText(FindScenarioFile(file))),
                    ignored);
}

/// The names of the lets of the file and of the benchmark.
std::vector<std::string_view> LetsOf(const dsl::File& file, const dsl::Benchmark& benchmark) {
  std::vector<std::string_view> names;
  for (const auto& item : file.items)
    if (const auto* let = std::get_if<dsl::Let>(&item)) names.push_back(let->name.text);
  for (const dsl::Statement& statement : benchmark.block.statements)
    if (const auto* let = std::get_if<dsl::Let>(&statement.what)) names.push_back(let->name.text);
  return names;
}

/// The statement of NAME=VALUE; NAME is a parameter, or one of the `lets`, or follows `let`.
std::string StatementOf(const std::string& setting, const std::vector<std::string_view>& lets) {
  const std::size_t equals = setting.find('=');
  if (equals == 0 || equals == setting.npos || equals + 1 == setting.size() ||
      setting.find_first_of("\r\n") != setting.npos)
    throw CommandError(fmt::format(
        "--set takes NAME=VALUE, such as --set objects.quantity=500, not '{}'", setting));
  const std::string name = setting.substr(0, equals), value = setting.substr(equals + 1);
  if (name.starts_with("let ")) return fmt::format("{} = {}", name, value);
  return std::ranges::find(lets, name) != lets.end() ? fmt::format("let {} = {}", name, value)
                                                     : fmt::format("{} {}", name, value);
}

}  // namespace

void SetInScenario(const std::string& file, const std::optional<std::string>& benchmark,
                   const std::vector<std::string>& settings) {
  if (settings.empty()) return;
  if (file == "-" || file == kStandardInput || IsPlanFile(file))
    throw CommandError("--set is for scenario files; a plan or standard input cannot be extended");
  const fs::path found = FindScenarioFile(file);
  const dsl::File tree = ParseItself(file);
  std::string text = fmt::format("use \"{}\"\n", found.filename().string());
  bool has_benchmark = false;
  for (const auto& item : tree.items) {
    const auto* base = std::get_if<dsl::Benchmark>(&item);
    if (base == nullptr || (benchmark && *benchmark != base->name.text)) continue;
    has_benchmark = true;
    const std::string title = base->title.empty() ? "" : fmt::format(" \"{}\"", base->title);
    text += fmt::format("benchmark {0} from {0}{1} {{\n", base->name.text, title);
    const auto lets = LetsOf(tree, *base);
    for (const std::string& setting : settings)
      text += fmt::format("  {}\n", StatementOf(setting, lets));
    text += "}\n";
  }
  // A missing benchmark is reported for the file itself.
  if (!has_benchmark) return;
  TheExtended() = {file, (found.parent_path() / "--set.cdb").string(), text};
}

std::optional<std::string> ReadInput(const std::string& path, std::string& why) {
  if (TheExtended() && path == TheExtended()->path) return TheExtended()->text;
  if (path != kStandardInput) return compiler::ReadFromDisk(path, why);
  static std::string fault;
  static const std::optional<std::string> text = plan::ReadInput(STDIN_FILENO, fault);
  if (!text) why = fault;
  return text;
}

std::string FindScenario(const std::string& file) {
  if (file == kStandardInput) return file;
  if (TheExtended() && file == TheExtended()->file) return TheExtended()->path;
  return FindScenarioFile(file);
}

std::string FindScenarioFile(const std::string& file) {
  if (file == "-")
    throw CommandError(
        "only check, fmt and plan read standard input (`-`); other commands need a file");
  if (file.ends_with(".h5"))
    throw CommandError(
        fmt::format("'{}' is a results file, not a scenario; `cdb show {}` shows it", file, file));
  if (file.ends_with(".so"))
    throw CommandError(
        fmt::format("'{0}' is a shared library, not a scenario; each needs its own option: "
                    "--plugin {0}",
                    file));
  std::error_code error;
  if (fs::exists(file, error)) return file;
  const fs::path library = ScenarioLibrary();
  if (!library.empty() && fs::path(file).is_relative())
    for (const fs::path& candidate : {library / file, library / (file + ".cdb")})
      if (fs::is_regular_file(candidate, error)) return candidate.string();
  std::string why;
  compiler::ReadFromDisk(file, why);
  throw CommandError(fmt::format(
      "cannot read '{}': {}; `cdb list scenarios` lists those that come with cdb", file, why));
}

std::vector<std::string> BenchmarksOf(const std::string& file) {
  std::vector<std::string> names;
  for (const auto& item : ParseItself(file).items)
    if (const auto* benchmark = std::get_if<dsl::Benchmark>(&item))
      names.push_back(benchmark->name.text);
  return names;
}

dsl::RenderOptions RenderOptionsForTerminal() {
  constexpr std::size_t kMostShown = 20;
  return {isatty(STDERR_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr, kMostShown};
}

compiler::CompileOptions OptionsOf(const std::string& library,
                                   const std::optional<std::string>& benchmark,
                                   const std::vector<std::string>& plugins, bool lists_runs,
                                   const objects::Reading& models) {
  const auto describe = [](const std::string& bytes, const std::string& path,
                           std::string& why) -> std::optional<std::vector<schema::PluginDetector>> {
    try {
      return detectors::ReadManifest(bytes, path);
    } catch (const detectors::PluginError& error) {
      why = error.what();
      return std::nullopt;
    }
  };
  return {library,
          benchmark,
          {plugins, describe},
          ReadTraceAt,
          closed_forms::FindSceneFault,
          layouts::ReadPoseFacts,
          objects::ModelReader(models),
          robots::ReadRobot,
          lists_runs};
}

compiler::Compilation CompileWith(const std::string& file, const scenario::ReadFile& read,
                                  const std::optional<std::string>& benchmark,
                                  const std::vector<std::string>& plugins, bool lists_runs,
                                  const objects::Reading& models) {
  return compiler::Compile(file, read,
                           OptionsOf(ScenarioLibrary(), benchmark, plugins, lists_runs, models));
}

namespace {

/// A line of progress on a terminal, about meshes that take longer than a second.
class ModelProgress {
 public:
  objects::Reading Models() {
    if (isatty(STDERR_FILENO) == 0) return {};
    return {.progress = [this](const std::string& name, std::size_t pieces) {
      if (name != name_) began_ = Clock::now();
      name_ = name;
      if (Clock::now() - began_ < std::chrono::seconds(1)) return;
      is_shown_ = true;
      terminal::SayExact(
          fmt::format("\r\033[Kdecomposing {}: {} pieces", text::Printable(name), pieces));
    }};
  }
  ~ModelProgress() {
    if (is_shown_) terminal::SayExact("\r\033[K");
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::string name_;
  Clock::time_point began_;
  bool is_shown_ = false;
};

compiler::Compilation CompileWithModels(const std::string& file, const scenario::ReadFile& read,
                                        const std::optional<std::string>& benchmark,
                                        const std::vector<std::string>& plugins, bool lists_runs) {
  ModelProgress progress;
  return CompileWith(file, read, benchmark, plugins, lists_runs, progress.Models());
}

}  // namespace

compiler::Compilation CompileAndReport(const std::string& file,
                                       const std::optional<std::string>& benchmark, LintText lints,
                                       const std::vector<std::string>& plugins, bool lists_runs,
                                       const scenario::ReadFile& read) {
  const std::string found = FindScenario(file);
  compiler::Compilation result =
      lints == LintText::kNone ? CompileWith(found, read, benchmark, plugins, lists_runs)
                               : CompileWithModels(found, read, benchmark, plugins, lists_runs);
  dsl::Diagnostics errors;
  std::vector<const dsl::Diagnostic*> warnings;
  for (const dsl::Diagnostic* diagnostic : dsl::InOrder(result.diagnostics))
    if (diagnostic->kind->severity() == dsl::Severity::kError)
      errors.Report(*diagnostic->kind, diagnostic->span, diagnostic->message, diagnostic->help,
                    diagnostic->notes);
    else if (lints == LintText::kWhole || !lints::IsLint(*diagnostic->kind))
      warnings.push_back(diagnostic);
  terminal::SayExact(dsl::Render(errors, RenderOptionsForTerminal()) + GroupedText(warnings));
  if (lints == LintText::kOneLine) terminal::Say(LintsInOneLine(result.diagnostics, file));
  return result;
}

void CheckPlanFile(const std::string& file, const std::optional<std::string>& benchmark,
                   const std::vector<std::string>& plugins, const std::string& planned) {
  if (!plugins.empty())
    throw CommandError(
        fmt::format("--plugin {} is for scenario files, but {} is a plan, which names its plug-ins",
                    plugins[0], file));
  if (benchmark) CheckBenchmarkName(*benchmark, {planned}, file);
}

std::vector<plan::Plan> LoadPlans(const std::string& file,
                                  const std::optional<std::string>& benchmark, LintText lints,
                                  const std::vector<std::string>& plugins,
                                  std::vector<schema::PluginDetector>* named) {
  if (IsPlanFile(file)) {
    plan::Plan plan = yaml::FromYaml(ReadText(file), file);
    plan.Renew();
    CheckPlanFile(file, benchmark, plugins, plan.benchmark);
    if (named != nullptr)
      for (const plan::Run& run : plan.runs)
        for (const schema::PluginDetector& plugin : run.scene.plugins)
          if (std::ranges::find(*named, plugin) == named->end()) named->push_back(plugin);
    return {std::move(plan)};
  }
  compiler::Compilation result = CompileAndReport(file, benchmark, lints, plugins);
  if (named != nullptr)
    named->assign(result.scenario->plugins().begin(), result.scenario->plugins().end());
  // The path as the user gave it: the location of the library differs between machines.
  for (plan::Plan& plan : result.plans) plan.source = file;
  if (!result.diagnostics.has_errors() && benchmark)
    CheckBenchmarkName(*benchmark, result.benchmarks, file);
  return std::move(result.plans);
}

std::vector<grid::Grid> LoadGrids(const std::string& file,
                                  const std::optional<std::string>& benchmark, LintText lints,
                                  const std::vector<std::string>& plugins,
                                  const scenario::ReadFile& read) {
  compiler::Compilation result =
      CompileAndReport(file, benchmark, lints, plugins, /*lists_runs=*/false, read);
  for (grid::Grid& grid : result.grids) grid.head.source = file;
  if (!result.diagnostics.has_errors() && benchmark)
    CheckBenchmarkName(*benchmark, result.benchmarks, file);
  return std::move(result.grids);
}

void CheckWords(schema::WorldParameter parameter, const std::vector<std::string>& words,
                std::span<const schema::PluginDetector> plugins) {
  std::string option(parameter.name());
  std::ranges::replace(option, '_', '-');
  std::set<std::string_view> seen;
  for (const std::string& word : words) {
    const auto all = (*parameter).AllWords(plugins);
    if (!(*parameter).HasWord(word, plugins))
      throw CommandError(
          fmt::format("--{} {}: {}", option, word,
                      Suggestion(word, all, fmt::format("there are {}", fmt::join(all, ", "))) +
                          (parameter.get()->TakesDetectors() && plugins.empty()
                               ? "; your own detector needs --plugin FILE.so"
                               : "")));
    if (!seen.insert(word).second)
      throw CommandError(fmt::format("--{} names '{}' twice", option, word));
  }
}

double ParsePercent(const std::string& option, const std::string& text) {
  std::string number = text;
  if (number.ends_with('%')) number.pop_back();
  number.erase(number.find_last_not_of(' ') + 1);
  double percent = 0;
  const char* const last = number.data() + number.size();
  const auto [end, error] = std::from_chars(number.data(), last, percent);
  if (error != std::errc() || end != last || !(percent >= 0))
    throw CommandError(
        fmt::format("{} {}: not a percentage of 0 or more, such as 5%", option, text));
  return percent / 100;
}

void CheckOneForm(std::initializer_list<std::pair<const char*, bool>> forms) {
  const char* first = nullptr;
  for (const auto& [name, is_asked] : forms) {
    if (is_asked && first != nullptr)
      throw CommandError(fmt::format("choose either {} or {}", first, name));
    if (is_asked) first = name;
  }
}

std::string ReadText(const std::string& file) {
  std::string why;
  auto text = ReadInput(file, why);
  if (!text) throw CommandError(fmt::format("cannot read '{}': {}", file, why));
  return std::move(*text);
}

}  // namespace cdb::options
