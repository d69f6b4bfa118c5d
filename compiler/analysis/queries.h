// Queries of a scene: what the settings of a block mean, and which cannot be asked.
#pragma once

#include <optional>
#include <string>

#include "compiler/plan/plan.h"
#include "compiler/schema/series.h"

namespace cdb::analysis {

/// For messages: `the queries sight`.
std::string TextOf(const plan::Queries& queries);
schema::QueryType TypeOf(const plan::Queries& queries);
/// True for rays and sweeps, which move; the others stay where they are.
bool Moves(schema::QueryType type);

/// True if the scene asks anything.
bool HasQueries(const plan::Scene& scene);
/// The first block that Bullet answers; null if there is none. Its answers need the broad phase.
const plan::Queries* FindBulletQueries(const plan::Scene& scene);

struct QueryFault {
  schema::GroupParameter parameter;  ///< whose value is at fault
  std::string message;
  std::string help;
};

/// The reason why these queries cannot be asked; nullopt if they can.
std::optional<QueryFault> FindQueryFault(const plan::Queries& queries);

}  // namespace cdb::analysis
