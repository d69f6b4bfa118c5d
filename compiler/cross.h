// A plan over one more axis than its file has: what a command line sweeps.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::compiler {

/// The plan with an axis `parameter` of the world in front of the others, one of `words` for each
/// of its values, all of which the schema or, where it takes detectors, `plugins` has. A plan that
/// sweeps the parameter itself is given back as it is.
plan::Plan Cross(const plan::Plan& plan, schema::WorldParameter parameter,
                 const std::vector<std::string>& words,
                 std::span<const schema::PluginDetector> plugins = {});

}  // namespace cdb::compiler
