// What a run can leave out, as far as its numbers alone can tell. Source: issue "Leave out what a
// scene does not need"; `cdb doc omit` prints the table.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan.h"

namespace cdb::compiler {

/// The parts of the engine that a scene may do without, in the order of the table.
enum class Component {
  kWalls,
  kRaycastTree,
  kDetection,
  kSolver,
  kSleeping,
  kSweptContacts,
  kGravity,
  kDamping,
  kRotation,
  kMotionStates,
  kStaticBoxes,
  kPools,
};

/// One row of THE table of components.
struct ComponentInfo {
  Component component;
  std::string_view name;     ///< the word that `omit` takes
  std::string_view doc;      ///< what it is, one line
  std::string_view changes;  ///< what of the measurement changes without it; empty: nothing does
  /// Every summary names it where it is left out.
  bool IsVisible() const { return !changes.empty(); }
};
std::span<const ComponentInfo> Components();
const ComponentInfo& InfoOf(Component component);
/// Null where there is none.
const ComponentInfo* FindComponent(std::string_view name);

enum class Fate {
  kLeftOut,
  kKept,
  kAbsent,  ///< the scene has none anyway (walls where none stand)
  kOpen,    ///< the worker decides when the objects are drawn and placed
};

/// What becomes of one component in one run, and the number that decides it.
struct Need {
  Component component;
  Fate fate;
  std::string why;  ///< `no object has ccd`; for people
  bool operator==(const Need&) const = default;
};

/// One for each component, in the order of the table. `omit none` keeps all; a list keeps what it
/// does not name.
std::vector<Need> AnalyseNeeds(const Scene& scene);

/// How `omit` asks for a component: by its name, by `auto`, or not at all.
enum class Asked { kNo, kAuto, kByName };
Asked HowAsked(const Scene& scene, Component component);

/// One line for each: `walls: left out: ...`. The text that results carry as `needs`.
std::string NeedsText(std::span<const Need> needs);
/// The names of those left out, separated by spaces: what results carry as `omitted`.
std::string OmittedNames(std::span<const Need> needs);

}  // namespace cdb::compiler
