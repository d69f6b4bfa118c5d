// `cdb list`: the names that a scenario can use.
#include "runtime/cli/help/help_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <string_view>

#include "runtime/cli/help/topics.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/terminal/console.h"

namespace cdb::help {
namespace {

constexpr std::string_view kKinds[] = {"objects", "detectors", "layouts", "schedules", "scenarios"};

/// `asked`: one of the kinds, or empty for all.
options::ExitStatus List(const std::string& asked) {
  std::string text;
  for (const std::string_view kind : kKinds)
    if (asked.empty() || asked == kind) text += (text.empty() ? "" : "\n") + GeneratedPart(kind);
  if (text.empty())
    throw options::CommandError(
        fmt::format("there is no list of '{}'; there are {}", asked, fmt::join(kKinds, ", ")));
  terminal::Print(text);
  return options::ExitStatus::kGood;
}

}  // namespace

std::vector<std::string> ListKinds() { return {std::begin(kKinds), std::end(kKinds)}; }

void AddListCommand(CLI::App& app, options::ExitStatus& status) {
  const auto kind = std::make_shared<std::string>();
  options::Subcommand command(app, "list", "list the names that a scenario can use");
  command.Optional("KIND", *kind, "objects, detectors, layouts, schedules or scenarios");
  command.Action(status, [kind] { return List(*kind); });
}

}  // namespace cdb::help
