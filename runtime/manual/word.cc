#include "runtime/manual/word.h"

#include <fmt/format.h>

#include <span>
#include <string_view>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "runtime/terminal/table.h"

namespace cdb::manual {
namespace {

using schema::Parameter;
using schema::ParametrisedWord;

/// `stack(height: all, gap: fit, spacing: fit)`, `at(x, y, z)`.
std::string Signature(const ParametrisedWord& info) {
  std::string text;
  for (const Parameter& argument : info.arguments) {
    if (!text.empty()) text += ", ";
    text += argument.name;
    if (!argument.DefaultText().empty()) text += fmt::format(": {}", argument.DefaultText());
  }
  return fmt::format("{}({})", info.name, text);
}

/// A table of every argument.
std::string Arguments(const std::vector<const ParametrisedWord*>& calls) {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"argument", "of", "takes", "unit", ""}) table.AddColumn(head, false);
  for (const ParametrisedWord* info : calls)
    for (const Parameter& argument : info->arguments)
      table.AddRow({std::string(argument.name), std::string(info->name), argument.Takes(),
                    std::string(argument.unit), std::string(argument.doc)});
  return table.Text();
}

std::vector<const ParametrisedWord*> CallsOf(const Parameter& parameter) {
  std::vector<const ParametrisedWord*> calls;
  for (const std::string_view name : parameter.AllCalls())
    calls.push_back(schema::FindParametrisedWord(name));
  return calls;
}

/// Words with and without arguments, then the arguments.
template <typename Rows>
std::string Words(const char* title, const Rows& rows,
                  const std::vector<const ParametrisedWord*>& calls) {
  terminal::Table table;
  table.KeepWhole();
  table.AddColumn(title, false);
  table.AddColumn("", false);
  for (const auto& row : rows) table.AddRow({std::string(row.name), std::string(row.doc)});
  for (const ParametrisedWord* info : calls)
    table.AddRow({Signature(*info), std::string(info->doc)});
  return table.Text() + "\n" + Arguments(calls);
}

std::string Words(const char* title, const std::vector<const ParametrisedWord*>& calls) {
  return Words(title, std::span<const schema::LayoutInfo>(), calls);
}

}  // namespace

std::string ParameterReference(const Parameter& parameter) {
  std::string text = fmt::format("{}\n  {}\n", parameter.FullName(), parameter.doc);
  text += fmt::format("  takes    {}\n", parameter.Takes());
  text += fmt::format("  default  {}\n", parameter.DefaultText());
  if (!parameter.unit.empty()) text += fmt::format("  unit     {}\n", parameter.unit);
  const auto calls = CallsOf(parameter);
  return calls.empty() ? text : text + "\n" + Words("with arguments", calls);
}

std::string WordReference(const ParametrisedWord& word) { return Words("word", {&word}); }

std::string ObjectReference() {
  return Words("objects", schema::ObjectTypes(), CallsOf(*schema::GroupParameter("type")));
}

std::string LayoutReference() {
  return Words("layouts", schema::Layouts(), CallsOf(*schema::GroupParameter("location")));
}

std::string ScheduleReference() {
  return Words("schedules", CallsOf(*schema::WorldParameter("acceleration")));
}

}  // namespace cdb::manual
