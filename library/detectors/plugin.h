// Loads shared libraries with detectors: plug-ins, and the third-party detectors included in cdb.
#pragma once

#include <cfenv>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "library/detectors/detector.h"
#include "library/detectors/detector_c.h"

namespace cdb::detectors {

/// A shared library cannot be used; the message gives the reason and a remedy.
class PluginError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A detector of either interface, C++ or C.
struct LoadedDetector {
  explicit LoadedDetector(const DetectorEntry& entry);
  explicit LoadedDetector(const cdb_detector& row);

  std::string name;
  Phases phases{};
  std::uint64_t max_bodies = 0;
  std::function<std::unique_ptr<Detector>(const Options&)> make;  ///< may return null, or throw
};

/// Loads `path` and checks its ABI. The library stays loaded until the process ends. Throws
/// PluginError if there is no such file, no list of detectors in it, another ABI or standard
/// library, or a detector without name, function or phase or with an invalid or duplicate name.
/// Runs the initializers of the library, which may do anything; the caller's floating-point
/// environment is restored after them. Threads: any.
std::vector<LoadedDetector> LoadPlugin(const std::string& path);

// The checks of LoadPlugin, and of ReadManifest on the file: each throws PluginError
// if it fails.
/// `own`: kDetectorAbi or CDB_C_ABI.
void CheckAbi(std::uint32_t abi, std::uint32_t own, const std::string& path);
/// `shown`: a printable form of the name for messages.
void CheckName(std::string_view name, const std::string& shown, const std::string& path);
[[noreturn]] void RefuseBuild(const std::string& build, const std::string& path);

/// Null if there is none with this name.
const LoadedDetector* FindDetector(const std::vector<LoadedDetector>& detectors,
                                   std::string_view name);

}  // namespace cdb::detectors

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace cdb::detectors {

// Preserves the floating-point environment of a thread across a call into foreign code.

/// Saves the environment, and restores it at the end of its scope: the rounding mode and, on
/// x86-64, the treatment of denormals and the exceptions that trap. Flags of exceptions that
/// occurred are not included. Threads: affects the calling thread only.
class KeepsFloatingPoint {
 public:
  KeepsFloatingPoint() : saved_(Read()) {}
  ~KeepsFloatingPoint() {
    if (IsChanged()) Write(saved_);
  }
  KeepsFloatingPoint(const KeepsFloatingPoint&) = delete;
  KeepsFloatingPoint& operator=(const KeepsFloatingPoint&) = delete;

  bool IsChanged() const { return Read() != saved_; }

 private:
#if defined(__x86_64__)
  static constexpr unsigned kFlags = 0x3f;  ///< of MXCSR: exceptions that occurred
  static unsigned Read() { return _mm_getcsr() & ~kFlags; }
  static void Write(unsigned environment) { _mm_setcsr(environment); }
  const unsigned saved_;
#else
  static int Read() { return std::fegetround(); }
  static void Write(int environment) { std::fesetround(environment); }
  const int saved_;
#endif
};

// The detectors of a shared library, read from its file without loading it: a loaded library may
// run any code, and a scenario that is only inspected must not do that.

/// The detectors of the library with these bytes, in its order, without path and hash, from the
/// text that CDB_DETECTORS or CDB_C_DETECTORS stores in its section kManifestSection. `path` is for
/// messages. Throws PluginError if it is not an ELF file for this machine, has no such text, or has
/// one of another interface, of another standard library, or with an invalid or duplicate name.
/// Threads: any.
std::vector<schema::PluginDetector> ReadManifest(std::string_view bytes, const std::string& path);

}  // namespace cdb::detectors
