// Plans for the tests of the schedule, built by hand.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "tests/support/files.h"

namespace cdb::tests {

/// What the test worker does with a run whose seed is this; with any other it records every cycle
/// and reports.
enum Behaviour : std::uint64_t {
  kFinishes = 100,
  kFails,              ///< reports a failure after two cycles
  kSegfaults,          ///< after three cycles
  kAborts,             ///< with text on standard error
  kHangs,              ///< after four cycles
  kHangsDeaf,          ///< and ignores every signal that it can, with a child that does so too
  kDiesHalfway,        ///< SIGKILL after half its cycles, the next one begun
  kFloodsErrors,       ///< 32 MiB on standard error, then finishes
  kFloodsAndDies,      ///< 32 MiB on standard error, then a last line and exit status 7
  kClosesFiles,        ///< closes all it was given, then ends with status 0
  kEndsWithoutReport,  ///< exit status 0 at once
  kLiesAboutCycles,    ///< reports done after half its cycles
  kSpoilsHeader,       ///< writes nonsense over the head of its recording, then crashes
  kWritesBinary,       ///< bytes that are no text on standard error, then exit status 1
  kTellsPlace,         ///< finishes; `pairs` hold its processors, signals and descriptors
  kContacts,           ///< finishes; cycle i has i contacts
  kContactsLost,       ///< crashes, with the contacts of its last two cycles unwritten
  kTakesMemory,        ///< finishes once it has 64 GB that it does not touch; fails if it gets less
  kNeedsMemory,        ///< the same, and crashes if it gets less
};

struct PlanShape {
  std::vector<std::uint64_t> quantities = {1, 2, 3};
  std::vector<std::string> detectors = {"dbvt", "sap", "simple"};
  std::uint64_t repeats = 1;
  std::uint64_t cycles = 10;
  std::uint64_t seed = kFinishes;
  std::string precision = "single";
  double timeout_s = 0;     ///< 0: none
  double memory_bytes = 0;  ///< 0: no limit
  std::vector<std::string> record = {"timing", "counts"};
};

/// Axes quantity and detector.
plan::Plan MakePlan(const PlanShape& shape = {});

/// One run for each behaviour, on an axis `seed`; no timeout unless given.
plan::Plan MakeBehaviourPlan(const std::vector<std::uint64_t>& seeds, const PlanShape& shape = {});

std::vector<const plan::Run*> Pointers(const plan::Plan& plan);

}  // namespace cdb::tests
