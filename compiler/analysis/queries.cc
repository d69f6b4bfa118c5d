#include "compiler/analysis/queries.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "dsl/text/check.h"

namespace cdb::analysis {
namespace {

using schema::GroupParameter;
using schema::QueryType;

/// A setting, and the types of queries that take it.
struct Part {
  GroupParameter parameter;
  const char* what;
  bool of_ray, of_sweep, of_overlap, of_nearest;

  bool IsOf(QueryType type) const {
    switch (type) {
      case QueryType::kRay:
        return of_ray;
      case QueryType::kSweep:
        return of_sweep;
      case QueryType::kOverlap:
        return of_overlap;
      case QueryType::kNearest:
        return of_nearest;
    }
    CDB_CHECK(false);
  }
};

constexpr Part kParts[] = {
    {"queries.direction", "direction", true, true, false, false},
    {"queries.to", "end", true, true, false, false},
    {"queries.length", "length", true, true, false, true},
    {"queries.shape", "shape", false, true, true, true},
    {"queries.size", "size", false, true, true, true},
    {"queries.aspect", "aspect", false, true, true, true},
    {"queries.hits", "choice of hits", true, true, true, false},
};

bool HasNumber(const plan::Queries& queries, GroupParameter parameter) {
  return queries.settings.Has(*parameter);
}

}  // namespace

std::string TextOf(const plan::Queries& queries) {
  return queries.name == schema::kQueriesBlock ? "the queries" : "the queries " + queries.name;
}

QueryType TypeOf(const plan::Queries& queries) {
  const auto* word =
      std::ranges::find(schema::kQueryTypes, queries.settings.WordOr("queries.type"));
  CDB_CHECK(word != std::end(schema::kQueryTypes));
  return static_cast<QueryType>(word - std::begin(schema::kQueryTypes));
}

bool Moves(QueryType type) { return type == QueryType::kRay || type == QueryType::kSweep; }

bool HasQueries(const plan::Scene& scene) { return scene.QueryCount() > 0; }

const plan::Queries* FindBulletQueries(const plan::Scene& scene) {
  for (const plan::Queries& queries : scene.queries)
    if (queries.settings.Count("queries.count") > 0 &&
        queries.settings.WordOr("queries.implementation") == "bullet")
      return &queries;
  return nullptr;
}

std::optional<QueryFault> FindQueryFault(const plan::Queries& queries) {
  const QueryType type = TypeOf(queries);
  const std::string_view word = queries.settings.WordOr("queries.type");
  for (const Part& part : kParts)
    if (!part.IsOf(type) && HasNumber(queries, part.parameter))
      return QueryFault{
          part.parameter,
          fmt::format("{} have no {}, as their type is {}", TextOf(queries), part.what, word),
          "remove it, or change the type"};
  if (HasNumber(queries, "queries.to"))
    for (const Part& part : {kParts[0], kParts[2]})
      if (HasNumber(queries, part.parameter))
        return QueryFault{part.parameter,
                          fmt::format("{} have an end and a {}", TextOf(queries), part.what),
                          "remove one of them"};
  if (type == QueryType::kNearest && queries.settings.WordOr("queries.implementation") == "bullet")
    return QueryFault{"queries.implementation",
                      fmt::format("bullet does not answer {}: it has no query for the nearest body",
                                  TextOf(queries)),
                      "write implementation tree"};
  return std::nullopt;
}

}  // namespace cdb::analysis
