#include "runtime/cli/check_stored.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/cli/plans/sized_plan.h"
#include "runtime/figures/points.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "runtime/results/trace_file.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

std::string Proof(bool has_digest) {
  return has_digest ? "every byte is as it was written"
                    : "it has no digest that would reveal changed bytes, as it is from an earlier "
                      "version of cdb";
}

const char* State(bool has_digest) { return has_digest ? "whole" : "readable"; }

/// Nullopt for a file of an earlier version without a plan, or with a plan that this cdb cannot
/// read.
std::optional<plans::SizedPlan> PlanIn(const results::ResultFile& results,
                                       const std::string& file) {
  const std::string text = results.ReadProvenance("plan_text");
  if (text.empty()) return std::nullopt;
  try {
    return plans::ReadSizedPlan(text, file);
  } catch (const yaml::PlanError&) {
    return std::nullopt;
  } catch (const options::CommandError&) {
    return std::nullopt;
  }
}

/// The number of cells of each status.
struct StatusCounts {
  std::array<std::uint64_t, std::size(results::kStatusNames)> of = {};
  std::uint64_t runs = 0;

  std::uint64_t Of(results::Status status) const { return of[static_cast<std::size_t>(status)]; }
  void Add(results::Status status) {
    ++of[static_cast<std::size_t>(status)];
    runs += status != results::Status::kSkipped;
  }
};

StatusCounts CountCells(const results::ResultFile& results) {
  StatusCounts counts;
  for (const results::ResultFile::Cell& cell : figures::AllCells(results))
    counts.Add(results.ReadStatus(cell));
  return counts;
}

options::ExitStatus CheckResults(const std::string& file) {
  const results::ResultFile results(file, results::ProofOf::kEveryValue);
  const std::string plan_name = results.plan_sha256().substr(0, 12);
  const auto sized = PlanIn(results, file);
  if (sized) results.CheckIsOf(sized->plan);
  const StatusCounts counts = CountCells(results);
  const std::uint64_t missing = counts.Of(results::Status::kMissing);
  std::string text = fmt::format("{}: {}: {} of {} runs", file,
                                 missing > 0 ? "incomplete" : State(results.has_digest()),
                                 counts.runs - missing, counts.runs);
  for (const results::Status status :
       {results::Status::kFailed, results::Status::kCrashed, results::Status::kTimedOut})
    if (counts.Of(status) > 0)
      text += fmt::format(", {} {}", counts.Of(status), results::StatusName(status));
  text += sized ? fmt::format(", of plan {}", plan_name)
                : fmt::format(", of plan {}, which this cdb cannot read", plan_name);
  terminal::Print(fmt::format("{}; {}\n", text, Proof(results.has_digest())));
  return missing > 0 ? options::ExitStatus::kFailedRuns : options::ExitStatus::kGood;
}

options::ExitStatus CheckTraceFile(const std::string& file) {
  const results::TraceCheck trace = results::CheckTrace(file);
  terminal::Print(fmt::format(
      "{}: {}: a trace of {} cycles of {} bodies{}, run {}; {}\n", file, State(trace.has_digest),
      trace.facts.cycles, trace.facts.bodies,
      trace.facts.pairs_sha256.empty() ? "" : fmt::format(" with {} pairs", trace.facts.pairs),
      trace.run_id, Proof(trace.has_digest)));
  return options::ExitStatus::kGood;
}

/// Reads every run of a journal.
void CheckJournal(const std::string& file) {
  auto journal = journal::Journal::OpenToRead(file);
  if (const std::string fault = journal.FindFault(); !fault.empty())
    throw journal::DamagedJournal(file, fault);
  std::uint64_t runs = 0;
  journal.ForEachRun([&](const journal::Journal::Row& row) {
    try {
      const auto record = journal.ReadRow(row.number);
      if (!record) return;  // by another process
      journal::InfoOf(*record);
    } catch (const hdf5::Error& error) {
      throw journal::DamagedRun(file, row.run_id, error.what());
    }
    ++runs;
  });
  terminal::Print(fmt::format("{}: whole: a journal of {} finished run{} of plan {}; {}\n", file,
                              runs, runs == 1 ? "" : "s", journal.plan_sha256().substr(0, 12),
                              Proof(true)));
}

}  // namespace

bool IsStored(const std::string& file) {
  return results::IsStored(file) || journal::IsJournal(file) || file.ends_with(".h5") ||
         file.ends_with(journal::kEnding);
}

options::ExitStatus CheckStored(const std::string& file) {
  try {
    if (file.ends_with(journal::kEnding) || journal::IsJournal(file)) {
      CheckJournal(file);
      return options::ExitStatus::kGood;
    }
    return results::ReadSchema(file) == results::kTraceSchema ? CheckTraceFile(file)
                                                              : CheckResults(file);
  } catch (const files::StoreError& error) {
    terminal::Say(fmt::format("cdb: {}\n", error.what()));
    return options::ExitStatus::kEnvironmentError;
  }
}

}  // namespace cdb::cli
