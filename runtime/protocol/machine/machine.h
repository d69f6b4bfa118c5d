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

// Facts about this machine.

/// The name of this machine; `localhost` if it has none.
std::string HostName();

/// The load average of the last minute; NaN if the system does not report it.
double LoadAverage();

/// Times since the system started, ns, summed over all processors; NaN if the system does not
/// report them. The resolution is 10 ms on most systems. Source: proc_stat(5).
struct TimeOfAllProcessors {
  double busy = 0;    ///< used by programs and the system
  double stolen = 0;  ///< taken by other virtual machines
};
TimeOfAllProcessors ReadTimeOfAllProcessors();

/// The number of processors that this process may run on; NaN if the system does not report it.
double ProcessorCount();
/// The number of online processors of this machine, whether or not this process may run on them.
/// The load average counts the programs on all of them.
double OnlineProcessorCount();

}  // namespace cdb::machine
