#include "runtime/statistics/selection.h"

#include <fmt/format.h>

#include <set>

#include "runtime/statistics/axis_values.h"
#include "runtime/statistics/cells.h"

namespace cdb::statistics {

void SelectPart(store::ResultFile& file, const std::vector<std::string>& selections) {
  std::set<std::string> seen;
  for (const std::string& word : selections) {
    const auto [name, text] = ParseSelection(word);
    const std::size_t at = FindAxis(file, name);
    if (!seen.insert(name).second)
      throw files::StoreError(fmt::format(
          "--select names the axis '{}' twice: list its values in one, as {}=A,B", name, name));
    const plan::Axis& axis = file.axes()[at];
    const NamedValues values = FindValues(axis, text);
    if (!values.unknown.empty())
      throw files::StoreError(fmt::format("the axis '{}' has no value {}; it has {}", name,
                                          values.unknown[0].empty() ? "''" : values.unknown[0],
                                          ValuesText(axis)));
    file.Select(at, values.indices);
  }
}

}  // namespace cdb::statistics
