// Diagnostics as a person reads them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"

namespace cdb::dsl {

struct RenderOptions {
  bool color = false;  ///< ANSI colours, for a terminal
  /// Errors, and warnings, that are shown; the number of the rest is said at the end.
  std::size_t most = static_cast<std::size_t>(-1);
};

/// All diagnostics by file and place, each as
///
///     examples/first.cdb:4:13: error: no object type is called 'cuboyd' [E0201 unknown-name]
///       4 |   type      cuboyd
///         |             ^^^^^^ did you mean 'cuboid'?
///
/// with notes below it in the same form. Tabs are kept in step, wide lines are cut around the
/// fault. Ends with a newline where there is anything; empty where there is nothing.
std::string Render(const Diagnostics& diagnostics, const RenderOptions& options = {});
/// One of them.
std::string Render(const Diagnostic& diagnostic, const RenderOptions& options = {});

/// By file, in the order in which files first appear, and place. What has no place comes first.
std::vector<const Diagnostic*> InOrder(const Diagnostics& diagnostics);

}  // namespace cdb::dsl
