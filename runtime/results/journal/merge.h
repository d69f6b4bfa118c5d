// Merges the finished runs of journals into a results file.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/store.h"

namespace cdb::journal {

/// Judges the requirements, and the searches, of a merged file, so that the answers can be stored
/// with it.
using JudgeFile = std::function<results::StoredAnswers(const std::filesystem::path&)>;

/// Merges `places`, which are folders of journals or single journals, into `out` (of a run that is
/// present twice, the first): under a temporary name, verified, synced, renamed. Runs that no
/// journal holds are taken from `base` if given, a results file of the same plan that may be `out`;
/// else their cells have the status `missing`. The journals are left unchanged. Throws StoreError,
/// DamagedJournal, DamagedRun; `out` is then unchanged. `judge`: for a plan with requirements
/// or a search; without it, the file says that none was judged, and the search goes on.
void Merge(const plan::Plan& plan, const results::Provenance& provenance,
           const std::vector<std::filesystem::path>& places, const std::filesystem::path& out,
           const std::filesystem::path& base = {}, const JudgeFile& judge = {});
void Merge(const plan::Plan& plan, const results::Provenance& provenance,
           const std::filesystem::path& folder, const std::filesystem::path& out);

}  // namespace cdb::journal
