#include "compiler/evaluate/empirical.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/text/characters.h"
#include "dsl/text/utf8.h"

namespace cdb::evaluate {
namespace {

std::string_view TrimmedField(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) + 1 - first);
}

std::optional<double> TableNumber(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// A heading is a word: `size_mm`, `"size"`.
bool IsHeading(std::string_view field) {
  return !field.empty() && (field[0] == '"' || text::IsLetter(field[0]));
}

/// Reads a table line by line; `fault` describes the error in the line added last.
class TableReader {
 public:
  bool Add(std::string_view line) {
    line = TrimmedField(line.substr(0, line.find('#')));
    if (line.empty()) return true;
    const std::vector<std::string_view> fields = Split(line);
    if (std::exchange(is_first_, false) && IsHeading(fields[0])) return true;
    if (fields.size() > 2)
      return Refuse(
          fmt::format("{} columns; a table has a column of values, and may have one of weights",
                      fields.size()));
    if (columns_ != 0 && fields.size() != columns_)
      return Refuse(fmt::format("{} column{}, but {} in the lines before", fields.size(),
                                fields.size() == 1 ? "" : "s", columns_));
    columns_ = fields.size();
    if (table_.arguments.size() == kMaxTableValues)
      return Refuse(fmt::format("more than {} values", kMaxTableValues));
    return AddValue(fields[0]) && (fields.size() == 1 || AddWeight(fields[1]));
  }

  schema::Distribution& table() { return table_; }
  const std::string& fault() const { return fault_; }

 private:
  static std::vector<std::string_view> Split(std::string_view line) {
    std::vector<std::string_view> fields;
    for (std::size_t comma = 0; comma != std::string_view::npos;) {
      comma = line.find(',');
      fields.push_back(TrimmedField(line.substr(0, comma)));
      if (comma != std::string_view::npos) line.remove_prefix(comma + 1);
    }
    return fields;
  }

  bool AddValue(std::string_view field) {
    const auto value = TableNumber(field);
    if (!value) return Refuse(fmt::format("'{}' is not a finite number", text::Printable(field)));
    table_.arguments.emplace_back(*value);
    return true;
  }

  bool AddWeight(std::string_view field) {
    const auto weight = TableNumber(field);
    if (!weight || !(*weight > 0))
      return Refuse(fmt::format("'{}' is not a weight greater than 0", text::Printable(field)));
    table_.weights.push_back(*weight);
    return true;
  }

  bool Refuse(std::string fault) {
    fault_ = std::move(fault);
    return false;
  }

  schema::Distribution table_{schema::DistributionKind::kEmpirical, {}, {}};
  std::size_t columns_ = 0;
  bool is_first_ = true;
  std::string fault_;
};

}  // namespace

std::optional<schema::Value> EvaluateEmpirical(const dsl::Expr& call, Evaluator& evaluator) {
  const bool is_text = call.arguments.size() == 1 && !call.arguments[0].name &&
                       !call.arguments[0].weight &&
                       call.arguments[0].value->kind == dsl::ExprKind::kText;
  if (!is_text)
    return evaluator.Error(scenario::kBadArguments, call.span,
                           "empirical() takes the name of a file in quotes",
                           "write empirical(\"sizes.csv\")");
  const dsl::Expr& name = *call.arguments[0].value;
  const auto folder = std::filesystem::path(name.span.source->name()).parent_path();
  const std::string path = (folder / name.text).lexically_normal().string();
  std::string why;
  const auto text = evaluator.scenario().TextOf(path, why);
  if (!text)
    return evaluator.Error(scenario::kNoSuchFile, name.span,
                           fmt::format("cannot read '{}': {}", path, why),
                           "the path is relative to the folder of the .cdb file that names it");
  TableReader reader;
  std::string_view rest = *text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  for (std::size_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    if (!reader.Add(rest.substr(0, end)))
      return evaluator.Error(scenario::kBadTable, name.span,
                             fmt::format("{}:{}: {}", path, line, reader.fault()),
                             "a line contains a value, or a value, a comma and its weight");
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  schema::Distribution& table = reader.table();
  if (table.arguments.empty())
    return evaluator.Error(scenario::kBadTable, name.span,
                           fmt::format("'{}' contains no value", path));
  table.file = path;
  return std::move(table);
}

}  // namespace cdb::evaluate
