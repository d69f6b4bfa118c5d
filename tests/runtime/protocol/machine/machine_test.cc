#include "runtime/protocol/machine/machine.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "tests/support/files.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

/// The folders proc and sys of a made-up machine.
class Machine : public ::testing::Test {
 protected:
  void Write(const std::string& file, const std::string& text) {
    fs::create_directories((folder_ / file).parent_path());
    WriteFile(folder_ / file, text);
  }
  std::map<std::string, machine::MachineFact> Facts() const {
    std::map<std::string, machine::MachineFact> facts;
    for (const machine::MachineFact& fact : machine::LookAtMachine(folder_.path()))
      facts[fact.name] = fact;
    return facts;
  }

  const TemporaryFolder folder_;
};

TEST_F(Machine, ThatSaysNothingHasNoFactsButItsWorkers) {
  const auto facts = Facts();
  EXPECT_EQ(facts.size(), 1u);
  EXPECT_EQ(facts.at("other runs of cdb").value, "none");
}

TEST_F(Machine, ThatIsSetUpForTimingsHasNothingToChange) {
  Write("proc/cpuinfo",
        "processor\t: 0\nmodel name\t: Abacus 9\nflags\t\t: fpu sse2\n\nprocessor\t: 1\n");
  Write("proc/loadavg", "0.15 0.20 0.30 1/200 999\n");
  Write("proc/1/comm", "init\n");
  Write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  Write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n");
  Write("sys/devices/system/cpu/intel_pstate/no_turbo", "1\n");
  Write("sys/devices/system/cpu/smt/active", "0\n");
  Write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
  const auto facts = Facts();
  EXPECT_EQ(facts.size(), 8u);
  for (const auto& [name, fact] : facts) EXPECT_EQ(fact.remedy, "") << name;
  EXPECT_EQ(facts.at("processors").value, "2 of Abacus 9");
  EXPECT_EQ(facts.at("load").value, "0.15 of 2 processors in the last minute");
}

TEST_F(Machine, ThatDisturbsTimingsIsToldHowToStop) {
  Write("proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu hypervisor\n");
  Write("proc/loadavg", "0.95 0.20 0.30 1/200 999\n");
  Write("proc/77/comm", "cdb-worker-f32\n");
  Write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  Write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
  Write("sys/devices/system/cpu/cpufreq/boost", "1\n");
  Write("sys/devices/system/cpu/smt/active", "1\n");
  Write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  const auto facts = Facts();
  EXPECT_EQ(facts.size(), 8u);
  for (const auto& [name, fact] : facts)
    EXPECT_EQ(fact.remedy.empty(), name == "processors") << name;
  EXPECT_EQ(facts.at("frequency governor").value, "performance, powersave");
  EXPECT_TRUE(facts.at("turbo").remedy.ends_with("echo 0 > /sys/devices/system/cpu/cpufreq/boost"));
  EXPECT_EQ(facts.at("other runs of cdb").value, "1 worker");
}

}  // namespace
}  // namespace cdb::tests
