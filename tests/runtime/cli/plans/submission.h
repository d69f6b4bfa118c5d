// All results of the standard suite, made up, as a user has them in a folder.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "runtime/cli/plans/suite_plan.h"
#include "runtime/results/files/safe_file.h"
#include "tests/runtime/figures/suite_results.h"
#include "tests/support/files.h"

namespace cdb::tests {

/// Results of every scene without faults.
class Submission {
 public:
  explicit Submission(const SuiteChange& change = {},
                      const results::Provenance& provenance = kSuiteProvenance) {
    for (const figures::StandardScene& scene : figures::StandardScenes())
      Write(scene.Id(), change, provenance);
  }

  const std::filesystem::path& folder() const { return folder_.path(); }

  void Write(const std::string& id, const SuiteChange& change = {},
             const results::Provenance& provenance = kSuiteProvenance,
             const plans::SuiteChoice& choice = {}) const {
    const figures::StandardScene& scene = Scene(id);
    WriteSuiteResults(
        plans::StandardPlan(scene, choice), std::string(scene.error),
        [&](const plan::Run& run, SuiteRun& made) {
          made.ns = 1e5 / (1 + static_cast<double>(run.at.back()));
          if (change) change(run, made);
        },
        File(id), provenance);
  }
  /// Writes suite.json of the existing results.
  void Summarise() const {
    files::WriteWhole(plans::SuiteSummary(plans::ReadSuiteFolder(folder_.path())),
                      folder_ / plans::kSuiteSummary);
  }
  std::vector<std::string> Faults() const {
    return plans::CheckSuite(plans::ReadSuiteFolder(folder_.path()), folder_.path()).faults;
  }
  std::filesystem::path File(const std::string& id) const {
    return folder_ / Scene(id).ResultName();
  }

 private:
  static const figures::StandardScene& Scene(const std::string& id) {
    return *std::ranges::find(figures::StandardScenes(), id, &figures::StandardScene::Id);
  }
  const TemporaryFolder folder_;
};

}  // namespace cdb::tests
