// `cdb doc`: the reference of the language and of the results.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "dsl/diagnostics.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/subcommand.h"
#include "runtime/cli/topics.h"
#include "runtime/manual/word.h"
#include "runtime/report/console.h"
#include "runtime/report/table.h"

namespace cdb::cli {
namespace {

using schema::Parameter;
using schema::ParametrisedWord;

void PrintTopics() {
  report::Table table;
  table.AddColumn("cdb doc", false);
  table.AddColumn("", false);
  for (const Topic& topic : Topics())
    table.AddRow({std::string(topic.name), std::string(topic.doc)});
  report::Print(table.Text());
  report::Print(
      "  or the name of a parameter, a block or a word: cdb doc size, cdb doc links, cdb doc "
      "ring\n");
}

/// `name` is the parameter's, the last part of it, or that of a block it is in.
bool Names(const std::string& name, const Parameter& parameter) {
  return name == parameter.FullName() || name == parameter.name ||
         name == parameter.name.substr(parameter.name.find('.') + 1) ||
         parameter.name.starts_with(name + ".");
}

/// Everything called `name`: a topic, parameters and words may share it. Empty for nothing.
std::string ReferenceOf(const std::string& name) {
  std::string text;
  for (const Topic& topic : Topics())
    if (name == topic.name) text += topic.text();
  for (const Parameter& parameter : schema::Schema())
    if (Names(name, parameter)) text += manual::ParameterReference(parameter);
  for (const ParametrisedWord& word : schema::ParametrisedWords())
    if (name == word.name) text += manual::WordReference(word);
  return text;
}

/// Of parameters, words and topics.
std::vector<std::string> AllNames() {
  std::vector<std::string> names;
  for (const Parameter& parameter : schema::Schema()) {
    names.push_back(parameter.FullName());
    names.emplace_back(parameter.name);
  }
  for (const ParametrisedWord& word : schema::ParametrisedWords()) names.emplace_back(word.name);
  for (const Topic& topic : Topics()) names.emplace_back(topic.name);
  return names;
}

/// `name`: a topic, a parameter or a word; empty for the list of topics.
ExitStatus Doc(const std::string& name) {
  if (name.empty()) {
    PrintTopics();
    return ExitStatus::kGood;
  }
  if (const std::string text = ReferenceOf(name); !text.empty()) {
    report::Print(text);
    return ExitStatus::kGood;
  }
  const std::vector<std::string> names = AllNames();
  const std::string_view near = dsl::DidYouMean(name, {names.begin(), names.end()});
  throw CommandError(fmt::format("there is nothing about '{}'; {}", name,
                                 near.empty() ? std::string("`cdb doc` lists what there is")
                                              : fmt::format("did you mean '{}'?", near)));
}

}  // namespace

void AddDocCommand(CLI::App& app, ExitStatus& status) {
  const auto name = std::make_shared<std::string>();
  Subcommand command(app, "doc", "the reference: language, parameters, results");
  command.Optional("NAME", *name, "a topic or a parameter");
  command.Action(status, [name] { return Doc(*name); });
}

}  // namespace cdb::cli
