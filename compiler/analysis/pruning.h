// Omissions that follow from the settings of a scene alone. `cdb doc omit` prints the table of
// components.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/schema/components.h"

namespace cdb::analysis {

enum class Decision {
  kLeftOut,
  kKept,
  kAbsent,  ///< the scene does not have it anyway (walls in a scene without walls)
  kOpen,    ///< the worker decides when the objects are drawn and placed
};

/// The decision about one component in one run, and the number that decides it.
struct PruningDecision {
  schema::Component component;
  Decision decision;
  std::string why;  ///< `no object has ccd`; for people
  bool operator==(const PruningDecision&) const = default;
};

/// One for each component, in the order of the table. `omit none` keeps all components; a list
/// keeps those that it does not name.
std::vector<PruningDecision> AnalysePruning(const plan::Scene& scene);

/// How `omit` requests a component: by name, by `auto`, which does not include every component, or
/// not at all.
enum class PruningRequest { kNo, kAuto, kByName };
PruningRequest RequestFor(const plan::Scene& scene, schema::Component component);

/// One line per component: `walls: left out: ...`. Stored in results as `needs`.
std::string DecisionsText(std::span<const PruningDecision> decisions);
/// The names of the components left out, separated by spaces. Stored in results as `omitted`.
std::string OmittedNames(std::span<const PruningDecision> decisions);
/// True if DecisionsText states that the component was present: not left out, and not absent from
/// the scene anyway.
bool SaysKept(std::string_view decisions_text, schema::Component component);

}  // namespace cdb::analysis
