// The detectors of a shared library as text: the process that loads the library sends it to others.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/plugins.h"
#include "library/detectors/detector.h"

namespace cdb::detectors {

/// One line for each detector: name, phases, maximum number of bodies and doc, separated by tabs.
std::string DescriptionOf(const Plugin& plugin);

/// The inverse, without path and hash; nullopt if the text is not the output of DescriptionOf.
std::optional<std::vector<schema::PluginDetector>> ReadDescription(std::string_view text);

/// With this option and a library, a worker writes the description to standard output and exits
/// with status 0, or writes an error message and exits with status kNoPlugin.
inline constexpr const char* kDescribeOption = "--describe";
inline constexpr int kNoPlugin = 1;

}  // namespace cdb::detectors
