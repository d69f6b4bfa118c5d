// Reference runs in a merge: their arrays in /accuracy/reference.
#pragma once

#include "compiler/plan/plan.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/layout.h"

namespace cdb::journal {

/// Fills the arrays of /accuracy/reference from the records of `plan.references`. Those that no
/// journal holds are taken from `base`, a merged file, or are `missing` if that is null. Throws
/// StoreError, hdf5::Error.
void MergeReferences(const plan::Plan& plan, const results::Layout& layout, Journals& journals,
                     const hdf5::File* base, hdf5::File& file);
/// Compares the arrays written by MergeReferences with the records. Throws hdf5::Error.
void VerifyReferences(const plan::Plan& plan, const results::Layout& layout, Journals& journals,
                      const hdf5::File* base, const hdf5::File& file);

}  // namespace cdb::journal
