// Figures of queries (`queries { }`): times, hits, and errors against exact answers.
#pragma once

#include <span>

#include "runtime/figures/points.h"

namespace cdb::figures {

/// Of one type of queries, over the cycles of some points and their repeats. NaN: not recorded.
struct QueryFigures {
  double count, hits;              ///< means of a cycle
  double time_ns, update_ns;       ///< means of a cycle: of the queries, and of cdb's own tree
  double ns_per_query;             ///< over all queries
  double compared, missed, wrong;  ///< sums; of `wrong`, false hits
  double error, normal_error;      ///< the largest; m, rad

  /// True if any such query was asked.
  bool HasQueries() const { return count > 0 || compared > 0 || time_ns > 0; }
};

/// True if some run has queries.
bool HasQueries(const results::ResultFile& file);

/// Throws StoreError.
QueryFigures QueriesOf(const results::ResultFile& file,
                       std::span<const MeasuredPoint* const> points, schema::QueryType type);

}  // namespace cdb::figures
