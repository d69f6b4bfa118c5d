// Loads shared libraries with detectors: plug-ins, and the third-party detectors included in cdb.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

#include "library/detectors/detector.h"

namespace cdb::detectors {

/// A shared library cannot be used; the message gives the reason and a remedy.
class PluginError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Loads `path` and checks its ABI. The library stays loaded until the process ends. Throws
/// PluginError if there is no such file, no cdb_plugin in it, another ABI or standard library, or
/// an entry without name, function or phase or with an invalid or duplicate name. Runs the
/// initializers of the library, which may do anything; the caller's floating-point environment is
/// restored after them. Threads: any.
const Plugin& LoadPlugin(const std::string& path);

// The checks of LoadPlugin, and of ReadManifest (manifest.h) on the file: each throws PluginError
// if it fails.
void CheckAbi(std::uint32_t abi, const std::string& path);
/// `shown`: a printable form of the name for messages.
void CheckName(std::string_view name, const std::string& shown, const std::string& path);
[[noreturn]] void RefuseBuild(const std::string& build, const std::string& path);

/// Null if there is none with this name.
const DetectorEntry* FindEntry(const Plugin& plugin, std::string_view name);

}  // namespace cdb::detectors
