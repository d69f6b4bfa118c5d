#include "compiler/names/arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::names {

using dsl::Expr;

const schema::Parameter* ArgumentAt(const schema::ParametrisedWord& info, const Expr& call,
                                    std::size_t i) {
  const auto& name = call.arguments[i].name;
  if (!name) return i < info.arguments.size() ? &info.arguments[i] : nullptr;
  const auto row = std::ranges::find(info.arguments, name->text, &schema::Parameter::name);
  return row == info.arguments.end() ? nullptr : &*row;
}

scenario::Scope ArgumentScope(const Expr& call, std::size_t i, const scenario::Scope& scope) {
  const schema::ParametrisedWord* info = schema::FindParametrisedWord(call.text);
  const schema::Parameter* argument = info != nullptr ? ArgumentAt(*info, call, i) : nullptr;
  // There may be more points than arguments; each has the same components.
  if (argument == nullptr && info != nullptr && info->takes_points) argument = &info->arguments[0];
  scenario::Scope inner = scope;
  if (argument != nullptr) inner.parameter = argument;
  return inner;
}

GivenArguments::GivenArguments(const Expr& call, const schema::ParametrisedWord& info,
                               dsl::Diagnostics& diagnostics)
    : info_(info), diagnostics_(diagnostics), given_(info.arguments.size()) {
  bool named = false;
  for (std::size_t i = 0; i < call.arguments.size(); ++i) {
    const dsl::Argument& argument = call.arguments[i];
    named = named || argument.name;
    if (argument.weight) {
      ReportWeight(argument);
      continue;
    }
    const schema::Parameter* slot = ArgumentAt(info, call, i);
    if (slot == nullptr) {
      ReportNoSuch(argument);
    } else if (named && !argument.name) {
      Report(argument.value->span, "values without names must precede those with names",
             fmt::format("write {}: before it, if it is this argument", slot->name));
    } else {
      Take(argument, *slot);
    }
  }
}

void GivenArguments::Report(const text::Span& span, std::string message, std::string help) {
  diagnostics_.Report(scenario::kBadArguments, span, std::move(message), std::move(help));
  good_ = false;
}

void GivenArguments::ReportWeight(const dsl::Argument& argument) {
  const std::string& word = argument.value->text;
  if (std::ranges::find(info_.arguments, word, &schema::Parameter::name) == info_.arguments.end()) {
    Report(argument.weight->span, fmt::format("{}() does not take weights", info_.name));
  } else {
    Report(argument.value->span, fmt::format("a ':' is missing after '{}'", word),
           fmt::format("write {}: {}", word, argument.weight->text));
  }
}

void GivenArguments::ReportNoSuch(const dsl::Argument& argument) {
  std::vector<std::string_view> names;
  for (const schema::Parameter& parameter : info_.arguments) names.push_back(parameter.name);
  const std::string all = fmt::format("it takes {}", fmt::join(names, ", "));
  if (!argument.name) {
    Report(argument.value->span,
           fmt::format("{}() takes at most {} argument{}", info_.name, names.size(),
                       names.size() == 1 ? "" : "s"),
           all);
    return;
  }
  const std::string_view near = dsl::DidYouMean(argument.name->text, names);
  Report(argument.name->span,
         fmt::format("{}() has no argument '{}'", info_.name, argument.name->text),
         near.empty() ? all : fmt::format("did you mean '{}'?", near));
}

void GivenArguments::Take(const dsl::Argument& argument, const schema::Parameter& slot) {
  const auto index = static_cast<std::size_t>(&slot - info_.arguments.data());
  if (given_[index] == nullptr) {
    given_[index] = &argument;
    return;
  }
  diagnostics_.Report(scenario::kBadArguments,
                      argument.name ? argument.name->span : argument.value->span,
                      fmt::format("'{}' is given twice", slot.name), "keep one of them",
                      {{given_[index]->value->span, "it is here before"}});
  good_ = false;
}

}  // namespace cdb::names
