// `cdb doctor`: whether this machine is fit for timings, and what to change.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "runtime/cli/options/subcommand.h"
#include "runtime/protocol/machine/event_counters.h"
#include "runtime/protocol/machine/machine.h"
#include "runtime/protocol/machine/noise.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

constexpr double kSeconds = 2;
/// ns: a cycle of a few objects takes some microseconds and is timed by a dozen clock readings.
constexpr double kSlowClock = 100;

std::string Percent(double part) { return fmt::format("{:.1f} %", 100 * part); }

std::vector<machine::MachineFact> FactsOf(const machine::NoiseFloor& floor) {
  std::vector<machine::MachineFact> facts;
  facts.push_back(
      {"reading the clock", fmt::format("{:.0f} ns", floor.clock_ns),
       floor.clock_ns > kSlowClock ? "it dominates short phases; see the clock source above" : ""});
  facts.push_back({"off the processor", Percent(floor.off_processor),
                   floor.off_processor > machine::kMostOffProcessor
                       ? "other programs use the same processor"
                       : ""});
  if (!std::isnan(floor.stolen))
    facts.push_back(
        {"stolen time", Percent(floor.stolen),
         floor.stolen > machine::kMostStolen ? "another virtual machine took the processors" : ""});
  if (!std::isnan(floor.others))
    facts.push_back({"other programs", fmt::format("on {:.2f} processors meanwhile", floor.others),
                     floor.others > machine::kMostOthers
                         ? "they share caches, memory and frequency with a run; end them, or wait: "
                           "`top` lists them"
                         : ""});
  facts.push_back(
      {"a fixed loop",
       fmt::format("{:.3g} us; half of {} within {} of the median, 99 % up to +{}, worst x {:.2f}",
                   floor.median / 1e3, floor.loops,
                   Percent((floor.half_high - floor.half_low) / 2 / floor.median),
                   Percent(floor.p99 / floor.median - 1), floor.worst / floor.median),
       floor.IsQuiet() ? "" : "smaller differences than these cannot be measured"});
  return facts;
}

/// What `record counters` can count.
std::string CountersText() {
  const machine::EventCounters counters;
  const std::string missing = machine::MissingText(counters.missing());
  if (missing.empty()) return "all";
  return fmt::format("{} {}", counters.CountsNothing() ? "none:" : "without", missing);
}

options::ExitStatus Examine() {
  std::vector<machine::MachineFact> facts = machine::LookAtMachine();
  const machine::NoiseFloor floor = machine::MeasureNoiseFloor(kSeconds);
  for (machine::MachineFact& fact : FactsOf(floor)) facts.push_back(std::move(fact));
  int doubts = 0;
  for (const machine::MachineFact& fact : facts) {
    const bool is_good = fact.remedy.empty();
    doubts += !is_good;
    terminal::Print(fmt::format("  {}  {:20} {}\n", is_good ? "ok" : " !", fact.name, fact.value));
    if (!is_good) terminal::Print(fmt::format("      {:20} {}\n", "", fact.remedy));
  }
  // Missing counters are no reason to doubt times.
  terminal::Print(fmt::format("  --  {:20} {}\n", "counters", CountersText()));
  terminal::Print(floor.IsQuiet()
                      ? fmt::format("\nQuiet enough for timings{}.\n",
                                    doubts > 0 ? "; the marked items may still disturb them" : "")
                      : "\nNot quiet: timings made now would be marked as noisy, or be wrong by "
                        "more than their intervals.\n");
  return floor.IsQuiet() ? options::ExitStatus::kGood : options::ExitStatus::kFailedRuns;
}

void DeclareDoctor(options::Subcommand& command) { command.Action(Examine); }

}  // namespace

/// Prints the conditions of this machine that make timings doubtful. Exit status 3 if a fixed loop
/// does not run steadily.
options::Command DoctorCommand() {
  return {.name = "doctor",
          .help = "check whether this machine is fit for timings, and advise what to change",
          .declare = DeclareDoctor};
}

}  // namespace cdb::cli
