#include "runtime/results/trace_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "runtime/protocol/series.h"
#include "runtime/results/hdf5/file.h"
#include "tests/library/deforming/folding_cloth.h"
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

/// The pairs of a cycle; the second has none.
std::vector<protocol::TracePair> PairsOf(std::uint64_t cycle) {
  if (cycle == 1) return {};
  return {{0, 1}, {0, 4}, {2, static_cast<std::uint32_t>(3 + cycle / 2)}};
}

/// Of every body: at its number, turned by a right angle.
std::vector<double> FramesOf(std::uint64_t cycle) {
  std::vector<double> frames;
  for (std::size_t i = 0; i < kBodies; ++i) {
    const double at = static_cast<double>(i) + static_cast<double>(cycle) / 2;
    frames.insert(frames.end(), {at, -at, 0.25, 0, 1, 0, -1, 0, 0, 0, 0, 1});
  }
  return frames;
}

/// The same trace with pairs; `change` may spoil those of a cycle.
protocol::TraceMemory MakePairTrace(
    bool is_double, const std::function<void(std::uint64_t, std::vector<double>&,
                                             std::vector<protocol::TracePair>&)>& change = {}) {
  const std::string run_text = "id: 1\n";
  const protocol::TraceMemory boxes = MakeTrace(is_double);
  protocol::TraceShape shape = boxes.shape();
  shape.pairs = 6;
  shape.text_bytes = run_text.size();
  protocol::TraceMemory trace = protocol::TraceMemory::Create(shape);
  std::ranges::copy(boxes.filters(), trace.filters().begin());
  trace.SetRun(1 << 2, run_text);
  for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
    trace.SetBoxes(cycle, boxes.Boxes(cycle));
    auto frames = FramesOf(cycle);
    auto pairs = PairsOf(cycle);
    if (change) change(cycle, frames, pairs);
    trace.SetPairs(cycle, frames, pairs);
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

TEST_P(TraceFile, ReadsPairsBackToTheBit) {
  const TemporaryFolder folder;
  const protocol::TraceMemory trace = MakePairTrace(GetParam());
  Write(trace, folder / "t.h5");
  const analysis::TraceFacts facts = results::ReadTraceFacts(folder / "t.h5");
  EXPECT_EQ(facts.sha256, MakeTrace(GetParam()).Sha256()) << "the boxes are the same trace";
  EXPECT_EQ(facts.pairs_sha256, trace.PairsSha256());
  EXPECT_NE(facts.pairs_sha256, facts.sha256);
  EXPECT_EQ(facts.pairs, 6u);
  EXPECT_FALSE(results::LoadTrace(folder / "t.h5", facts.sha256).shape().HasPairs());

  const protocol::TraceMemory loaded = results::LoadTrace(folder / "t.h5", facts.pairs_sha256);
  protocol::TraceReader reader(loaded.fd());
  EXPECT_EQ(reader.shape(), trace.shape());
  EXPECT_EQ(reader.walls(), 1u << 2);
  EXPECT_EQ(reader.ReadRunText(), "id: 1\n");
  for (std::uint64_t cycle : {2, 0, 1}) {
    EXPECT_TRUE(std::ranges::equal(reader.ReadPairs(cycle), PairsOf(cycle)));
    EXPECT_TRUE(std::ranges::equal(reader.ReadFrames(cycle), FramesOf(cycle)));
    EXPECT_EQ(reader.Read(cycle)[1], Side(cycle, 1, GetParam()));
  }
  EXPECT_TRUE(results::CheckTrace(folder / "t.h5").has_digest);
}

TEST_P(TraceFile, DescribesItsVariables) {
  const TemporaryFolder folder;
  Write(MakePairTrace(GetParam()), folder / "t.h5");
  const hdf5::File file = hdf5::File::Open(folder / "t.h5");
  EXPECT_EQ(file.Text("Conventions"), "CF-1.8");
  for (const char* name :
       {"cycle", "body", "object", "bound", "filter", "pose", "boxes", "filters", "poses",
        "scenario_text", "run_text", "frame", "frames", "first_pair", "pair_side", "pair_bodies"})
    EXPECT_NE(file.OpenDataset(name).Text("long_name"), "") << name;
  for (const char* name : {"cycle", "body", "object", "filters"})
    EXPECT_EQ(file.OpenDataset(name).Text("units"), "1") << name;
}

TEST_P(TraceFile, OfADeformingMeshReadsBackToTheBit) {
  deforming::MeshSequence cloth = FoldingCloth(5, 3);
  if (!GetParam())
    for (auto& frame : cloth.frames)
      for (Eigen::Vector3d& at : frame) at = at.cast<float>().cast<double>();
  for (const deforming::Primitives primitives :
       {deforming::Primitives::kTriangles, deforming::Primitives::kVertexFace,
        deforming::Primitives::kEdgeEdge}) {
    const TemporaryFolder folder;
    const protocol::TraceMemory trace = protocol::TraceOf(primitives, cloth);
    results::TraceOrigin origin = kOrigin;
    origin.frame_files = "a.ply\nb.ply\nc.ply";
    results::WriteTrace(trace, origin, 0, {}, folder / "t.h5");
    const analysis::TraceFacts facts = results::ReadTraceFacts(folder / "t.h5");
    EXPECT_EQ(facts.sha256, trace.Sha256());
    EXPECT_EQ(facts.primitives, deforming::WordOf(primitives));
    EXPECT_EQ(facts.vertices, 25u);
    EXPECT_EQ(facts.is_double, GetParam());
    EXPECT_EQ(facts.cycles, deforming::IsSwept(primitives) ? 2u : 3u);
    EXPECT_TRUE(results::CheckTrace(folder / "t.h5").has_digest);

    const protocol::TraceMemory loaded = results::LoadTrace(folder / "t.h5", facts.sha256);
    protocol::TraceReader reader(loaded.fd());
    EXPECT_EQ(reader.shape(), trace.shape());
    EXPECT_EQ(reader.corners(), deforming::BodiesOf(primitives, cloth));
    std::vector<double> sides;
    for (std::uint64_t cycle = 0; cycle < facts.cycles; ++cycle) {
      deforming::FillBoxes(primitives, cloth, reader.corners(), cycle, sides);
      EXPECT_TRUE(std::ranges::equal(reader.Read(cycle), sides));
    }
    for (std::uint64_t frame = 0; frame < 3; ++frame) {
      const std::vector<double> at = reader.ReadVertices(frame);
      for (std::size_t i = 0; i < at.size(); ++i)
        ASSERT_EQ(at[i], cloth.frames[frame][i / 3][static_cast<Eigen::Index>(i % 3)]);
    }
  }
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

TEST(TraceFileErrors, CornersThatAreNoVerticesAreRefused) {
  const TemporaryFolder folder;
  const protocol::TraceMemory trace =
      protocol::TraceOf(deforming::Primitives::kEdgeEdge, FoldingCloth(5, 2));
  trace.corners()[7][0] = 25;
  results::WriteTrace(trace, kOrigin, 0, {}, folder / "t.h5");
  try {
    results::LoadTrace(folder / "t.h5", trace.Sha256());
    ADD_FAILURE() << "nothing wrong";
  } catch (const files::StoreError& error) {
    EXPECT_NE(std::string(error.what()).find("a corner of body 7 is no vertex"), std::string::npos)
        << error.what();
  }
}

/// Of files with the right hash and seal.
TEST(TraceFileErrors, PairsThatCannotBeAreRefused) {
  using Frames = std::vector<double>&;
  using Pairs = std::vector<protocol::TracePair>&;
  const std::pair<const char*, std::function<void(Frames, Pairs)>> cases[] = {
      {"body 1 has no pose", [](Frames frames, Pairs) { frames[13] = NAN; }},
      {"body 0 has no pose", [](Frames frames, Pairs) { frames[4] = 2; }},
      {"pair 1 is not two of its bodies",
       [](Frames, Pairs pairs) {
         pairs[1] = {0, kBodies};
       }},
      {"pair 2 is not two of its bodies",
       [](Frames, Pairs pairs) {
         pairs[2] = {3, 3};
       }},
      {"pair 0 is not two of its bodies",
       [](Frames, Pairs pairs) {
         pairs[0] = {~0u, 1};
       }},
      {"pair 1 is not after the one before",
       [](Frames, Pairs pairs) {
         pairs[1] = {0, 1};
       }},
  };
  const TemporaryFolder folder;
  for (const auto& [why, spoil] : cases) {
    const protocol::TraceMemory trace =
        MakePairTrace(false, [&](std::uint64_t cycle, Frames frames, Pairs pairs) {
          if (cycle == 0) spoil(frames, pairs);
        });
    Write(trace, folder / "t.h5");
    const auto said = [&](auto read) -> std::string {
      try {
        read();
      } catch (const files::StoreError& error) {
        return error.what();
      }
      return "nothing wrong";
    };
    EXPECT_NE(said([&] { results::LoadTrace(folder / "t.h5", trace.PairsSha256()); }).find(why),
              std::string::npos)
        << why;
    EXPECT_NE(said([&] { results::CheckTrace(folder / "t.h5"); }).find(why), std::string::npos);
  }
}

TEST(TraceFileErrors, AnotherTraceAndEveryDamageIsRefused) {
  const TemporaryFolder folder;
  Write(MakePairTrace(false), folder / "t.h5");
  const analysis::TraceFacts facts = results::ReadTraceFacts(folder / "t.h5");
  EXPECT_THROW(results::LoadTrace(folder / "t.h5", std::string(64, '0')), files::StoreError);
  const std::string whole = ReadFile(folder / "t.h5");
  for (std::size_t cut = 0; cut < whole.size(); cut += kAnySanitizer ? 311 : 61) {
    WriteFile(folder / "cut.h5", whole.substr(0, cut));
    EXPECT_THROW(results::LoadTrace(folder / "cut.h5", facts.pairs_sha256), files::StoreError)
        << cut;
  }
  // Damage that does not change a box, a filter, a pose, a pair or the run is harmless.
  for (std::size_t at = 0; at < whole.size(); at += kAnySanitizer ? 67 : 13) {
    std::string bent = whole;
    bent[at] = static_cast<char>(bent[at] ^ 0x10);
    WriteFile(folder / "bent.h5", bent);
    try {
      EXPECT_EQ(results::LoadTrace(folder / "bent.h5", facts.pairs_sha256).PairsSha256(),
                facts.pairs_sha256);
    } catch (const files::StoreError&) {
    }
  }
}

}  // namespace
}  // namespace cdb::tests
