#include "compiler/evaluate/evaluate_call.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using dsl::ExprKind;

constexpr std::string_view kModelFormats[] = {".obj", ".ply", ".stl", ".off"};

std::string LowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// Each argument of the row as `call` gives it, null where it does not; reports what fits none.
class GivenArguments {
 public:
  GivenArguments(const Expr& call, const schema::ParametrisedWord& info,
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
        Report(argument.value->span, "a value without a name stands before those with names",
               fmt::format("write {}: before it, if it is that", slot->name));
      } else {
        Take(argument, *slot);
      }
    }
  }

  bool good() const { return good_; }
  const dsl::Argument* operator[](std::size_t i) const { return given_[i]; }

 private:
  void Report(const dsl::Span& span, std::string message, std::string help = {}) {
    diagnostics_.Report(scenario::kBadArguments, span, std::move(message), std::move(help));
    good_ = false;
  }

  void ReportWeight(const dsl::Argument& argument) {
    const std::string& word = argument.value->text;
    if (std::ranges::find(info_.arguments, word, &schema::Parameter::name) ==
        info_.arguments.end()) {
      Report(argument.weight->span, fmt::format("{}( ) takes no weights", info_.name));
    } else {
      Report(argument.value->span, fmt::format("a ':' is missing behind '{}'", word),
             fmt::format("write {}: {}", word, argument.weight->text));
    }
  }

  void ReportNoSuch(const dsl::Argument& argument) {
    std::vector<std::string_view> names;
    for (const schema::Parameter& parameter : info_.arguments) names.push_back(parameter.name);
    const std::string all = fmt::format("it takes {}", fmt::join(names, ", "));
    if (!argument.name) {
      Report(argument.value->span,
             fmt::format("{}( ) takes at most {} argument{}", info_.name, names.size(),
                         names.size() == 1 ? "" : "s"),
             all);
      return;
    }
    const std::string_view near = dsl::DidYouMean(argument.name->text, names);
    Report(argument.name->span,
           fmt::format("{}( ) has no argument '{}'", info_.name, argument.name->text),
           near.empty() ? all : fmt::format("did you mean '{}'?", near));
  }

  void Take(const dsl::Argument& argument, const schema::Parameter& slot) {
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

  const schema::ParametrisedWord& info_;
  dsl::Diagnostics& diagnostics_;
  std::vector<const dsl::Argument*> given_;
  bool good_ = true;
};

}  // namespace

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
  scenario::Scope inner = scope;
  if (argument != nullptr) inner.parameter = argument;
  return inner;
}

std::optional<Term> Evaluator::EvaluateWord(const Expr& expr, const schema::ParametrisedWord& info,
                                            const scenario::Scope& scope) {
  const GivenArguments given(expr, info, diagnostics_);
  bool good = given.good();
  schema::Call call{std::string(info.name), {}};
  std::vector<std::string_view> missing;
  std::vector<Term> terms(info.arguments.size(), Term{schema::Word{}});
  for (std::size_t i = 0; i < info.arguments.size(); ++i) {
    const schema::Parameter& parameter = info.arguments[i];
    if (given[i] == nullptr) {
      if (parameter.default_text.empty()) {
        missing.push_back(parameter.name);
      } else {
        call.arguments.push_back(schema::DefaultOf(parameter));
      }
      continue;
    }
    scenario::Scope inner = scope;
    inner.parameter = &parameter;
    const Expr& written = *given[i]->value;
    const auto term = Evaluate(written, inner);
    const auto value =
        term ? ToValue(*term, parameter, written, inner) : std::optional<schema::Value>();
    good = good && value;
    if (!value) continue;
    call.arguments.push_back(*value);
    terms[i] = *term;
  }
  // A name that is not quite right is what is missing.
  if (given.good() && !missing.empty())
    ReportMissingArguments(info, missing, expr.span, diagnostics_);
  if (!good || !missing.empty()) return std::nullopt;
  if (schema::NamesFile(info) && !ReadNamed(call, terms)) return std::nullopt;
  return Term{std::move(call)};
}

std::optional<schema::Call> Evaluator::TraceNamed(const Term& name) {
  schema::Call call{std::string(schema::kTraceCall), {}};
  if (!ReadNamed(call, {name, Term{schema::Word{}}})) return std::nullopt;
  return call;
}

bool Evaluator::ReadNamed(schema::Call& call, const std::vector<Term>& arguments) {
  namespace fs = std::filesystem;
  const std::string& name = arguments[0].text()->text;
  const dsl::Span& written = arguments[0].written;
  const bool is_trace = call.name == schema::kTraceCall;
  const std::string extension = LowerCase(fs::path(name).extension().string());
  if (!is_trace && std::ranges::find(kModelFormats, extension) == std::end(kModelFormats)) {
    Error(scenario::kOutOfDomain, written, fmt::format("'{}' is no model that can be read", name),
          fmt::format("its name ends in {}", fmt::join(kModelFormats, ", ")));
    return false;
  }
  const fs::path folder = fs::path(written.source->name()).parent_path();
  const std::string path = (folder / name).lexically_normal().string();
  std::string why;
  std::optional<std::string> hash;
  if (is_trace) {
    if (const auto facts = scenario_.TraceAt(path, why)) hash = facts->sha256;
  } else {
    hash = scenario_.HashOf(path, why);
  }
  if (!hash) {
    Error(scenario::kNoSuchFile, written, fmt::format("cannot read '{}': {}", path, why),
          fmt::format("{}its name counts from the folder of the .cdb file that says it",
                      is_trace ? "`cdb trace` writes such files; " : ""));
    return false;
  }
  const schema::Text* wanted = arguments[1].text();
  if (wanted != nullptr && LowerCase(wanted->text) != *hash) {
    Error(scenario::kContradiction, arguments[1].written,
          fmt::format("'{}' has the SHA-256 {}, not {}", path, *hash, wanted->text),
          "it is another file than the one meant, or was changed");
    return false;
  }
  call.arguments = {schema::Text{path}, schema::Text{*hash}};
  return true;
}

std::nullopt_t Evaluator::NoSuchFunction(const Expr& expr, const scenario::Scope& scope) {
  const auto takes_word = [&](const schema::Parameter& parameter) {
    return parameter.HasWord(expr.text, scenario_.plugins());
  };
  const Referent referent = Resolve(expr.text, scope);
  if (referent.let || referent.parameter ||
      (scope.parameter != nullptr ? takes_word(*scope.parameter)
                                  : std::ranges::any_of(schema::Schema(), takes_word)))
    return Error(scenario::kBadArguments, expr.span,
                 fmt::format("'{}' takes no arguments", expr.text),
                 fmt::format("write {} alone", expr.text));
  std::vector<std::string_view> names = {"sweep", "any", "uniform", "normal", "log_uniform"};
  for (const schema::ParametrisedWord& info : schema::ParametrisedWords())
    if (scope.parameter == nullptr || scope.parameter->TakesCall(info.name))
      names.push_back(info.name);
  const std::string_view near = dsl::DidYouMean(expr.text, names);
  return Error(scenario::kUnknownName, expr.span,
               fmt::format("no function is called '{}'", expr.text),
               near.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                            : fmt::format("did you mean '{}'?", near));
}

std::optional<Term> Evaluator::EvaluateAny(const Expr& expr, const scenario::Scope& scope) {
  DrawnTerm drawn;
  drawn.kind = schema::DistributionKind::kAny;
  if (expr.arguments.empty())
    return Error(scenario::kBadArguments, expr.span, "any( ) has nothing to choose from");
  bool good = true;
  for (const dsl::Argument& argument : expr.arguments) {
    if (argument.name) {
      Error(scenario::kBadArguments, argument.name->span,
            fmt::format("any( ) has no argument '{}'", argument.name->text),
            "a weight follows its choice: any(sphere 3, cone 1)");
      good = false;
      continue;
    }
    const auto choice = Evaluate(*argument.value, scope);
    double weight = 1;
    if (argument.weight) {
      const auto number = EvaluateNumber(*argument.weight, scope, "weights");
      weight = number ? number->AsReal() : 1;
      if (number && !(weight > 0)) {
        Error(scenario::kOutOfDomain, argument.weight->span, "a weight is more than 0",
              "leave out what is never to be chosen");
        good = false;
      }
      good = good && number;
    }
    if (choice && choice->drawn()) {
      Error(scenario::kBadArguments, argument.value->span,
            "a distribution cannot be a choice of any( )");
      good = false;
    }
    good = good && choice;
    if (choice) {
      drawn.arguments.push_back(*choice);
      drawn.weights.push_back(weight);
    }
  }
  if (!good) return std::nullopt;
  return Term{std::move(drawn)};
}

std::optional<Term> Evaluator::EvaluateDrawn(const Expr& expr, schema::DistributionKind kind,
                                             const scenario::Scope& scope) {
  const bool normal = kind == schema::DistributionKind::kNormal;
  const char* usage =
      normal ? "normal(mean, deviation), or normal(mean, variance: v)" : "uniform(least, most)";
  std::vector<Term> arguments;
  bool variance = false;
  for (const dsl::Argument& argument : expr.arguments) {
    if (argument.weight)
      return Error(scenario::kBadArguments, argument.weight->span,
                   fmt::format("{}( ) takes no weights", expr.text), usage);
    if (argument.name) {
      variance = argument.name->text == "variance";
      if (!normal || arguments.size() != 1 || (!variance && argument.name->text != "sd"))
        return Error(scenario::kBadArguments, argument.name->span,
                     fmt::format("{}( ) has no argument '{}'{}", expr.text, argument.name->text,
                                 normal && arguments.size() != 1 ? " there" : ""),
                     usage);
    }
    const auto term = Evaluate(*argument.value, scope);
    if (!term) return std::nullopt;
    if (!term->number() && !term->vector())
      return Error(
          scenario::kWrongKind, argument.value->span,
          fmt::format("{}( ) takes numbers or vectors, this is {}", expr.text, KindName(*term)),
          usage);
    arguments.push_back(*term);
  }
  if (arguments.size() != 2)
    return Error(scenario::kBadArguments, expr.span,
                 fmt::format("{}( ) takes two values, here {} {}", expr.text,
                             arguments.size() == 1 ? "is" : "are", arguments.size()),
                 usage);
  const auto widen = [](Term& term, const Term& other) {
    if (term.number() && other.vector() && term.number()->AsReal() == 0)
      term = Term{Eigen::Vector3d(Eigen::Vector3d::Zero())};
  };
  widen(arguments[0], arguments[1]);
  widen(arguments[1], arguments[0]);
  if ((arguments[0].vector() != nullptr) != (arguments[1].vector() != nullptr))
    return Error(scenario::kBadArguments, expr.span, "one value is a number, the other a vector",
                 "write both as numbers or both as vectors");
  // Numbers as vectors of three equal components, so that one check serves both.
  const auto triple = [](const Term& term) {
    return term.vector() ? *term.vector()
                         : Eigen::Vector3d(Eigen::Vector3d::Constant(term.number()->AsReal()));
  };
  const Eigen::Vector3d a = triple(arguments[0]), b = triple(arguments[1]);
  const dsl::Span& last = expr.arguments[1].value->span;
  if (normal && (b.array() < 0).any())
    return Error(scenario::kOutOfDomain, last,
                 fmt::format("a {} is 0 or more", variance ? "variance" : "standard deviation"));
  if (!normal && (a.array() > b.array()).any())
    return Error(scenario::kOutOfDomain, expr.span,
                 fmt::format("the least value, {}, is more than the most, {}", ToText(arguments[0]),
                             ToText(arguments[1])),
                 "swap them");
  if (kind == schema::DistributionKind::kLogUniform && (a.array() <= 0).any())
    return Error(scenario::kOutOfDomain, expr.arguments[0].value->span,
                 "log_uniform( ) takes values more than 0");
  if (variance) {
    if (arguments[1].vector()) {
      arguments[1] = Term{Eigen::Vector3d(b.array().sqrt())};
    } else {
      arguments[1] = Term{Number::Real(std::sqrt(b.x()))};
    }
  }
  return Term{DrawnTerm{kind, std::move(arguments), {}}};
}

}  // namespace cdb::evaluate
