#include "runtime/figures/queries.h"

#include <cmath>
#include <functional>
#include <vector>

namespace cdb::figures {
namespace {

struct Total {
  double sum = kNone, largest = kNone, count = 0;
  double Mean() const { return sum / count; }
};

/// Over the values of all cycles that have one.
Total TotalOf(std::span<const MeasuredPoint* const> points,
              const std::function<std::vector<double>(const Cell&)>& read) {
  Total total;
  for (const MeasuredPoint* point : points)
    for (const Cell& cell : point->cells)
      for (const double value : read(cell)) {
        if (!(value >= 0)) continue;
        total.sum = std::isnan(total.sum) ? value : total.sum + value;
        total.largest = std::fmax(total.largest, value);
        ++total.count;
      }
  return total;
}

}  // namespace

bool HasQueries(const results::ResultFile& file) {
  return file.Has("query_time") || file.Has("query_count") || file.Has("compared_queries");
}

QueryFigures QueriesOf(const results::ResultFile& file,
                       std::span<const MeasuredPoint* const> points, schema::QueryType type) {
  const auto total = [&](const char* series) {
    if (!file.Has(series)) return Total();
    return TotalOf(points,
                   [&](const Cell& cell) { return file.ReadOfQueries(series, type, cell); });
  };
  const Total counts = total("query_count"), times = total("query_time");
  Total updates;
  if (file.Has("query_update_time"))
    updates = TotalOf(points,
                      [&](const Cell& cell) { return file.ReadSeries("query_update_time", cell); });
  return {.count = counts.Mean(),
          .hits = total("query_hits").Mean(),
          .time_ns = times.Mean(),
          .update_ns = updates.Mean(),
          .ns_per_query = counts.sum > 0 ? times.sum / counts.sum : kNone,
          .compared = total("compared_queries").sum,
          .missed = total("missed_hits").sum,
          .wrong = total("false_hits").sum,
          .error = total("hit_error").largest,
          .normal_error = total("hit_normal_error").largest};
}

}  // namespace cdb::figures
