// `cdb list`: the names that a scenario can use.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/cli/help/topics.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

constexpr std::string_view kKinds[] = {"objects", "detectors", "layouts", "schedules", "scenarios"};

/// `asked`: one of the kinds, or empty for all.
options::ExitStatus List(const std::string& asked) {
  std::string text;
  for (const std::string_view kind : kKinds)
    if (asked.empty() || asked == kind)
      text += (text.empty() ? "" : "\n") + help::GeneratedPart(kind);
  if (text.empty())
    throw options::CommandError(
        fmt::format("there is no list of '{}'; there are {}", asked, fmt::join(kKinds, ", ")));
  terminal::Print(text);
  return options::ExitStatus::kGood;
}

std::vector<std::string> ListKinds() { return {std::begin(kKinds), std::end(kKinds)}; }

void DeclareList(options::Subcommand& command) {
  const auto kind = std::make_shared<std::string>();
  command.Optional("KIND", *kind, "objects, detectors, layouts, schedules or scenarios");
  command.Action([kind] { return List(*kind); });
}

}  // namespace

options::Command ListCommand() {
  return {.name = "list",
          .help = "list the names that a scenario can use",
          .declare = DeclareList,
          .words = ListKinds};
}

}  // namespace cdb::cli
