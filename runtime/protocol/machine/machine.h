// Conditions of the machine that make timings doubtful: its settings and other programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cdb::machine {

/// One line of `cdb doctor`.
struct MachineFact {
  std::string name, value;
  std::string remedy;  ///< advice; empty if there is nothing to change
  bool operator==(const MachineFact&) const = default;
};

/// Frequency governor, turbo, hyper-threading, virtual machine, clock source, load, and other runs
/// of cdb, as far as the system reports them; missing facts are left out. `root`: the folder that
/// contains proc/ and sys/. Errors: none. Threads: any. Source: proc(5), and the kernel's
/// admin-guide/pm/cpufreq and abi/testing/sysfs-devices-system-cpu.
std::vector<MachineFact> LookAtMachine(const std::filesystem::path& root = "/");

}  // namespace cdb::machine
