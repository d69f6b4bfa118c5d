// Values of an axis as the user writes them: `detector=dbvt`, `hz=60,120`, `quantity=10..100`
// (`--select` of `cdb show`, `cdb compare` and `cdb view`); and a part of a results file by such
// values.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/store.h"

namespace cdb::figures {

/// `axis=text`.
struct AxisSelection {
  std::string axis, text;
};
/// Throws files::StoreError for a word of another form.
AxisSelection ParseSelection(const std::string& word);

struct NamedValues {
  std::vector<std::size_t> indices;  ///< ascending
  std::vector<std::string> unknown;  ///< parts of the text that match no value of the axis
};
/// The text is a value, several values separated by commas, or, on an axis of numbers, `a..b`
/// including both ends. A number is written as its label or in full. If neither matches, it denotes
/// the nearest value within 1e-4 of its size, because tables show four digits.
NamedValues FindValues(const plan::Axis& axis, const std::string& text);

/// The labels of the values at `indices`, or of all: `1, 2, 5`.
std::string ValuesText(const plan::Axis& axis, const std::vector<std::size_t>& indices);
std::string ValuesText(const plan::Axis& axis);

/// Each of `selections` is `axis=value`, `axis=a,b` or `axis=a..b` (FindValues). Throws
/// StoreError that names the axes of the file, or the values of the axis.
void SelectPart(results::ResultFile& file, const std::vector<std::string>& selections);

}  // namespace cdb::figures
