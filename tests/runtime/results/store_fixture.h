// Plans and results for tests of the store: Bullet could not run these scenes, but every number
// follows from its position.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/protocol/series.h"
#include "runtime/results/journal/merge.h"
#include "runtime/results/journal/run_writer.h"
#include "runtime/results/store.h"
#include "tests/support/files.h"

namespace cdb::tests {

struct SceneSize {
  std::uint64_t cycles = 5;
  std::uint64_t objects = 3;
  schema::WordList record = {"timing", "counts", "stability"};
  schema::WordList metrics = {"none"};
};

plan::Axis NumberAxis(std::string name, std::vector<double> values, std::string unit = "");
plan::Axis TextAxis(std::string name, const std::vector<std::string>& values);

/// A plan with every point of the grid except `skipped`, each run with a different scene.
plan::Plan MakePlan(std::vector<plan::Axis> axes, std::uint64_t repeats, const SceneSize& size,
                    std::vector<std::vector<std::size_t>> skipped = {});

/// Changes the scene of `run`, and with it its id.
void Resize(plan::Run& run, const SceneSize& size);

/// The value at `index` (in the order of the series' own shape) of a run: an integer in integer
/// series and in `duration`; different for every run, series and index.
double ValueAt(const plan::Run& run, const protocol::Series& series, std::size_t index);
/// Contacts that a run counts in a cycle; 0 to 3.
std::int32_t ContactsIn(const plan::Run& run, std::size_t cycle);
/// The contact in row `row` of a run.
protocol::ContactRecord ContactAt(const plan::Run& run, std::size_t row);

/// A result whose series hold `ValueAt`, with no values after `n_cycles`.
class FakeResult {
 public:
  FakeResult(const plan::Run& run, results::Status status, std::uint64_t n_cycles);
  explicit FakeResult(const plan::Run& run)
      : FakeResult(run, results::Status::kDone, run.scene.world.Count("cycles")) {}
  FakeResult(const FakeResult&) = delete;
  FakeResult& operator=(const FakeResult&) = delete;

  results::RunResult result;

 private:
  std::vector<std::vector<std::byte>> memory_;
};

results::Provenance TestProvenance();

// Both open the journal in `folder` and close it again.
void WriteRun(const plan::Plan& plan, const plan::Run& run, const results::RunResult& result,
              const results::Provenance& provenance, const std::filesystem::path& folder);
void WriteReference(const plan::Plan& plan, const plan::Run& run, const results::RunResult& result,
                    std::span<const double> samples, const results::Provenance& provenance,
                    const std::filesystem::path& folder);

/// When each finished run in the journals of a folder was written, by its id.
std::map<std::string, std::int64_t> RunsIn(const std::filesystem::path& folder);

}  // namespace cdb::tests
