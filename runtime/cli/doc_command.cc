// `cdb doc`: the reference of the language and of the results.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/compile.h"
#include "dsl/diagnostics.h"
#include "runtime/cli/help/topics.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/manual/lookup.h"
#include "runtime/manual/markdown.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

std::vector<std::string> DocNames() {
  std::vector<std::string> names = manual::KnownNames();
  for (const std::string_view topic : help::TopicNames()) names.emplace_back(topic);
  return names;
}

/// The entries of everything called `name`: a topic, words, parameters and a command. Empty if
/// there are none.
std::string ReferenceOf(const std::string& name, const CLI::App& app) {
  std::string text = help::TopicText(name);
  const auto add = [&text](const std::string& part) {
    if (part.empty()) return;
    text += (text.empty() ? "" : "\n") + terminal::Fitted(part, terminal::TerminalWidth());
  };
  add(manual::TextAbout(name));
  for (const CLI::App* command :
       app.get_subcommands([&](const CLI::App* one) { return one->get_name() == name; }))
    add(command->help());
  return text;
}

/// The text of a file of the library; empty if there is none.
std::string LibraryText(const std::string& name) {
  const std::filesystem::path library = options::ScenarioLibrary();
  if (library.empty() || name.find("..") != name.npos) return {};
  std::string why;
  return compiler::ReadFromDisk((library / name).string(), why).value_or("");
}

/// Prints a scenario, or a page about scenarios, that comes with cdb; false if there is none.
bool PrintFromLibrary(const std::string& name) {
  for (const char* extension : {"", ".cdb"})
    if (const std::string scenario = LibraryText(name + extension); !scenario.empty()) {
      terminal::PrintExact(scenario);
      return true;
    }
  const std::string page = LibraryText(name + ".md");
  if (page.empty()) return false;
  terminal::Print(
      manual::PageText(page, terminal::TextWidth(), [](auto) { return std::string(); }));
  return true;
}

/// The scenarios, and pages about them, that come with cdb and whose file has this name, in any
/// folder.
std::vector<std::string> ScenariosCalled(const std::string& name) {
  std::vector<std::string> found;
  const std::filesystem::path library = options::ScenarioLibrary();
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(library, error))
    if ((entry.path().extension() == ".cdb" || entry.path().extension() == ".md") &&
        entry.path().stem() == name)
      found.push_back(std::filesystem::path(entry.path())
                          .replace_extension()
                          .lexically_relative(library)
                          .string());
  std::ranges::sort(found);
  return found;
}

/// `name`: a topic, a parameter, a word, a command or a scenario; empty for the list of topics.
options::ExitStatus Doc(const std::string& name, const CLI::App& app) {
  const std::string text =
      name.empty() ? help::TopicText(help::kListOfTopics) : ReferenceOf(name, app);
  if (!text.empty()) {
    terminal::Print(text);
    return options::ExitStatus::kGood;
  }
  if (PrintFromLibrary(name)) return options::ExitStatus::kGood;
  const std::vector<std::string> found = ScenariosCalled(name);
  if (found.size() == 1 && PrintFromLibrary(found[0])) return options::ExitStatus::kGood;
  if (!found.empty())
    throw options::CommandError(
        fmt::format("no entry for '{}'; there are the scenarios {}: `cdb doc {}`", name,
                    fmt::join(found, ", "), found.front()));
  const std::vector<std::string> names = DocNames();
  throw options::CommandError(fmt::format(
      "no entry for '{}'; {}", name,
      options::Suggestion(name, {names.begin(), names.end()}, "`cdb doc` lists the topics")));
}

void DeclareDoc(options::Subcommand& command) {
  const auto name = std::make_shared<std::string>();
  command.Optional("NAME", *name,
                   "a topic, a parameter, a word, a command, or a scenario that comes with cdb");
  command.Action([name, &app = command.program()] { return Doc(*name, app); });
}

}  // namespace

options::Command DocCommand() {
  return {.name = "doc",
          .help = "print the reference: language, parameters, results",
          .declare = DeclareDoc,
          .words = DocNames};
}

}  // namespace cdb::cli
