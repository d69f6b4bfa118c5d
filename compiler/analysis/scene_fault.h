// The reason why a scene cannot be built from its settings, although each of them is valid by
// itself.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"
#include "compiler/schema/schema.h"

namespace cdb::analysis {

struct SceneFault {
  enum class Kind {
    kPlacement,   ///< the layout cannot place an object, or the objects do not fit
    kClosedForm,  ///< `accuracy.closed_form` is not the solution of this scene
  };
  Kind kind = Kind::kPlacement;
  std::string group;           ///< of the objects at fault; empty if no single group is
  std::string cause, remedy;   ///< `remedy` is empty if the cause implies it
  std::string parameter = {};  ///< whose value is at fault; empty if no single parameter is
};

/// Checks a scene; nullopt if it has no fault. A function, because only the library knows layouts
/// and closed forms. `draws`: how many random positions may still be drawn, reduced by those that
/// were; a crowded scene that needs more shows its fault in the run.
using FindSceneFault =
    std::function<std::optional<SceneFault>(const plan::Scene& scene, std::uint64_t& draws)>;

/// A setting that the rest of a scene rules out.
struct SettingFault {
  std::string group;                   ///< empty for a parameter of the world
  const schema::Parameter* parameter;  ///< whose value is at fault
  std::string word = {};               ///< of a list
  std::string message, help;
};

}  // namespace cdb::analysis
