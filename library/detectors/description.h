// What a shared library offers, as text: what the process that dares to load it tells the others.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/plugins.h"
#include "library/detectors/detector.h"

namespace cdb::detectors {

/// A line for each detector: name, phases, most bodies and what it is, a tab between.
std::string DescriptionOf(const Plugin& plugin);

/// Back again, without path and hash; nullopt for a text that DescriptionOf has not written.
std::optional<std::vector<schema::PluginDetector>> ReadDescription(std::string_view text);

/// A worker that is given this and a library writes the description on standard output, exit status
/// 0; or what is wrong with the library, exit status kNoPlugin.
inline constexpr const char* kDescribeOption = "--describe";
inline constexpr int kNoPlugin = 1;

}  // namespace cdb::detectors
