#include "compiler/names/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/schema.h"
#include "dsl/diagnostics.h"
#include "dsl/parser.h"
#include "dsl/text/check.h"

namespace cdb::names {
namespace {

/// The lets of a file come before the statements of any benchmark.
constexpr int kFileLets = -1'000'000;
constexpr std::string_view kObjectCount = "objects";

}  // namespace

Referent Names::Resolve(const std::string& path, const scenario::Scope& scope) const {
  // A default of the schema: every other word stands for itself.
  if (scope.file == nullptr) return {std::nullopt, std::nullopt, path == kObjectCount};
  if (scope.parameter != nullptr &&
      (scope.parameter->HasWord(path, scenario_.plugins()) || scope.parameter->TakesCall(path)))
    return {};
  if (scope.parameter != nullptr && scope.parameter->word_source == schema::WordSource::kGroups &&
      IsGroup(path))
    return {};
  if (scope.parameter != nullptr && scope.parameter->word_source == schema::WordSource::kJoints &&
      std::ranges::find(layers_.joints, path) != layers_.joints.end())
    return {};
  if (auto let = FindLet(path, scope)) return {std::move(let), std::nullopt};
  if (auto measure = FindMeasure(path, scope))
    return {std::nullopt, std::nullopt, false, std::move(measure)};
  return {std::nullopt, FindParameter(path, scope)};
}

std::string_view Names::NearestLet(const std::string& word, const scenario::Scope& scope) const {
  std::vector<std::string_view> names;
  if (scope.file != nullptr) names = scenario_.LetNames(*scope.file);
  for (const auto& [key, let] : layers_.lets) names.push_back(key.second);
  return dsl::DidYouMean(word, names);
}

std::optional<scenario::Placed<dsl::Let>> Names::FindLet(const std::string& path,
                                                         const scenario::Scope& scope) const {
  for (std::string block = scenario::Joined(scope.group, scope.block);;
       block = scenario::Outside(block)) {
    const auto let = layers_.lets.find({block, path});
    if (let != layers_.lets.end()) return let->second;
    if (block.empty()) break;
  }
  const auto let = scenario_.FindLet(*scope.file, path);
  if (!let) return std::nullopt;
  scenario::Placed<dsl::Let> placed;
  placed.node = let->let;
  placed.scope.file = let->file;
  placed.order = kFileLets + scenario_.LetOrder(*let->let);
  return placed;
}

std::optional<scenario::ParameterKey> Names::FindParameter(const std::string& path,
                                                           const scenario::Scope& scope) const {
  for (std::string block = scope.block;; block = scenario::Outside(block)) {
    if (const schema::Parameter* parameter =
            schema::FindParameter(scenario::Joined(block, path), !scope.group.empty()))
      return scenario::ParameterKey{scope.group, parameter};
    // Outside the block of a joint or of queries, there are no settings of its own.
    if (block.empty() || block == schema::NamedBlockOf(block)) break;
  }
  if (const schema::Parameter* parameter = schema::FindParameter(path, false))
    return scenario::ParameterKey{"", parameter};
  // Outside the blocks, `quantity` means that of `objects`, like the name of its axis.
  if (scope.group.empty() && scope.block.empty() && IsGroup("objects"))
    if (const schema::Parameter* parameter = schema::FindParameter(path, true);
        parameter != nullptr && parameter->NamedBlock().empty())
      return scenario::ParameterKey{"objects", parameter};
  const std::size_t dot = path.find('.');
  if (dot == std::string::npos) return std::nullopt;
  const std::string head = path.substr(0, dot), rest = path.substr(dot + 1);
  const std::string_view block = layers_.NamedBlockWith(head);
  if (!block.empty() || IsGroup(head))
    if (const schema::Parameter* parameter =
            schema::FindParameter(scenario::Joined(block, rest), true))
      return scenario::ParameterKey{head, parameter};
  return std::nullopt;
}

std::optional<BoxMeasure> Names::FindMeasure(std::string_view path,
                                             const scenario::Scope& scope) const {
  constexpr std::pair<std::string_view, BoxMeasure::Kind> kKinds[] = {
      {"extent", BoxMeasure::Kind::kExtent},
      {"lower", BoxMeasure::Kind::kLower},
      {"upper", BoxMeasure::Kind::kUpper}};
  // A name without a dot is a word, such as that of a group.
  if (path.find('.') == path.npos) return std::nullopt;
  BoxMeasure measure;
  constexpr std::string_view kAxes = "xyz";
  if (path.size() > 2 && path[path.size() - 2] == '.')
    if (const std::size_t axis = kAxes.find(path.back()); axis != kAxes.npos) {
      measure.axis = static_cast<int>(axis);
      path.remove_suffix(2);
    }
  const std::size_t dot = path.rfind('.');
  const std::string_view name = dot == path.npos ? path : path.substr(dot + 1);
  const auto kind = std::ranges::find(kKinds, name, [](const auto& each) { return each.first; });
  if (kind == std::end(kKinds)) return std::nullopt;
  measure.kind = kind->second;
  // As for a parameter, the innermost group is meant, or `objects` outside of the blocks.
  if (dot != path.npos)
    measure.group = path.substr(0, dot);
  else
    measure.group = scope.group.empty() ? "objects" : scope.group;
  if (!IsGroup(measure.group)) return std::nullopt;
  return measure;
}

bool Names::IsGroup(std::string_view name) const {
  return std::ranges::find(layers_.groups, name) != layers_.groups.end();
}

using dsl::Expr;

const schema::Parameter* ArgumentAt(const schema::ParametrisedWord& info, const Expr& call,
                                    std::size_t i) {
  const auto& name = call.arguments[i].name;
  if (!name && info.takes_parts) return &schema::PartParameter();
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
             slot == &schema::PartParameter()
                 ? "write the parts first"
                 : fmt::format("write {}: before it, if it is this argument", slot->name));
    } else if (slot != &schema::PartParameter()) {
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

namespace {

struct Defaults {
  dsl::File file;
  std::map<const schema::Parameter*, const dsl::Setting*> settings;
};

Defaults ParseDefaults() {
  std::string text = "benchmark defaults {\n";
  for (const schema::Parameter& parameter : schema::Schema())
    text += "  " + parameter.FullName() + " " + std::string(parameter.DefaultText()) + "\n";
  text += "}\n";
  dsl::Diagnostics diagnostics;
  Defaults defaults;
  defaults.file = dsl::Parse(std::make_shared<const text::Source>("defaults", text), diagnostics);
  CDB_CHECK(!diagnostics.has_errors());
  const auto& statements = std::get<dsl::Benchmark>(defaults.file.items[0]).block.statements;
  CDB_CHECK(statements.size() == schema::Schema().size());
  for (std::size_t i = 0; i < statements.size(); ++i)
    defaults.settings[&schema::Schema()[i]] = &std::get<dsl::Setting>(statements[i].what);
  return defaults;
}

}  // namespace

const dsl::Setting& DefaultSetting(const schema::Parameter& parameter) {
  static const Defaults defaults = ParseDefaults();
  return *defaults.settings.at(&parameter);
}

namespace {

struct NameOf {
  std::string operator()(bool on) const { return on ? "'on'" : "'off'"; }
  std::string operator()(const schema::Number& number) const {
    return fmt::format("the number {}", number.Text());
  }
  std::string operator()(const schema::Word& word) const { return fmt::format("'{}'", word.text); }
  std::string operator()(const schema::Text&) const { return "a text"; }
  std::string operator()(const Eigen::Vector3d&) const { return "a vector"; }
  std::string operator()(const schema::Ratio&) const { return "a ratio"; }
  std::string operator()(const schema::WordList&) const { return "a list"; }
  std::string operator()(const schema::Call& call) const { return fmt::format("{}( )", call.name); }
  std::string operator()(const schema::Formula&) const { return "a value of each object"; }
  std::string operator()(const schema::Distribution& drawn) const {
    return fmt::format("the distribution {}( )", schema::DistributionName(drawn.kind));
  }
};

}  // namespace

std::string KindName(const schema::Value& value) {
  return std::visit(NameOf{}, static_cast<const schema::Value::variant&>(value));
}

}  // namespace cdb::names
