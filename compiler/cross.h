// Adds an axis to a plan: the parameter swept on a command line.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::compiler {

/// The plan with an axis for `parameter` of the world in front of the others, with `words` as its
/// values, all of which must be known to the schema or, for detectors, be in `plugins`. A plan that
/// already sweeps the parameter is returned unchanged.
plan::Plan Cross(const plan::Plan& plan, schema::WorldParameter parameter,
                 const std::vector<std::string>& words,
                 std::span<const schema::PluginDetector> plugins = {});

}  // namespace cdb::compiler
