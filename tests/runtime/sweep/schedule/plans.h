// Hand-made plans for tests of the schedule.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "tests/support/files.h"

namespace cdb::tests {

/// The behaviour of the test worker for a run whose seed is this. For other seeds it records every
/// cycle and reports success.
enum Behaviour : std::uint64_t {
  kFinishes = 100,
  kFails,              ///< reports a failure after two cycles
  kSegfaults,          ///< crashes after three cycles
  kAborts,             ///< aborts, with text on standard error
  kHangs,              ///< hangs after four cycles
  kHangsDeaf,          ///< hangs and ignores every signal that it can, as does its child
  kDiesHalfway,        ///< killed by SIGKILL after half its cycles, during the next one
  kFloodsErrors,       ///< 32 MiB on standard error, then finishes
  kFloodsAndDies,      ///< 32 MiB on standard error, then a last line and exit status 7
  kClosesFiles,        ///< closes all its descriptors, then ends with status 0
  kEndsWithoutReport,  ///< exit status 0 at once
  kLiesAboutCycles,    ///< reports success after half its cycles
  kSpoilsHeader,       ///< overwrites the header of its recording, then crashes
  kWritesBinary,       ///< binary data on standard error, then exit status 1
  kTellsPlace,         ///< finishes; `pairs` holds its processors, signals and descriptors
  kContacts,           ///< finishes; cycle i has i contacts
  kContactsLost,       ///< crashes, with the contacts of its last two cycles unwritten
  kTakesMemory,  ///< finishes after allocating 64 GB without touching them; fails if it gets less
  kNeedsMemory,  ///< the same, and crashes if it gets less
  // Report success, with a value in cycle 4, or a fact of the run, that no run can have.
  kGoesBackInTime,  ///< a phase of -5 ns
  kHasNoTime,       ///< a step of NaN ns
  kHasNoPairs,      ///< -1 pairs
  kHasNoMemory,     ///< a peak of -1 bytes
  kHasNoHash,       ///< a state hash that is no number
  kTouchesNobody,   ///< a contact of no body
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

/// A plan with the axes quantity and detector.
plan::Plan MakePlan(const PlanShape& shape = {});

/// A plan with one run for each behaviour, on an axis `seed`; no timeout unless given.
plan::Plan MakeBehaviourPlan(const std::vector<std::uint64_t>& seeds, const PlanShape& shape = {});

std::vector<const plan::Run*> Pointers(const plan::Plan& plan);

}  // namespace cdb::tests
