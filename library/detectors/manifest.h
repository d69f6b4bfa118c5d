// The detectors of a shared library, read from its file without loading it: a loaded library may
// run any code, and a scenario that is only inspected must not do that.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/plugins.h"

namespace cdb::detectors {

/// The detectors of the library with these bytes, in its order, without path and hash, from the
/// text that CDB_DETECTORS stores in its section kManifestSection. `path` is for messages. Throws
/// PluginError if it is not an ELF file for this machine, has no such text, or has one of another
/// interface, of another standard library, or with an invalid or duplicate name. Threads: any.
std::vector<schema::PluginDetector> ReadManifest(std::string_view bytes, const std::string& path);

}  // namespace cdb::detectors
