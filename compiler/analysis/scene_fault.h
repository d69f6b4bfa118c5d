// Why a scene cannot be built as its settings say, though each of them is valid by itself.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

struct SceneFault {
  enum class Kind {
    kPlacement,   ///< an object cannot be where its layout puts it, or the objects cannot fit
    kClosedForm,  ///< `accuracy.closed_form` is not the solution of this scene
  };
  Kind kind = Kind::kPlacement;
  std::string group;           ///< of the objects to blame; empty where it is none alone
  std::string cause, remedy;   ///< `remedy` is empty where the cause says it
  std::string parameter = {};  ///< whose value is to blame; empty where it is none alone
};

/// Looks at a scene; nullopt where nothing is wrong. A function, as only the library knows layouts
/// and closed forms.
using FindSceneFault = std::function<std::optional<SceneFault>(const plan::Scene& scene)>;

}  // namespace cdb::analysis
