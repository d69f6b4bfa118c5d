#include "runtime/protocol/machine/machine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <optional>
#include <set>
#include <system_error>

namespace cdb::machine {
namespace {

namespace fs = std::filesystem;

/// Fraction of the processors that other programs may use without a visible effect on a run.
constexpr double kMostLoad = 0.1;

std::optional<std::string> FirstLineOf(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  return line;
}

class Examination {
 public:
  explicit Examination(const fs::path& root)
      : root_(root), cpus_(root / "sys/devices/system/cpu") {}

  std::vector<MachineFact> Make() {
    LookAtProcessor();
    LookAtGovernors();
    LookAtTurbo();
    LookAtThreads();
    LookAtClock();
    LookAtLoad();
    LookAtWorkers();
    return std::move(facts_);
  }

 private:
  void Add(std::string name, std::string value, bool is_good, std::string remedy) {
    facts_.push_back({std::move(name), std::move(value), is_good ? "" : std::move(remedy)});
  }

  void LookAtProcessor() {
    std::ifstream in(root_ / "proc/cpuinfo");
    std::string model;
    bool is_guest = false;
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("processor\t")) ++processors_;
      const std::size_t colon = line.find(": ");
      if (colon == std::string::npos) continue;
      if (model.empty() && line.starts_with("model name")) model = line.substr(colon + 2);
      is_guest = is_guest || (line.starts_with("flags") &&
                              (line + ' ').find(" hypervisor ") != std::string::npos);
    }
    if (processors_ == 0) return;
    Add("processors", fmt::format("{}{}{}", processors_, model.empty() ? "" : " of ", model), true,
        "");
    Add("virtual machine", is_guest ? "yes" : "no", !is_guest,
        "other guests share its processors and caches; measure on physical hardware, or check the "
        "stolen time of each run");
  }

  void LookAtGovernors() {
    std::set<std::string> governors;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(cpus_, none))
      if (const auto governor = FirstLineOf(entry.path() / "cpufreq/scaling_governor"))
        governors.insert(*governor);
    if (governors.empty()) return;
    Add("frequency governor", fmt::format("{}", fmt::join(governors, ", ")),
        governors == std::set<std::string>{"performance"},
        "the frequency follows the load; as root: cpupower frequency-set -g performance");
  }

  void LookAtTurbo() {
    const auto add = [&](bool is_on, const char* file, char off) {
      Add("turbo", is_on ? "on" : "off", !is_on,
          fmt::format("the frequency depends on heat and on the other cores; as root: echo {} > {}",
                      off, file));
    };
    if (const auto off = FirstLineOf(cpus_ / "intel_pstate/no_turbo"))
      add(*off == "0", "/sys/devices/system/cpu/intel_pstate/no_turbo", '1');
    else if (const auto on = FirstLineOf(cpus_ / "cpufreq/boost"))
      add(*on == "1", "/sys/devices/system/cpu/cpufreq/boost", '0');
  }

  void LookAtThreads() {
    const auto is_active = FirstLineOf(cpus_ / "smt/active");
    if (!is_active) return;
    Add("hyper-threading", *is_active == "1" ? "on" : "off", *is_active != "1",
        "two threads share a core and its caches; as root: echo off > "
        "/sys/devices/system/cpu/smt/control");
  }

  void LookAtClock() {
    const auto source =
        FirstLineOf(root_ / "sys/devices/system/clocksource/clocksource0/current_clocksource");
    if (!source) return;
    const bool is_quick =
        *source == "tsc" || *source == "kvm-clock" || *source == "arch_sys_counter";
    Add("clock source", *source, is_quick,
        "each reading of the clock is a system call, which is too slow for short phases; boot with "
        "clocksource=tsc if the processor's is stable");
  }

  void LookAtLoad() {
    std::ifstream in(root_ / "proc/loadavg");
    double load = 0;
    if (!(in >> load) || processors_ == 0) return;
    Add("load", fmt::format("{:.2f} of {} processors in the last minute", load, processors_),
        load <= kMostLoad * static_cast<double>(processors_),
        "other programs are running; end them, or wait: `top` lists them");
  }

  void LookAtWorkers() {
    int workers = 0;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(root_ / "proc", none)) {
      const std::string name = entry.path().filename();
      if (!std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; })) continue;
      const auto program = FirstLineOf(entry.path() / "comm");
      workers += program && program->starts_with("cdb-worker");
    }
    Add("other runs of cdb",
        workers == 0 ? "none" : fmt::format("{} worker{}", workers, workers == 1 ? "" : "s"),
        workers == 0, "parallel runs disturb one another; wait for them");
  }

  const fs::path root_, cpus_;
  std::size_t processors_ = 0;
  std::vector<MachineFact> facts_;
};

}  // namespace

std::vector<MachineFact> LookAtMachine(const fs::path& root) { return Examination(root).Make(); }

std::string HostName() {
  std::array<char, 256> name = {};
  if (gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return "localhost";
  return name.data();
}

double LoadAverage() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : std::numeric_limits<double>::quiet_NaN();
}

TimeOfAllProcessors ReadTimeOfAllProcessors() {
  std::ifstream stat("/proc/stat");
  std::string cpu;
  double user = 0, nice = 0, system = 0, idle = 0, iowait = 0, irq = 0, softirq = 0, steal = 0;
  if (!(stat >> cpu >> user >> nice >> system >> idle >> iowait >> irq >> softirq >> steal))
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  const double tick_ns = 1e9 / static_cast<double>(sysconf(_SC_CLK_TCK));
  return {(user + nice + system + irq + softirq) * tick_ns, steal * tick_ns};
}

double ProcessorCount() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set)
                                                     : std::numeric_limits<double>::quiet_NaN();
}

double OnlineProcessorCount() { return static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN)); }

}  // namespace cdb::machine
