// `cdb new`: writes a first scenario.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/parser.h"
#include "runtime/cli/help/first_scene.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct NewArguments {
  std::string file = "scene.cdb";
  std::string compared, objects;
  std::uint64_t quantity = 0;  ///< 0: the default
  bool lists = false;
};

std::string TableOf(std::string_view option, std::span<const help::SceneWord> words) {
  std::string text;
  for (const help::SceneWord& word : words)
    text += fmt::format("{} {:10} {}\n", option, word.word, word.doc);
  return text;
}

void CheckWord(std::string_view option, const std::string& word,
               std::span<const help::SceneWord> words) {
  if (word.empty() || std::ranges::find(words, word, &help::SceneWord::word) != words.end()) return;
  std::vector<std::string_view> known;
  for (const help::SceneWord& each : words) known.push_back(each.word);
  throw options::CommandError(fmt::format(
      "{} {}: {}", option, word,
      options::Suggestion(word, known, fmt::format("there are {}", fmt::join(known, ", ")))));
}

/// A line from the terminal.
std::optional<std::string> ReadAnswer(const std::string& question) {
  terminal::Say(question);
  std::string line;
  if (!std::getline(std::cin, line)) return std::nullopt;
  const std::size_t first = line.find_first_not_of(" \t"), last = line.find_last_not_of(" \t\r");
  return first == line.npos ? std::string() : line.substr(first, last + 1 - first);
}

std::optional<help::SceneChoice> Choose(const NewArguments& arguments) {
  const bool asks = arguments.compared.empty() && arguments.objects.empty() &&
                    arguments.quantity == 0 && isatty(STDIN_FILENO) != 0 &&
                    isatty(STDERR_FILENO) != 0;
  if (asks) return help::AskForScene(ReadAnswer);
  const auto or_first = [](const std::string& word, std::span<const help::SceneWord> words) {
    return word.empty() ? std::string(words[0].word) : word;
  };
  return help::SceneChoice{or_first(arguments.compared, help::SceneTemplates()),
                           or_first(arguments.objects, help::SceneObjects()), arguments.quantity};
}

/// The name of the file where that can be the name of a benchmark.
std::string BenchmarkFor(const fs::path& file) {
  const std::string stem = file.stem().string();
  dsl::Diagnostics diagnostics;
  const auto tree =
      dsl::Parse(std::make_shared<const text::Source>("", fmt::format("benchmark {} {{}}\n", stem)),
                 diagnostics);
  return diagnostics.has_errors() || tree.items.size() != 1 ? "scene" : stem;
}

options::ExitStatus New(const NewArguments& arguments) {
  if (arguments.lists) {
    terminal::Print(TableOf("--template", help::SceneTemplates()) + "\n" +
                    TableOf("--objects", help::SceneObjects()));
    return options::ExitStatus::kGood;
  }
  CheckWord("--template", arguments.compared, help::SceneTemplates());
  CheckWord("--objects", arguments.objects, help::SceneObjects());
  fs::path file = arguments.file;
  if (file.extension().empty()) file += ".cdb";
  if (file.extension() != ".cdb")
    throw options::CommandError(
        fmt::format("'{}': the name of a scenario file ends in .cdb", file.string()));
  if (std::error_code error; fs::exists(fs::symlink_status(file, error)))
    throw options::CommandError(fmt::format(
        "'{}' exists and was not changed; name another file: cdb new FILE", file.string()));
  const auto choice = Choose(arguments);
  if (!choice) throw options::CommandError("no answer; nothing was written");
  const std::string word = terminal::ShellWord(file.string());
  files::WriteWhole(help::SceneText(*choice, BenchmarkFor(file), word), file);
  terminal::Print(fmt::format(
      "{} is written; see it: cdb view {}; change it: cdb view --serve {}; run it:\ncdb run {}\n",
      file.string(), word, word, word));
  return options::ExitStatus::kGood;
}

void DeclareNew(options::Subcommand& command) {
  const auto arguments = std::make_shared<NewArguments>();
  command.Optional("FILE", arguments->file, "the scenario to write (default: scene.cdb)");
  command.Optional("--template", arguments->compared, "what is compared: a word of --list");
  command.Optional("--objects", arguments->objects, "what falls: a word of --list");
  command.Count("--quantity", arguments->quantity, "how many fall");
  command.Flag("--list", arguments->lists, "list the templates and the objects");
  command.Action([arguments] {
    if (arguments->quantity > help::kMostSceneObjects)
      throw options::CommandError(fmt::format("--quantity {}: a first scene has at most {} objects",
                                              arguments->quantity, help::kMostSceneObjects));
    return New(*arguments);
  });
}

}  // namespace

/// Asks what it should contain on a terminal, unless an option says it. Never overwrites a file.
options::Command NewCommand() {
  return {.name = "new",
          .help = "write a first scenario, from a template or three questions",
          .declare = DeclareNew};
}

}  // namespace cdb::cli
