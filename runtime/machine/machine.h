// What of a machine makes timings doubtful: its settings, and who else is at work.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cdb::machine {

/// One line of `cdb doctor`.
struct MachineFact {
  std::string name, value;
  std::string remedy;  ///< what to change; empty where all is well
  bool operator==(const MachineFact&) const = default;
};

/// Frequency governor, turbo, hyper-threading, virtual machine, clock source, load, and other runs
/// of cdb, as far as the system says. `root`: the folder that holds proc/ and sys/. A fact that is
/// not there is left out. Errors: none. Threads: any. Source: proc(5), and the kernel's
/// admin-guide/pm/cpufreq and abi/testing/sysfs-devices-system-cpu.
std::vector<MachineFact> LookAtMachine(const std::filesystem::path& root = "/");

}  // namespace cdb::machine
