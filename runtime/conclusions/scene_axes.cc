#include "runtime/conclusions/scene_axes.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "compiler/schema/schema.h"

namespace cdb::conclusions {
namespace {

bool IsOfScene(const plan::Axis& axis) {
  if (axis.parameter.empty()) return axis.IsText();  // `cases`; a `let` may be either
  for (const schema::Parameter& parameter : schema::Schema()) {
    // A group's name precedes its parameter: `pebbles.size`.
    const bool is_it = parameter.grouped
                           ? axis.parameter.ends_with("." + std::string(parameter.name))
                           : axis.parameter == parameter.name;
    if (is_it) return parameter.concern == schema::Concern::kScene;
  }
  return false;
}

}  // namespace

std::vector<std::size_t> SceneAxes(const store::ResultFile& file) {
  std::vector<std::size_t> axes;
  for (std::size_t i = 0; i < file.axes().size(); ++i)
    if (IsOfScene(file.axes()[i])) axes.push_back(i);
  return axes;
}

}  // namespace cdb::conclusions
