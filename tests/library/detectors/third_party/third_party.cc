#include "tests/library/detectors/third_party/third_party.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "library/detectors/plugin.h"
#include "tests/support/folders.h"

// Read by the sanitizers. FCL frees memory from malloc with delete[] when it copies a tree of
// boxes, and leaks the nodes of its trees in arrays.
extern "C" const char* __asan_default_options() { return "alloc_dealloc_mismatch=0"; }
extern "C" const char* __lsan_default_suppressions() { return "leak:libfcl"; }

namespace cdb::tests {

std::vector<schema::DetectorInfo> ThirdPartyDetectors(std::string_view phase) {
  std::vector<schema::DetectorInfo> rows;
  for (const schema::DetectorInfo& info : schema::Detectors())
    if (!info.part.empty() && info.HasPhase(phase)) rows.push_back(info);
  return rows;
}

std::unique_ptr<Detector> MakeThirdParty(const schema::DetectorInfo& info) {
  const schema::DetectorPart* part = schema::FindDetectorPart(info.part);
  if (part == nullptr) throw std::logic_error(std::string(info.part) + " is no part");
  if (!part->is_built) return nullptr;
  const std::string module = "cdb-detectors-" + std::string(info.part) + ".so";
  const std::string path = BuildFolder() / "detectors" / module;
  const auto all = detectors::LoadPlugin(path);
  const detectors::LoadedDetector* entry = detectors::FindDetector(all, info.name);
  if (entry == nullptr) throw std::runtime_error(std::string(info.name) + " is not in its part");
  EXPECT_EQ(HasAny(entry->phases, kBroad), info.HasPhase("broad"));
  EXPECT_EQ(HasAny(entry->phases, kNarrow), info.HasPhase("narrow"));
  EXPECT_EQ(entry->max_bodies, info.max_bodies);
  return entry->make({});
}

}  // namespace cdb::tests
