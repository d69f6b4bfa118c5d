#include "compiler/evaluate/distributions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/evaluate/calls.h"
#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/names/names.h"
#include "compiler/plan/text_table.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/utf8.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using Eigen::Vector3d;
using schema::DistributionKind;
using schema::Number;
using schema::Value;

/// The weight of a choice of any( ): 1 if none is given.
std::optional<double> WeightOf(const dsl::Argument& argument, const scenario::Scope& scope,
                               Evaluator& evaluator) {
  if (!argument.weight) return 1;
  const auto number = evaluator.EvaluateNumber(*argument.weight, scope, "weights");
  if (!number) return std::nullopt;
  if (!(number->AsReal() > 0))
    return evaluator.Error(scenario::kOutOfDomain, argument.weight->span,
                           "a weight must be greater than 0",
                           "remove choices that should never be drawn");
  return number->AsReal();
}

/// Adds a choice of any( ); false after a diagnostic.
bool AddChoice(const dsl::Argument& argument, const scenario::Scope& scope, Evaluator& evaluator,
               schema::Distribution& drawn) {
  if (argument.name) {
    evaluator.Error(scenario::kBadArguments, argument.name->span,
                    fmt::format("any() has no argument '{}'", argument.name->text),
                    "a weight follows its choice: any(sphere 3, cone 1)");
    return false;
  }
  const auto choice = evaluator.Evaluate(*argument.value, scope);
  const auto weight = WeightOf(argument, scope, evaluator);
  if (choice && AsDistribution(*choice)) {
    evaluator.Error(scenario::kBadArguments, argument.value->span,
                    "a distribution cannot be a choice of any( )");
    return false;
  }
  if (choice && AsFormula(*choice)) {
    RefuseFormula(*AsFormula(*choice), evaluator.diagnostics());
    return false;
  }
  if (!choice || !weight) return false;
  drawn.arguments.push_back(*choice);
  drawn.weights.push_back(*weight);
  return true;
}

/// A distribution of two numbers or two vectors while it is evaluated.
class PairDistribution {
 public:
  PairDistribution(const Expr& call, DistributionKind kind, const scenario::Scope& scope,
                   Evaluator& evaluator)
      : call_(call),
        kind_(kind),
        is_normal_(kind == DistributionKind::kNormal),
        usage_(is_normal_ ? "normal(mean, deviation), or normal(mean, variance: v)"
                          : "uniform(least, most)"),
        scope_(scope),
        evaluator_(evaluator) {}

  std::optional<Value> Evaluate() {
    for (const dsl::Argument& argument : call_.arguments)
      if (!CheckForm(argument) || !Add(argument)) return std::nullopt;
    if (!MatchKinds() || !CheckDomain()) return std::nullopt;
    if (is_variance_) arguments_[1] = DeviationOf(arguments_[1]);
    return schema::Distribution{kind_, std::move(arguments_), {}};
  }

 private:
  bool Fail(const dsl::DiagnosticKind& kind, const text::Span& span, std::string message,
            std::string help = {}) {
    evaluator_.Error(kind, span, std::move(message), std::move(help));
    return false;
  }

  bool CheckForm(const dsl::Argument& argument) {
    if (argument.weight)
      return Fail(scenario::kBadArguments, argument.weight->span,
                  fmt::format("{}() does not take weights", call_.text), usage_);
    if (!argument.name) return true;
    is_variance_ = argument.name->text == "variance";
    const bool is_second = arguments_.size() == 1;
    if (is_normal_ && is_second && (is_variance_ || argument.name->text == "sd")) return true;
    return Fail(scenario::kBadArguments, argument.name->span,
                fmt::format("{}() has no argument '{}'{}", call_.text, argument.name->text,
                            is_normal_ && !is_second ? " there" : ""),
                usage_);
  }

  bool Add(const dsl::Argument& argument) {
    const auto value = evaluator_.Evaluate(*argument.value, scope_);
    if (!value) return false;
    if (AsFormula(*value)) {
      RefuseFormula(*AsFormula(*value), evaluator_.diagnostics());
      return false;
    }
    if (!AsNumber(*value) && !AsVector(*value))
      return Fail(scenario::kWrongKind, argument.value->span,
                  fmt::format("{}() takes numbers or vectors, but this is {}", call_.text,
                              names::KindName(*value)),
                  usage_);
    arguments_.push_back(*value);
    return true;
  }

  /// Makes both numbers or both vectors: 0 beside a vector becomes a vector.
  bool MatchKinds() {
    if (arguments_.size() != 2)
      return Fail(scenario::kBadArguments, call_.span,
                  fmt::format("{}() takes two values, but there {} {}", call_.text,
                              arguments_.size() == 1 ? "is" : "are", arguments_.size()),
                  usage_);
    const auto widen = [](Value& value, const Value& other) {
      if (AsNumber(value) && AsVector(other) && AsNumber(value)->AsReal() == 0)
        value = Value(Vector3d(Vector3d::Zero()));
    };
    widen(arguments_[0], arguments_[1]);
    widen(arguments_[1], arguments_[0]);
    if ((AsVector(arguments_[0]) != nullptr) == (AsVector(arguments_[1]) != nullptr)) return true;
    return Fail(scenario::kBadArguments, call_.span, "one value is a number, the other a vector",
                "write both as numbers or both as vectors");
  }

  bool CheckDomain() {
    // Numbers become vectors of three equal components, so that one check serves both.
    const auto triple = [](const Value& value) {
      return AsVector(value) ? *AsVector(value)
                             : Vector3d(Vector3d::Constant(AsNumber(value)->AsReal()));
    };
    const Vector3d a = triple(arguments_[0]), b = triple(arguments_[1]);
    if (is_normal_ && (b.array() < 0).any())
      return Fail(
          scenario::kOutOfDomain, call_.arguments[1].value->span,
          fmt::format("a {} is 0 or more", is_variance_ ? "variance" : "standard deviation"));
    if (!is_normal_ && (a.array() > b.array()).any())
      return Fail(scenario::kOutOfDomain, call_.span,
                  fmt::format("the lower bound, {}, is greater than the upper, {}",
                              ToText(arguments_[0]), ToText(arguments_[1])),
                  "swap them");
    if (kind_ == DistributionKind::kLogUniform && (a.array() <= 0).any())
      return Fail(scenario::kOutOfDomain, call_.arguments[0].value->span,
                  "log_uniform() takes values greater than 0");
    return true;
  }

  static Value DeviationOf(const Value& variance) {
    if (AsVector(variance)) return Value(Vector3d(AsVector(variance)->array().sqrt()));
    return std::sqrt(AsNumber(variance)->AsReal());
  }

  const Expr& call_;
  const DistributionKind kind_;
  const bool is_normal_;
  const char* const usage_;
  const scenario::Scope& scope_;
  Evaluator& evaluator_;
  std::vector<Value> arguments_;
  bool is_variance_ = false;  ///< whether the second argument is a variance
};

/// Evaluates `in 2 .. 8`; nullopt after a diagnostic.
std::optional<schema::Limits> LimitsOf(const Expr& call, const scenario::Scope& scope,
                                       Evaluator& evaluator) {
  const auto least = evaluator.EvaluateNumber(*call.items[0], scope, "limits");
  const auto most = evaluator.EvaluateNumber(*call.items[1], scope, "limits");
  if (!least || !most) return std::nullopt;
  if (Compare(*least, *most) < 0) return schema::Limits{least->AsReal(), most->AsReal()};
  return evaluator.Error(scenario::kOutOfDomain, call.items[0]->span,
                         fmt::format("the lower limit, {}, is not less than the upper, {}",
                                     least->Text(), most->Text()));
}

}  // namespace

std::optional<Value> EvaluateAny(const Expr& call, const scenario::Scope& scope,
                                 Evaluator& evaluator) {
  if (call.arguments.empty())
    return evaluator.Error(scenario::kBadArguments, call.span, "any() has no choices");
  schema::Distribution drawn;
  drawn.kind = DistributionKind::kAny;
  bool good = true;
  for (const dsl::Argument& argument : call.arguments)
    good = AddChoice(argument, scope, evaluator, drawn) && good;
  if (!good) return std::nullopt;
  if (!call.items.empty())
    return evaluator.Error(scenario::kBadArguments, call.items[0]->span,
                           "any() draws from a list and cannot have limits",
                           "remove the values outside of them");
  return drawn;
}

std::optional<Value> EvaluateDistribution(const Expr& call, DistributionKind kind,
                                          const scenario::Scope& scope, Evaluator& evaluator) {
  using enum DistributionKind;
  std::optional<Value> drawn;
  if (kind == kAny) return EvaluateAny(call, scope, evaluator);
  if (kind == kEmpirical) {
    drawn = EvaluateEmpirical(call, scope, evaluator);
  } else if (kind == kUniform || kind == kNormal || kind == kLogUniform) {
    drawn = PairDistribution(call, kind, scope, evaluator).Evaluate();
  } else {
    drawn = EvaluatePositive(call, kind, scope, evaluator);
  }
  if (!drawn || call.items.empty()) return drawn;
  const auto limits = LimitsOf(call, scope, evaluator);
  if (!limits) return std::nullopt;
  schema::Distribution limited = *AsDistribution(*drawn);
  limited.limits = limits;
  return limited;
}

namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// An argument and its range.
struct PositiveArgument {
  std::string_view name;
  double least, most;
};

// Draws of lognormal must fit into a double; shapes below 0.01 draw almost only 0.
constexpr PositiveArgument kLognormalArguments[] = {{"mu", -500, 500}, {"sigma", 0, 20}};
constexpr PositiveArgument kExponentialArguments[] = {{"mean", 0, kUnlimited}};
constexpr PositiveArgument kShapeArguments[] = {{"shape", 0.01, 1e6}, {"scale", 0, kUnlimited}};

std::span<const PositiveArgument> ArgumentsFor(DistributionKind kind) {
  if (kind == DistributionKind::kLognormal) return kLognormalArguments;
  if (kind == DistributionKind::kExponential) return kExponentialArguments;
  return kShapeArguments;
}

class PositiveEvaluation {
 public:
  PositiveEvaluation(const dsl::Expr& call, DistributionKind kind, const scenario::Scope& scope,
                     Evaluator& evaluator)
      : call_(call),
        kind_(kind),
        scope_(scope),
        evaluator_(evaluator),
        row_(ArgumentsFor(kind)),
        values_(row_.size()) {}

  std::optional<Value> Evaluate() {
    for (std::size_t i = 0; i < call_.arguments.size(); ++i)
      if (!Add(i)) return std::nullopt;
    if (std::ranges::any_of(values_, [](const auto& value) { return !value; }))
      return Fail(call_.span,
                  fmt::format("{}() takes {} number{}, but there {} {}", call_.text, row_.size(),
                              row_.size() == 1 ? "" : "s",
                              call_.arguments.size() == 1 ? "is" : "are", call_.arguments.size()));
    schema::Distribution drawn{kind_, {}, {}};
    for (const auto& value : values_) drawn.arguments.emplace_back(*value);
    return drawn;
  }

 private:
  std::nullopt_t Fail(const text::Span& span, std::string message) {
    return evaluator_.Error(scenario::kBadArguments, span, std::move(message),
                            std::string(schema::InfoOf(kind_).usage));
  }

  bool Add(std::size_t i) {
    const dsl::Argument& argument = call_.arguments[i];
    if (argument.weight) {
      Fail(argument.weight->span, fmt::format("{}() does not take weights", call_.text));
      return false;
    }
    const bool is_median =
        argument.name && argument.name->text == "median" && kind_ == DistributionKind::kLognormal;
    std::size_t place = is_median ? 0 : i;
    if (argument.name && !is_median)
      place = static_cast<std::size_t>(
          std::ranges::find(row_, argument.name->text, &PositiveArgument::name) - row_.begin());
    if (place >= row_.size()) {
      Fail(argument.name ? argument.name->span : argument.value->span,
           argument.name ? fmt::format("{}() has no argument '{}'", call_.text, argument.name->text)
                         : fmt::format("{}() takes at most {} number{}", call_.text, row_.size(),
                                       row_.size() == 1 ? "" : "s"));
      return false;
    }
    if (values_[place]) {
      Fail(argument.value->span, fmt::format("'{}' is given twice", row_[place].name));
      return false;
    }
    return Evaluate(argument, place, is_median);
  }

  bool Evaluate(const dsl::Argument& argument, std::size_t place, bool is_median) {
    const auto number = evaluator_.EvaluateNumber(*argument.value, scope_, "its arguments");
    if (!number) return false;
    const PositiveArgument& row = row_[place];
    const double value = number->AsReal();
    const bool is_open = row.least == 0 && row.name != "sigma";
    const bool fits = is_median
                          ? value > 0
                          : (is_open ? value > row.least : value >= row.least) && value <= row.most;
    if (fits) {
      values_[place] = is_median ? std::log(value) : value;
      return true;
    }
    std::string wanted = "more than 0";
    if (!is_median && row.most != kUnlimited)
      wanted = fmt::format("from {} to {}", row.least, row.most);
    evaluator_.Error(
        scenario::kOutOfDomain, argument.value->span,
        fmt::format("the {} of {}() must be {}, not {}", is_median ? "median" : row.name,
                    call_.text, wanted, number->Text()));
    return false;
  }

  const dsl::Expr& call_;
  const DistributionKind kind_;
  const scenario::Scope& scope_;
  Evaluator& evaluator_;
  const std::span<const PositiveArgument> row_;
  std::vector<std::optional<double>> values_;
};

}  // namespace

std::optional<Value> EvaluatePositive(const dsl::Expr& call, DistributionKind kind,
                                      const scenario::Scope& scope, Evaluator& evaluator) {
  return PositiveEvaluation(call, kind, scope, evaluator).Evaluate();
}

namespace {

using plan::TableError;

/// The values of a table, in SI units if their heading has one.
struct Measured {
  std::vector<double> values, weights;
  std::optional<text::Unit> unit;
};

/// True for a heading of numbers that count values, as `part` does.
bool IsOfWeights(const std::string& heading) {
  std::string word = plan::ParseColumnName(heading).stem;
  for (char& c : word)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  constexpr std::string_view kWords[] = {
      "weight",    "weights",     "part",      "parts",       "count", "counts", "number",
      "n",         "w",           "frequency", "frequencies", "share", "shares", "fraction",
      "fractions", "probability", "p",         "percent",     "%"};
  return std::ranges::find(kWords, word) != std::end(kWords);
}

/// A column that may have the values, for a suggestion: not a number or a name of the row.
std::size_t LikelyColumn(const plan::TextTable& table) {
  constexpr std::string_view kOfRows[] = {"",     "id",   "ID",     "Id",  "nr",  "Nr",
                                          "Nr.",  "no",   "No",     "No.", "#",   "index",
                                          "name", "Name", "sample", "t",   "time"};
  for (std::size_t i = 0; i < table.headings().size(); ++i)
    if (std::ranges::find(kOfRows, table.headings()[i]) == std::end(kOfRows)) return i;
  return 0;
}

/// The columns of a table in which none is named: values, or values and weights.
std::vector<plan::Column> UnnamedColumns(const plan::TextTable& table) {
  const std::string& place = table.PlaceOfHeadings();
  const auto shown = [&](std::size_t i) {
    return table.has_heading_line() ? table.headings()[i] : fmt::format("#{}", i + 1);
  };
  if (table.width() > 2)
    throw TableError(
        fmt::format("{}: it has {} columns, {}", place, table.width(), table.ColumnList()),
        fmt::format("name the one of the values: column: \"{}\"",
                    text::Printable(shown(LikelyColumn(table)))));
  if (table.width() == 2 && table.has_heading_line() && !IsOfWeights(table.headings()[1]))
    throw TableError(
        fmt::format("{}: it has two columns, `{}` and `{}`, and the second may not be weights",
                    place, text::Printable(shown(0)), text::Printable(shown(1))),
        fmt::format("name the one of the values: column: \"{}\"; and that of the weights, if there "
                    "is one: weight: \"{}\"",
                    text::Printable(shown(1)), text::Printable(shown(0))));
  std::vector<plan::Column> columns;
  for (std::size_t i = 0; i < table.width(); ++i) {
    if (table.has_heading_line()) {
      const plan::ColumnName name = plan::ParseColumnName(table.headings()[i]);
      if (i == 0 && name.unit && plan::InSi(1, *name.unit) != 1)
        throw TableError(fmt::format("{}: the values are in {}", place, name.unit_text),
                         fmt::format("write column: \"{}\", and no unit after the parentheses",
                                     text::Printable(table.headings()[i])));
    }
    columns.push_back({i, i == 0 ? "the value" : "the weight", std::nullopt});
  }
  return columns;
}

Measured ReadMeasured(std::string_view text, const std::string& path, const schema::Call& call) {
  const schema::Text* named[] = {AsText(schema::ArgumentOf(call, "column")),
                                 AsText(schema::ArgumentOf(call, "weight"))};
  plan::Dialect dialect = plan::DialectOf(call);
  dialect.has_trailing_comments = named[0] == nullptr;
  plan::TextTable table(text, path, dialect);
  std::vector<plan::Column> columns;
  if (named[0] == nullptr && named[1] != nullptr)
    throw TableError(fmt::format("{}: only the column of the weights is named", path),
                     "name the one of the values, too: column: \"#1\"");
  if (table.rows() == 0)
    throw TableError(fmt::format("'{}' contains no value", path), "write a value in each line");
  for (const schema::Text* name : named)
    if (name != nullptr) columns.push_back(table.Find(name->text));
  if (columns.empty()) columns = UnnamedColumns(table);
  table.FindDecimal(columns);
  if (table.rows() > kMaxTableValues)
    throw TableError(
        fmt::format("{}: more than {} values", table.Place(kMaxTableValues), kMaxTableValues),
        "count equal values, and write the counts as weights");
  Measured measured{{}, {}, columns[0].unit};
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double value = table.Number(row, columns[0]);
    const double weight = columns.size() > 1 ? table.Number(row, columns[1]) : 1;
    if (weight < 0)
      throw TableError(fmt::format("{}: the weight is {}, less than 0", table.Place(row),
                                   table.Cell(row, columns[1].index)),
                       "a weight is 0 or more");
    if (weight == 0) continue;
    measured.values.push_back(value);
    if (columns.size() > 1) measured.weights.push_back(weight);
  }
  if (measured.values.empty())
    throw TableError(fmt::format("{}: all weights are 0", path), "write a weight more than 0");
  return measured;
}

/// The values of the table, and its path; nullopt after a diagnostic.
std::optional<std::pair<Measured, std::string>> MeasuredIn(const Expr& call,
                                                           const scenario::Scope& scope,
                                                           Evaluator& evaluator) {
  const bool is_text = !call.arguments.empty() && !call.arguments[0].name &&
                       call.arguments[0].value->kind == dsl::ExprKind::kText;
  if (!is_text)
    return evaluator.Error(scenario::kBadArguments, call.span,
                           "empirical() takes the name of a file in quotes",
                           "write empirical(\"sizes.csv\")");
  const auto arguments = EvaluateArguments(call, schema::EmpiricalTable(), scope, evaluator);
  if (!arguments) return std::nullopt;
  const Expr& name = *call.arguments[0].value;
  const auto folder = std::filesystem::path(name.span.source->name()).parent_path();
  std::string path = (folder / name.text).lexically_normal().string();
  std::string why;
  const auto text = evaluator.scenario().TextOf(path, why);
  if (!text)
    return evaluator.Error(scenario::kNoSuchFile, name.span,
                           fmt::format("cannot read '{}': {}", path, why),
                           "the path is relative to the folder of the .cdb file that names it");
  try {
    return std::pair(ReadMeasured(*text, path, *arguments), std::move(path));
  } catch (const TableError& error) {
    return evaluator.Error(scenario::kBadTable, name.span, error.what(), error.remedy);
  }
}

}  // namespace

std::optional<schema::Value> EvaluateEmpirical(const dsl::Expr& call, const scenario::Scope& scope,
                                               Evaluator& evaluator) {
  const auto found = MeasuredIn(call, scope, evaluator);
  if (!found) return std::nullopt;
  const auto& [measured, path] = *found;
  schema::Distribution table{DistributionKind::kEmpirical, {}, measured.weights};
  for (const double value : measured.values) table.arguments.emplace_back(value);
  table.file = path;
  return table;
}

std::optional<text::Unit> UnitOfEmpirical(const dsl::Expr& call, const scenario::Scope& scope,
                                          const Evaluator& evaluator) {
  dsl::Diagnostics reported_by_evaluation;
  Evaluator quiet(evaluator.scenario(), evaluator.layers(), reported_by_evaluation);
  const auto found = MeasuredIn(call, scope, quiet);
  return found ? found->first.unit : std::nullopt;
}

}  // namespace cdb::evaluate
