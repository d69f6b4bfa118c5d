#include "runtime/results/trace_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "runtime/protocol/series.h"
#include "runtime/results/hdf5/file.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/sanitizers.h"

// HDF5 leaks the object headers that it rejects; it closes objects that the caller forgets to
// close.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace cdb::tests {
namespace {

constexpr std::uint64_t kBodies = 5, kObjects = 4, kCycles = 3;
const results::TraceOrigin kOrigin = {
    "crowd",  "n 5", "0123456789abcdef", "fedcba9876543210", 1.0 / 60, "benchmark crowd { }\n",
    "id: 1\n"};

/// Sides that are exact only in their own precision; the last body is a plane.
double Side(std::uint64_t cycle, std::size_t i, bool is_double) {
  if (i >= (kBodies - 1) * protocol::kBoxSize)
    return (i % protocol::kBoxSize < 3 ? -1 : 1) * std::numeric_limits<double>::infinity();
  const double side = static_cast<double>(cycle) + 0.1 * static_cast<double>(i);
  return is_double ? side : static_cast<double>(static_cast<float>(side));
}

protocol::TraceMemory MakeTrace(bool is_double) {
  protocol::TraceMemory trace = protocol::TraceMemory::Create({kBodies, kCycles, is_double});
  trace.filters()[1] = {3, ~0u, 0};
  trace.filters()[kBodies - 1] = {2, 1, 1};
  std::vector<double> sides(trace.shape().PerCycle());
  for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
    for (std::size_t i = 0; i < sides.size(); ++i) sides[i] = Side(cycle, i, is_double);
    trace.SetBoxes(cycle, sides);
  }
  return trace;
}

void Write(const protocol::TraceMemory& trace, const std::filesystem::path& file) {
  results::WriteTrace(trace, kOrigin, kObjects,
                      std::vector<double>(kCycles * kObjects * protocol::kPoseSize, 0.5), file);
}

class TraceFile : public testing::TestWithParam<bool> {};

TEST_P(TraceFile, ReadsBackToTheBit) {
  const TemporaryFolder folder;
  const protocol::TraceMemory trace = MakeTrace(GetParam());
  Write(trace, folder / "t.h5");
  const analysis::TraceFacts facts = results::ReadTraceFacts(folder / "t.h5");
  EXPECT_EQ(facts.sha256, trace.Sha256());
  EXPECT_EQ(facts.bodies, kBodies);
  EXPECT_EQ(facts.cycles, kCycles);
  EXPECT_EQ(facts.timestep_s, 1.0 / 60);
  EXPECT_EQ(facts.is_double, GetParam());
  EXPECT_EQ(results::TracedRun(folder / "t.h5"), kOrigin.run_id);

  const protocol::TraceMemory loaded = results::LoadTrace(folder / "t.h5", facts.sha256);
  protocol::TraceReader reader(loaded.fd());
  EXPECT_EQ(reader.shape(), trace.shape());
  EXPECT_EQ(reader.filters().back(), (protocol::TraceFilter{2, 1, 1}));
  for (std::uint64_t cycle : {2, 0, 1}) {
    const auto sides = reader.Read(cycle);
    for (std::size_t i = 0; i < sides.size(); ++i) ASSERT_EQ(sides[i], Side(cycle, i, GetParam()));
    EXPECT_EQ(loaded.Boxes(cycle), std::vector<double>(sides.begin(), sides.end()));
  }
}

TEST_P(TraceFile, DescribesItsVariables) {
  const TemporaryFolder folder;
  Write(MakeTrace(GetParam()), folder / "t.h5");
  const hdf5::File file = hdf5::File::Open(folder / "t.h5");
  EXPECT_EQ(file.Text("Conventions"), "CF-1.8");
  for (const char* name : {"cycle", "body", "object", "bound", "filter", "pose", "boxes", "filters",
                           "poses", "scenario_text", "run_text"})
    EXPECT_NE(file.OpenDataset(name).Text("long_name"), "") << name;
  for (const char* name : {"cycle", "body", "object", "filters"})
    EXPECT_EQ(file.OpenDataset(name).Text("units"), "1") << name;
}

INSTANTIATE_TEST_SUITE_P(Precisions, TraceFile, testing::Bool());

TEST(TraceFileErrors, NameTheFileAndTheCause) {
  const TemporaryFolder folder;
  const auto why = [&](const std::string& name) -> std::string {
    try {
      results::ReadTraceFacts(folder / name);
    } catch (const files::StoreError& error) {
      return error.what();
    }
    return "nothing wrong";
  };
  EXPECT_NE(why("gone.h5").find("gone.h5: there is no such file"), std::string::npos);
  EXPECT_NE(why("").find("it is no file"), std::string::npos);
  WriteFile(folder / "text.h5", "benchmark b { }");
  EXPECT_NE(why("text.h5").find("it is no trace, or damaged"), std::string::npos);
  EXPECT_FALSE(results::TracedRun(folder / "text.h5"));
  const plan::Plan plan = MakePlan({}, 1, {.cycles = 1, .objects = 1, .record = {"timing"}});
  WriteRun(plan, plan.runs[0], FakeResult(plan.runs[0]).result, {}, folder.path());
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  EXPECT_NE(why("out.h5").find("HDF5, but no trace (cdb-results)"), std::string::npos);
}

TEST(TraceFileErrors, AnotherTraceAndEveryDamageIsRefused) {
  const TemporaryFolder folder;
  Write(MakeTrace(false), folder / "t.h5");
  const analysis::TraceFacts facts = results::ReadTraceFacts(folder / "t.h5");
  EXPECT_THROW(results::LoadTrace(folder / "t.h5", std::string(64, '0')), files::StoreError);
  const std::string whole = ReadFile(folder / "t.h5");
  for (std::size_t cut = 0; cut < whole.size(); cut += kAnySanitizer ? 311 : 61) {
    WriteFile(folder / "cut.h5", whole.substr(0, cut));
    EXPECT_THROW(results::LoadTrace(folder / "cut.h5", facts.sha256), files::StoreError) << cut;
  }
  // Damage that does not change a box or a filter is harmless.
  for (std::size_t at = 0; at < whole.size(); at += kAnySanitizer ? 67 : 13) {
    std::string bent = whole;
    bent[at] = static_cast<char>(bent[at] ^ 0x10);
    WriteFile(folder / "bent.h5", bent);
    try {
      EXPECT_EQ(results::LoadTrace(folder / "bent.h5", facts.sha256).Sha256(), facts.sha256);
    } catch (const files::StoreError&) {
    }
  }
}

}  // namespace
}  // namespace cdb::tests
