#include "compiler/schema/result_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "compiler/schema/series.h"

namespace cdb::schema {
namespace {

/// `names`, and those of the rows of a table.
std::vector<std::string_view> NamesOf(std::vector<std::string_view> names, const auto& table) {
  for (const auto& row : table) names.push_back(row.name);
  return names;
}

}  // namespace

const std::vector<ResultNames>& ReservedNames() {
  static const std::vector<ResultNames> names = {
      {"a dimension of the results",
       NamesOf({"rep", "contact_row", "contact_side", "xyz"},
               std::span(kDimensions).first(static_cast<std::size_t>(Dimension::kSample)))},
      {"a series of the results", NamesOf({}, kSeries)},
      {"an array of contacts in the results",
       {"contact_body", "contact_point", "contact_normal", "contact_distance", "contact_first"}},
      {"a fact of each run in the results",
       NamesOf(
           {"status", "verdict", "first_bad_cycle", "n_cycles", "started", "load_average", "noise",
            "noise_cause", "state_hash", "run_id", "host", "message", "omitted", "needs"},
           kRunScalars)},
      {"a group of the results", {"run", "accuracy", "provenance"}},
      {"an array of /accuracy in the results", {"sample", "horizon", "step_size", "truth"}, true},
  };
  return names;
}

std::optional<std::string> FindNameClash(std::string_view axis,
                                         std::span<const ErrorInfo* const> errors) {
  for (const ResultNames& row : ReservedNames())
    if (std::ranges::find(row.names, axis) != row.names.end() &&
        (!row.only_with_errors || !errors.empty()))
      return std::string(row.kind);
  for (const ErrorInfo* error : errors)
    for (const char* ending : {"", "_floor", "_series"})
      if (axis == fmt::format("{}{}", error->name, ending))
        return fmt::format("an error of accuracy.metrics {}", error->metric);
  return std::nullopt;
}

}  // namespace cdb::schema
