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
  kAbsent,  ///< the scene has none anyway (walls where none stand)
  kOpen,    ///< the worker decides when the objects are drawn and placed
};

/// What becomes of one component in one run, and the number that decides it.
struct PruningDecision {
  schema::Component component;
  Decision decision;
  std::string why;  ///< `no object has ccd`; for people
  bool operator==(const PruningDecision&) const = default;
};

/// One for each component, in the order of the table. `omit none` keeps all; a list keeps what it
/// does not name.
std::vector<PruningDecision> AnalysePruning(const plan::Scene& scene);

/// How `omit` asks for a component: by its name, by `auto`, which not all are part of, or not at
/// all.
enum class PruningRequest { kNo, kAuto, kByName };
PruningRequest RequestFor(const plan::Scene& scene, schema::Component component);

/// One line for each: `walls: left out: ...`. The text that results carry as `needs`.
std::string DecisionsText(std::span<const PruningDecision> decisions);
/// The names of those left out, separated by spaces: what results carry as `omitted`.
std::string OmittedNames(std::span<const PruningDecision> decisions);
/// DecisionsText says that the component was there: not left out, and not absent from the scene
/// anyway.
bool SaysKept(std::string_view decisions_text, schema::Component component);

}  // namespace cdb::analysis
