// Results files, journals and traces with some bytes changed, and the right digest: the result is
// an error that names the file, or valid values. The input describes the changes, because HDF5
// files are too long for a corpus: which file, then position (3 bytes), count (1 byte) and bytes of
// each change.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "dsl/text/check.h"
#include "runtime/protocol/trace_memory.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/store.h"
#include "runtime/results/trace_file.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/files.h"

// HDF5 leaks some memory when it rejects a file; it closes objects that the caller forgets to
// close.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace {

using namespace cdb;
namespace fs = std::filesystem;

/// The files that are changed, without their seals.
struct Bases {
  Bases() {
    tests::FakeResult(plan.runs[0]);
    for (const plan::Run& run : plan.runs)
      tests::WriteRun(plan, run, tests::FakeResult(run).result, tests::TestProvenance(),
                      folder.path());
    journal::Merge(plan, tests::TestProvenance(), folder.path(), folder / "out.h5");
    const plan::Run& run = contacts.runs[0];
    tests::WriteRun(contacts, run, tests::FakeResult(run).result, {}, with_contacts.path());
    protocol::TraceMemory trace = protocol::TraceMemory::Create({3, 4, false, 4, 2});
    trace.SetRun(0, "id");
    const double frame[] = {1, 2, 3, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::vector<protocol::TracePair> pairs = {{0, 1}};
    std::vector<double> frames;
    for (int body = 0; body < 3; ++body) frames.insert(frames.end(), frame, std::end(frame));
    for (std::uint64_t cycle = 0; cycle < 4; ++cycle) {
      trace.SetBoxes(cycle, std::vector<double>(3 * protocol::kBoxSize, 1.5));
      trace.SetPairs(cycle, frames, pairs);
    }
    results::WriteTrace(trace, {"b", "", std::string(16, '0'), std::string(16, '0'), 0.01, "", ""},
                        0, {}, folder / "trace.h5");
    for (const fs::path& file : {folder / "out.h5", folder / "runs.journal",
                                 with_contacts / "runs.journal", folder / "trace.h5"}) {
      const std::string bytes = tests::ReadFile(file);
      const bool is_sealed = file.extension() == ".h5";
      images.push_back(bytes.substr(0, bytes.size() - (is_sealed ? sizeof(files::Seal) : 0)));
    }
  }

  const tests::TemporaryFolder folder, with_contacts;
  const plan::Plan plan = tests::MakePlan({tests::NumberAxis("n", {1, 2})}, 1, {.cycles = 6});
  const plan::Plan contacts = tests::MakePlan(
      {}, 1, {.cycles = 3, .objects = 2, .record = {"timing", "counts", "contacts"}});
  std::vector<std::string> images;
};

void Change(std::string& image, std::span<const std::uint8_t> changes) {
  while (changes.size() > 4) {
    const std::size_t place = (changes[0] | changes[1] << 8 | changes[2] << 16) % image.size();
    const std::size_t count =
        std::min<std::size_t>({changes[3] % 9u, changes.size() - 4, image.size() - place});
    std::copy_n(changes.begin() + 4, count, image.begin() + static_cast<long>(place));
    changes = changes.subspan(4 + count);
  }
}

void ReadResults(const fs::path& path) {
  const results::ResultFile file(path);
  for (std::size_t at = 0; !file.axes().empty() && at < file.axes()[0].values.size(); ++at) {
    const results::ResultFile::Cell cell = {{at}, 0};
    CDB_CHECK(results::StatusName(file.ReadStatus(cell)).size() > 0);
    file.ReadText("message", cell);
    if (file.Has("duration"))
      for (const double ns : file.ReadDuration(protocol::Phase::kStep, cell)) CDB_CHECK(!(ns < 0));
    if (file.Has("energy")) file.ReadSeries("energy", cell);
  }
  file.ReadProvenance("plan_text");
  file.ReadReferenceTroubles();
}

void MergeJournal(const plan::Plan& plan, const fs::path& file, const fs::path& out) {
  journal::Merge(plan, {}, {file}, out);
  results::ResultFile merged(out, results::ProofOf::kEveryValue);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Bases bases;
  if (size == 0) return 0;
  const std::size_t which = data[0] % 4;
  std::string image = bases.images[which];
  Change(image, {data + 1, size - 1});
  const tests::TemporaryFolder folder;
  const plan::Plan& plan = which == 2 ? bases.contacts : bases.plan;
  const bool is_journal = which == 1 || which == 2;
  const fs::path file = folder / (is_journal ? "runs.journal" : "out.h5");
  tests::WriteFile(file, image);
  try {
    if (!is_journal) files::AppendSeal(file, file);
    if (which == 0) ReadResults(file);
    if (is_journal) MergeJournal(plan, file, folder / "merged.h5");
    if (which == 3) {
      const analysis::TraceFacts facts = results::ReadTraceFacts(file);
      results::LoadTrace(file, facts.pairs_sha256.empty() ? facts.sha256 : facts.pairs_sha256);
    }
  } catch (const files::StoreError& error) {
    CDB_CHECK(std::string(error.what()).find(folder.path().string()) != std::string::npos);
  }
  return 0;
}
