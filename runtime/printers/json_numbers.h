// Numbers of a results document (results_document.h).
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

namespace cdb::printers {

/// Keys stay in the order in which they are written.
using Json = nlohmann::ordered_json;

/// `value` to `digits` significant digits; null if it is not finite.
Json JsonNumber(double value, int digits = 6);
Json JsonNumbers(const std::vector<double>& values, int digits = 6);

/// `of(i)` for each i below `count`.
template <typename Of>
Json JsonColumn(std::size_t count, Of of) {
  Json column = Json::array();
  for (std::size_t i = 0; i < count; ++i) column.push_back(of(i));
  return column;
}

/// Replaces every array below `columns` whose values are all equal by `{"constant": value}`.
Json FoldColumns(Json columns);

}  // namespace cdb::printers
