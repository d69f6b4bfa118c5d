// Opens shared libraries with detectors: plug-ins, and the rivals that come with cdb.
#pragma once

#include <stdexcept>
#include <string>

#include "library/detectors/detector.h"

namespace cdb::detectors {

/// A shared library that cannot be used; says why and what to do.
class PluginError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Loads `path` and checks that it speaks this ABI. It stays loaded to the end of the process.
/// Throws PluginError: no such file, no cdb_plugin in it, another ABI or standard library, an entry
/// without name, function or phase, or with a name that is none or taken. Runs the library's
/// initializers, which may do anything. Threads: any.
const Plugin& LoadPlugin(const std::string& path);

/// Null where there is none of that name.
const DetectorEntry* FindEntry(const Plugin& plugin, std::string_view name);

}  // namespace cdb::detectors
