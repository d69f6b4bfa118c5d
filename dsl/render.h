// Diagnostics as text for people.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"

namespace cdb::dsl {

struct RenderOptions {
  bool color = false;  ///< ANSI colours, for a terminal
  /// The maximum number of errors, and of warnings, shown; the number left out is stated at the
  /// end.
  std::size_t most = static_cast<std::size_t>(-1);
};

/// All diagnostics, ordered by file and location, each as
///
///     examples/first.cdb:4:13: error: no object type is called 'cuboyd' [E0201 unknown-name]
///       4 |   type      cuboyd
///         |             ^^^^^^ did you mean 'cuboid'?
///
/// with its notes below in the same form. Tabs are kept in step, and wide lines are cut around the
/// fault. Ends with a newline unless it is empty; empty if there are no diagnostics.
std::string Render(const Diagnostics& diagnostics, const RenderOptions& options = {});
/// Renders a single diagnostic.
std::string Render(const Diagnostic& diagnostic, const RenderOptions& options = {});

/// Ordered by file, in order of first appearance, then by location. Those without a location come
/// first.
std::vector<const Diagnostic*> InOrder(const Diagnostics& diagnostics);

}  // namespace cdb::dsl
