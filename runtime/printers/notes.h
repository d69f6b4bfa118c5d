// Sentences about the runs of a results file, for summaries.
#pragma once

#include <string>
#include <vector>

#include "runtime/figures/model.h"

namespace cdb::printers {

/// The number of noisy `cells`, and the cause for the one that was longest off the processor. Empty
/// if none was noisy, or the file does not say. Throws StoreError.
std::string NoiseNote(const results::ResultFile& file, const std::vector<figures::Cell>& cells);

/// If `cells` were run on several kinds of processors (model names), a sentence for each kind, and
/// whether the detectors of one point were run on different kinds; none if there is only one kind.
/// Cells without a run do not count. Throws StoreError.
std::vector<std::string> ProcessorNotes(const results::ResultFile& file,
                                        const std::vector<figures::Cell>& cells);

/// The overhead of calling a detector, and its fraction of the fastest detector's time. Empty if no
/// run states it.
std::string HarnessNote(const figures::Model& model);

/// The reasons why timings must not be quoted: a debug build, parallel runs.
std::string BuildNote(const results::ResultFile& file);
std::string JobsNote(const results::ResultFile& file);

}  // namespace cdb::printers
