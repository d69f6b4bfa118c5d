#include "runtime/results/dimensions.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "compiler/schema/schema.h"

namespace cdb::results {
namespace {

using hdf5::Type;

/// Separators of `labels`, in order of preference.
constexpr std::string_view kSeparators = " ;|\t\n";

/// The parameter's description in the schema, or the axis' own name for a `let` or `cases`.
std::string LongName(const plan::Axis& axis) {
  const std::string_view name = axis.parameter;
  const schema::Parameter* row = schema::FindParameter(name, false);
  if (row == nullptr) row = schema::FindParameter(name.substr(name.find('.') + 1), true);
  return std::string(row != nullptr ? row->doc : axis.name);
}

}  // namespace

std::vector<double> Indices(std::uint64_t n) {
  std::vector<double> indices(n);
  for (std::size_t i = 0; i < n; ++i) indices[i] = static_cast<double>(i);
  return indices;
}

Dimension Counted(std::string name, std::uint64_t size, std::string doc) {
  return {std::move(name),
          size,
          Type::kInt32,
          Indices(size),
          {},
          {{"units", kNoUnit}, {"long_name", std::move(doc)}},
          {}};
}

Dimension Labelled(std::string name, std::vector<std::string> texts, std::string doc) {
  Dimension dimension{std::move(name), texts.size(), Type::kText, {}, {}, {}, {}};
  for (const char separator : kSeparators) {
    const bool is_free = std::ranges::all_of(texts, [&](const std::string& text) {
      return !text.empty() && text.find(separator) == std::string::npos;
    });
    if (!is_free) continue;
    std::string labels = fmt::format("{}", fmt::join(texts, std::string(1, separator)));
    if (labels.size() > 32000)
      break;  // an attribute has a limited size; the dataset has all
              // labels
    dimension.attributes = {{"labels", std::move(labels)},
                            {"labels_separator", std::string(1, separator)}};
    break;
  }
  if (!doc.empty()) dimension.attributes.emplace("long_name", std::move(doc));
  dimension.texts = std::move(texts);
  return dimension;
}

Dimension AxisDimension(const plan::Axis& axis, bool is_integer) {
  Dimension dimension;
  if (axis.IsText()) {
    std::vector<std::string> texts;
    for (const auto& value : axis.values) texts.push_back(std::get<std::string>(value));
    dimension = Labelled(axis.name, std::move(texts), "");
  } else {
    dimension.name = axis.name;
    dimension.size = axis.values.size();
    dimension.type = is_integer ? Type::kInt32 : Type::kFloat64;
    for (const auto& value : axis.values) dimension.numbers.push_back(std::get<double>(value));
  }
  dimension.attributes.emplace("parameter", axis.parameter);
  dimension.attributes.emplace("units", axis.unit.empty() && !axis.IsText() ? kNoUnit : axis.unit);
  dimension.attributes.emplace("long_name", LongName(axis));
  return dimension;
}

}  // namespace cdb::results
