#include "runtime/cli/serve_scenario.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "dsl/render.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/pages/serve/server.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

/// Reads the edited file from the editor and all others from the disk.
scenario::ReadFile ReadEdited(const std::string& file, const std::string& text) {
  return [file, text](const std::string& path, std::string& why) -> std::optional<std::string> {
    if (path == file) return text;
    return compiler::ReadFromDisk(path, why);
  };
}

std::string ChooseBenchmark(const std::string& file, const std::string& text,
                            const std::optional<std::string>& wanted) {
  const std::vector<std::string> names =
      options::CompileWith(file, ReadEdited(file, text), std::nullopt).benchmarks;
  if (names.empty())
    throw options::CommandError(
        fmt::format("{}: there is no benchmark to edit; `cdb check` explains why", file));
  if (!wanted) return names[0];
  if (std::ranges::find(names, *wanted) == names.end())
    throw options::CommandError(fmt::format("{} has no benchmark '{}'; there are {}", file, *wanted,
                                            fmt::join(names, ", ")));
  return *wanted;
}

}  // namespace

options::ExitStatus ServeScenario(const std::string& file,
                                  const std::optional<std::string>& benchmark) {
  if (options::FindScenario(file) != file)
    throw options::CommandError(fmt::format(
        "{} comes with cdb and cannot be edited: write a file that extends it, or copy it", file));
  const std::string text = options::ReadText(file);
  const auto check = [file](const std::string& edited) {
    compiler::Compilation result =
        options::CompileWith(file, ReadEdited(file, edited), std::nullopt);
    return serve::Checked{dsl::Render(result.diagnostics), std::move(result.plans)};
  };
  process::StopFlag stop;
  const process::StopOnSignals on_signals(stop);
  serve::Editor editor({file, ChooseBenchmark(file, text, benchmark), text, check},
                       std::filesystem::read_symlink("/proc/self/exe"));
  serve::Serve(editor, stop.fd(), [](const std::string& address) {
    terminal::Print(fmt::format("{}\n", address));
    terminal::Flush();  // a program may be waiting for it
    terminal::Say("open this address in a browser on this machine; Ctrl-C ends\n");
  });
  return options::ExitStatus::kGood;
}

}  // namespace cdb::cli
