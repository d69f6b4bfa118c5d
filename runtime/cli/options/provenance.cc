#include "runtime/cli/options/provenance.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <fstream>
#include <string_view>
#include <thread>

#include "commit.h"

namespace cdb::options {
namespace {

/// The rest of the first line of `file` that begins with `key`, after `separator`; empty if there
/// is none.
std::string FindLine(const char* file, std::string_view key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t at = line.find(separator);
    if (at == std::string::npos) continue;
    std::string value = line.substr(at + 1);
    value.erase(0, value.find_first_not_of(" \t\""));
    value.erase(value.find_last_not_of(" \t\"") + 1);
    return value;
  }
  return {};
}

std::string FirstLine(const char* file) {
  std::string line;
  std::ifstream in(file);
  std::getline(in, line);
  return line;
}

}  // namespace

std::string BuildType() {
  std::string type = CDB_BUILD_TYPE;
  if (std::string_view(CDB_SANITIZERS) != "") type += fmt::format(" ({})", CDB_SANITIZERS);
  return type;
}

results::Provenance CollectProvenance() {
  results::Provenance facts;
  const auto add = [&](const char* name, std::string value) {
    if (!value.empty()) facts[name] = std::move(value);
  };
  add("cdb_version", CDB_VERSION);
  add("commit", CDB_COMMIT);
  add("build_type", BuildType());
  add("compiler", CDB_COMPILER);
  add("compiler_flags", CDB_FLAGS);
  add("bullet_version", CDB_BULLET_VERSION);
  add("cpu", FindLine("/proc/cpuinfo", "model name", ':'));
  add("cpus", fmt::format("{}", std::thread::hardware_concurrency()));
  add("memory", FindLine("/proc/meminfo", "MemTotal", ':'));
  // Not the current frequency, which changes from moment to moment.
  const std::string frequency = "/sys/devices/system/cpu/cpu0/cpufreq/";
  const auto add_clock = [&](const char* name, const char* file) {
    const std::string kilos = FirstLine((frequency + file).c_str());
    if (!kilos.empty()) add(name, kilos + " kHz");
  };
  add_clock("cpu_base_clock", "base_frequency");
  add_clock("cpu_max_clock", "cpuinfo_max_freq");
  add("cpu_governor", FirstLine((frequency + "scaling_governor").c_str()));
  add("system", FindLine("/etc/os-release", "PRETTY_NAME", '='));
  struct utsname system = {};
  if (uname(&system) == 0) {
    add("kernel", fmt::format("{} {} {}", system.sysname, system.release, system.machine));
    add("host", system.nodename);
  }
  return facts;
}

}  // namespace cdb::options
