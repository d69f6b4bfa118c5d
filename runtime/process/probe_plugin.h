// Lists the detectors of a plug-in without loading it into this process.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/schema/plugins.h"

namespace cdb::process {

/// A library that has not said what it offers by then is given up.
inline constexpr double kProbeSeconds = 10;

/// Has `worker` load the library in a process of its own, which is ended after `seconds`. The
/// detectors with name, phases and limit; nullopt, and why, for a library that cannot be loaded,
/// speaks another interface, crashes or hangs. Throws ScheduleError where no process can be
/// started. Threads: any.
std::optional<std::vector<schema::PluginDetector>> ProbePlugin(const std::filesystem::path& worker,
                                                               const std::string& path,
                                                               std::string& why,
                                                               double seconds = kProbeSeconds);

}  // namespace cdb::process
