// Makes the records of finished runs of a plan, and writes them into a journal.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/journal/journal.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/journal/merge_base.h"
#include "runtime/results/layout.h"
#include "runtime/results/store.h"

namespace cdb::journal {

/// Data that depends only on the plan is computed once, in the constructor. Refers to plan and
/// provenance. Not thread-safe.
class RunWriter {
 public:
  RunWriter(const plan::Plan& plan, const results::Provenance& provenance);

  /// Writes a measured run; when it returns, the run is on the disk. Throws StoreError.
  void Write(const plan::Run& run, const results::RunResult& result, Journal& journal);
  /// The same for a reference run, with its samples.
  void WriteReference(const plan::Run& run, const results::RunResult& result,
                      std::span<const double> samples, Journal& journal);
  /// The run in `cell` of a results file of another plan, where its id is `id_there`, which is the
  /// measured run `run` of this one: the record that its runner would have written. `from` was made
  /// with facts(). Throws hdf5::Error.
  Record Copy(const plan::Run& run, const MergeBase& from, std::size_t cell,
              const std::string& id_there);
  const results::PlanFacts& facts() const { return facts_; }

 private:
  std::shared_ptr<const About> AboutFor(results::Provenance provenance);
  void CopySeries(const plan::Run& run, const MergeBase& from, std::size_t cell,
                  Record& record) const;
  void CopyContacts(const MergeBase& from, std::size_t cell, Record& record) const;
  void AddSeries(const plan::Run& run, const results::RunResult& result, Record& record) const;
  void AddContacts(const plan::Run& run, const results::RunResult& result, Record& record) const;

  const plan::Plan& plan_;
  const results::Provenance& provenance_;
  const results::PlanFacts facts_;
  const results::Layout layout_;
  About head_;  ///< without provenance
  std::map<results::Provenance, std::shared_ptr<const About>> abouts_;
  std::shared_ptr<const About> of_references_;
};

/// The number of a run's rows of contacts, in its record; NaN if it does not record them.
inline constexpr const char* kContactRows = "contact_rows";
inline constexpr const char* kContactArrays[] = {"contact_body", "contact_point", "contact_normal",
                                                 "contact_distance"};

/// What the record of a reference run holds.
struct Reference {
  results::Status status = results::Status::kMissing;
  std::string message;          ///< reason why it failed
  protocol::SampleShape shape;  ///< layout of `values`
  std::vector<double> values;   ///< as in Samples; empty if it failed
};
/// Throws hdf5::Error for the record of another run.
Reference ReadReference(const plan::Run& run, const Record& record);

// Reference runs in a merge: their arrays in /accuracy/reference.

/// Fills the arrays of /accuracy/reference from the records of `plan.references`. Those that no
/// journal holds are taken from `base`, a merged file, or are `missing` if that is null. Throws
/// StoreError, hdf5::Error.
void MergeReferences(const plan::Plan& plan, const results::Layout& layout, Journals& journals,
                     const hdf5::File* base, hdf5::File& file);
/// Compares the arrays written by MergeReferences with the records. Throws hdf5::Error.
void VerifyReferences(const plan::Plan& plan, const results::Layout& layout, Journals& journals,
                      const hdf5::File* base, const hdf5::File& file);

}  // namespace cdb::journal
