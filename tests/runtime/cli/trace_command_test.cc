// Recorded runs, and detectors run on the recording.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/results/store.h"
#include "runtime/results/trace_file.h"
#include "tests/library/deforming/folding_cloth.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

/// Balls that collide with each other and with walls, with both kinds of filter.
std::string CrowdedScenario(const std::string& more) {
  return "benchmark crowd { cycles 40; world.side 30; acceleration 0\n"
         "objects { quantity 60; size 4; linear_velocity uniform(-60, 60) }\n" +
         more + " }\n";
}

std::vector<double> PairsOf(const results::ResultFile& file, std::size_t detector) {
  return file.ReadSeries("pairs", {{detector}, 0});
}

class Traces : public testing::TestWithParam<const char*> {};

TEST_P(Traces, GiveEveryDetectorThePairsOfTheLiveRun) {
  const Program program;
  const std::string precision = std::string("precision ") + GetParam();
  program.Write("crowd.cdb", CrowdedScenario(precision));
  const Finished recorded = program.Run({"trace", "crowd.cdb"});
  ASSERT_EQ(recorded.status, 0) << recorded.err;
  EXPECT_NE(recorded.out.find("crowd.trace.h5: "), std::string::npos) << recorded.out;
  // The same scene, with detectors that list exact pairs.
  program.Write("live.cdb",
                CrowdedScenario(precision + "; detector sweep(simple); pair_order sorted"));
  ASSERT_EQ(program.Run({"run", "-q", "-o", "live.h5", "live.cdb"}).status, 0);
  program.Write(
      "compare.cdb",
      "benchmark compare { trace \"crowd.trace.h5\"; repeats 2\n"
      "detector sweep(simple, octree, null, sap32, dbvt); record timing, counts, memory, pairs }");
  const Finished run = program.Run({"run", "compare.cdb"});
  ASSERT_EQ(run.status, 0) << run.out << run.err;
  const results::ResultFile live(program.folder() / "live.h5"),
      replayed(program.folder() / "compare.h5");
  const std::vector<double> pairs = PairsOf(live, 0);
  EXPECT_EQ(pairs.size(), 40u);
  EXPECT_GT(pairs.back(), 0);
  EXPECT_EQ(PairsOf(replayed, 0), pairs);
  EXPECT_EQ(PairsOf(replayed, 1), pairs);
  EXPECT_EQ(PairsOf(replayed, 2), std::vector<double>(40, 0));
  for (const std::size_t superset : {3, 4})
    for (std::size_t i = 0; i < pairs.size(); ++i)
      EXPECT_GE(PairsOf(replayed, superset)[i], pairs[i]);
  // Repeats, and detectors that agree, have the same final state; times are recorded.
  const auto hash = [&](std::size_t detector, std::uint64_t rep) {
    return replayed.ReadText("state_hash", {{detector}, rep});
  };
  EXPECT_EQ(hash(0, 0), hash(0, 1));
  EXPECT_EQ(hash(0, 0), hash(1, 0));
  EXPECT_NE(hash(0, 0), hash(2, 0));
  for (const protocol::Phase phase :
       {protocol::Phase::kBroad, protocol::Phase::kDetect, protocol::Phase::kStep})
    for (const double ns : replayed.ReadDuration(phase, {{0}, 0})) EXPECT_GT(ns, 0);
}

INSTANTIATE_TEST_SUITE_P(Precisions, Traces, testing::Values("single", "double"));

TEST(Trace, OfSeveralPointsIsAFolderAndGoesOnWhereItStopped) {
  const Program program;
  program.Write(
      "grid.cdb",
      "benchmark grid { let n = sweep(3, 4); cycles 5; repeats 2; objects.quantity n }\n");
  ASSERT_EQ(program.Run({"trace", "grid.cdb"}).status, 0);
  const auto file = program.folder() / "grid.traces" / "grid_n-3.trace.h5";
  EXPECT_TRUE(std::filesystem::exists(program.folder() / "grid.traces" / "grid_n-4.trace.h5"));
  const analysis::TraceFacts facts = results::ReadTraceFacts(file);
  EXPECT_EQ(facts.cycles, 5u);
  EXPECT_GE(facts.bodies, 3u);
  std::filesystem::remove(file);
  const Finished again = program.Run({"trace", "grid.cdb"});
  EXPECT_NE(again.out.find("grid_n-3.trace.h5: "), std::string::npos);
  EXPECT_NE(again.out.find("grid_n-4.trace.h5: exists already"), std::string::npos) << again.out;
  EXPECT_EQ(results::ReadTraceFacts(file).sha256, facts.sha256);
}

TEST(Trace, OfPairsTakesThePlaceOfOneWithoutAndServesBothPhases) {
  const Program program;
  program.Write("crowd.cdb", CrowdedScenario(""));
  program.Write("on.cdb",
                "benchmark on { trace \"crowd.trace.h5\"; narrow_phase bullet }\n"
                "benchmark boxes { trace \"crowd.trace.h5\"; detector octree }\n");
  ASSERT_EQ(program.Run({"trace", "-q", "crowd.cdb"}).status, 0);
  const auto file = program.folder() / "crowd.trace.h5";
  const analysis::TraceFacts before = results::ReadTraceFacts(file);
  const Finished refused = program.Run({"run", "on.cdb", "-b", "on"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.err.find("'crowd.trace.h5' has only boxes"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("cdb trace FILE --pairs"), std::string::npos) << refused.err;
  const Finished recorded = program.Run({"trace", "crowd.cdb", "--pairs"});
  ASSERT_EQ(recorded.status, 0) << recorded.err;
  EXPECT_NE(recorded.out.find(" pairs; "), std::string::npos) << recorded.out;
  EXPECT_EQ(results::ReadTraceFacts(file).sha256, before.sha256);
  for (const bool pairs : {false, true}) {
    const Finished again = pairs ? program.Run({"trace", "crowd.cdb", "--pairs"})
                                 : program.Run({"trace", "crowd.cdb"});
    EXPECT_NE(again.out.find("exists already"), std::string::npos) << again.out;
  }
  const Finished check = program.Run({"check", "crowd.trace.h5"});
  EXPECT_NE(check.out.find(" pairs, run "), std::string::npos) << check.out;
  const Finished run = program.Run({"run", "-q", "on.cdb"});
  ASSERT_EQ(run.status, 0) << run.out << run.err;
  const Finished show = program.Run({"show", "on.h5"});
  EXPECT_NE(show.out.find("Its largest phase is narrow: "), std::string::npos) << show.out;
  EXPECT_NE(show.out.find("ns/pair"), std::string::npos) << show.out;
  for (const char* phase : {" broad ", " solve ", " integrate "})
    EXPECT_EQ(show.out.find(phase), std::string::npos) << show.out;
  EXPECT_NE(program.Run({"show", "on.h5", "--csv"}).out.find(",ns_per_pair,"), std::string::npos);
  EXPECT_NE(program.Run({"show", "on.h5", "--json"}).out.find("\"ns_per_pair\":"),
            std::string::npos);
  const results::ResultFile narrow(program.folder() / "on.h5");
  for (const protocol::Phase phase :
       {protocol::Phase::kNarrow, protocol::Phase::kDetect, protocol::Phase::kStep})
    for (const double ns : narrow.ReadDuration(phase, {{}, 0})) EXPECT_GT(ns, 0);
  EXPECT_TRUE(narrow.Has("unhandled_pairs"));
  EXPECT_FALSE(narrow.Has("missed_pairs"));
  const Finished verified = program.Run({"verify", "on.cdb", "-b", "on"});
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
  EXPECT_NE(verified.out.find("misses none"), std::string::npos) << verified.out;
  EXPECT_EQ(verified.out.find("broad"), std::string::npos) << verified.out;
  const results::ResultFile boxes(program.folder() / "boxes.h5");
  EXPECT_FALSE(boxes.Has("contacts"));
  EXPECT_FALSE(boxes.Has("unhandled_pairs"));
}

TEST(Trace, WritesOverNothingOfAnother) {
  const Program program;
  program.Write("b.cdb", "benchmark b { cycles 2 }\n");
  program.Write("mine.h5", "mine");
  const Finished refused = program.Run({"trace", "b.cdb", "-o", "mine.h5"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("is not a trace of this run"), std::string::npos) << refused.err;
  EXPECT_EQ(program.Run({"trace", "-q", "--fresh", "b.cdb", "-o", "mine.h5"}).status, 0);
  EXPECT_EQ(results::ReadTraceFacts(program.folder() / "mine.h5").cycles, 2u);
}

TEST(Trace, OfARunThatFailsIsNone) {
  const Program program;
  program.Write("full.cdb", "benchmark full { world.side 1; objects.size 50 }\n");
  const Finished refused = program.Run({"trace", "full.cdb"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.err.find("does not fit between walls 1 m apart"), std::string::npos)
      << refused.err;
  // An error that appears only at run time: `check` decomposes no mesh.
  program.Write("tall.obj",
                "v 0 0 0\nv 1 0 0\nv 0 9 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  program.Write("full.cdb",
                "benchmark full { cycles 5; world.side 1; objects { quantity 1; size 2; type "
                "mesh(\"tall.obj\") } }\n");
  const Finished failed = program.Run({"trace", "full.cdb"});
  EXPECT_EQ(failed.status, 3);
  EXPECT_NE(failed.err.find("failed: "), std::string::npos) << failed.err;
  EXPECT_FALSE(program.Exists("full.trace.h5"));
}

TEST(Trace, ThatWasChangedIsAnotherRunAndADamagedOneIsSaid) {
  const Program program;
  program.Write("b.cdb", "benchmark b { cycles 4; objects.quantity 5 }\n");
  program.Write("on.cdb", "benchmark on { trace \"b.trace.h5\" }\n");
  const Finished none = program.Run({"run", "on.cdb"});
  EXPECT_EQ(none.status, 1);
  EXPECT_NE(none.err.find("on.cdb:1:22: error: cannot read 'b.trace.h5'"), std::string::npos)
      << none.err;
  ASSERT_EQ(program.Run({"trace", "-q", "b.cdb"}).status, 0);
  ASSERT_EQ(program.Run({"plan", "on.cdb", "-o", "on.yaml"}).status, 0);
  ASSERT_EQ(program.Run({"run", "-q", "on.cdb"}).status, 0);
  const Finished again = program.Run({"run", "on.cdb"});
  EXPECT_NE(again.err.find("'on.h5' is complete"), std::string::npos) << again.err;
  program.Write("b.cdb", "benchmark b { cycles 4; objects.quantity 6 }\n");
  ASSERT_EQ(program.Run({"trace", "-q", "--fresh", "b.cdb"}).status, 0);
  const Finished other = program.Run({"run", "on.cdb"});
  EXPECT_EQ(other.status, 0);
  EXPECT_NE(other.err.find("no finished run is part of it, 1 is new"), std::string::npos)
      << other.err;
  const Finished planned = program.Run({"run", "--fresh", "on.yaml"});
  EXPECT_EQ(planned.status, 2);
  EXPECT_NE(planned.err.find("plan again"), std::string::npos) << planned.err;
  program.Write("b.trace.h5", "nothing of the kind");
  EXPECT_EQ(program.Run({"check", "on.cdb"}).status, 1);
}

/// The frames of a cloth as PLY.
std::vector<std::string> WriteCloth(const Program& program, std::size_t frames) {
  const deforming::MeshSequence cloth = FoldingCloth(21, frames);
  std::vector<std::string> files;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
        "property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        cloth.vertices(), cloth.triangles.size());
    for (const Eigen::Vector3d& at : cloth.frames[frame])
      text += fmt::format("{} {} {}\n", at.x(), at.y(), at.z());
    for (const auto& [a, b, c] : cloth.triangles) text += fmt::format("3 {} {} {}\n", a, b, c);
    files.push_back(fmt::format("cloth_{}.ply", frame));
    program.Write(files.back(), text);
  }
  return files;
}

TEST(Trace, OfADeformingMeshServesEveryDetector) {
  const Program program;
  const std::vector<std::string> frames = WriteCloth(program, 4);
  for (const char* primitives : {"triangles", "vertex_face", "edge_edge"}) {
    std::vector<std::string> words = {"trace", "--primitives", primitives};
    words.insert(words.end(), frames.begin(), frames.end());
    const std::string name = std::string("cloth_0.") + primitives + ".trace.h5";
    const Finished traced = program.Run(words);
    ASSERT_EQ(traced.status, 0) << traced.err;
    EXPECT_NE(traced.out.find(name + ": " + primitives + " of 441 vertices, "), std::string::npos)
        << traced.out;
    const Finished again = program.Run(words);
    EXPECT_NE(again.out.find("exists already"), std::string::npos) << again.out;
    const Finished check = program.Run({"check", name});
    EXPECT_NE(check.out.find(": whole"), std::string::npos) << check.out;

    program.Write("on.cdb",
                  "benchmark on { trace \"" + name +
                      "\"; detector sweep(simple, auto, grid, hierarchical_grid, skin, "
                      "sweep, octree, kd_tree, dbvt, sap32, null); record pairs, counts }");
    const Finished run = program.Run({"run", "-q", "--fresh", "on.cdb"});
    ASSERT_EQ(run.status, 0) << run.err;
    const results::ResultFile file(program.folder() / "on.h5");
    const std::vector<double> exact = file.ReadSeries("exact_pairs", {{0}, 0});
    EXPECT_EQ(exact.size(), std::string(primitives) == "triangles" ? 4u : 3u);
    EXPECT_GT(exact.back(), 1000);
    for (std::size_t detector = 0; detector < 10; ++detector) {
      EXPECT_EQ(file.ReadSeries("missed_pairs", {{detector}, 0}),
                std::vector<double>(exact.size(), 0))
          << detector;
      for (std::size_t i = 0; i < exact.size(); ++i)
        EXPECT_GE(PairsOf(file, detector)[i], exact[i]) << detector;
    }
    EXPECT_EQ(PairsOf(file, 0), exact);
    EXPECT_EQ(file.ReadSeries("missed_pairs", {{10}, 0}), exact) << "null finds nothing";

    // The halves of the cloth meet in the last frame only.
    const std::vector<double> collisions = file.ReadSeries("exact_collisions", {{0}, 0});
    ASSERT_EQ(collisions.size(), exact.size());
    for (std::size_t i = 0; i + 1 < collisions.size(); ++i) EXPECT_EQ(collisions[i], 0) << i;
    if (std::string(primitives) == "vertex_face") {
      // Each vertex lands on another one, and touches the triangles about that: three corners of
      // 800 triangles, without those on the line of the fold.
      EXPECT_EQ(collisions.back(), 3 * 800 - 19 * 6 - 2 * 3);
    } else {
      EXPECT_GT(collisions.back(), 1000);
    }
    EXPECT_LT(collisions.back(), exact.back());
    EXPECT_EQ(file.ReadSeries("missed_collisions", {{1}, 0}), std::vector<double>(exact.size(), 0));
    EXPECT_EQ(file.ReadSeries("missed_collisions", {{10}, 0}), collisions);

    program.Write("narrow.cdb", "benchmark narrow { trace \"" + name + "\"; narrow_phase batch }");
    const Finished refused = program.Run({"check", "narrow.cdb"});
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.err.find("a deforming mesh has no poses"), std::string::npos) << refused.err;
  }
}

TEST(Trace, OfTheExampleOfADeformingMesh) {
  const Program program;
  std::vector<std::string> words = {"trace", "--primitives", "edge_edge"};
  for (const char* frame : {"fold_0.obj", "fold_1.obj", "fold_2.obj"})
    words.push_back((SourceFolder() / "examples" / frame).string());
  ASSERT_EQ(program.Run(words).status, 0);
  const analysis::TraceFacts facts =
      results::ReadTraceFacts(program.folder() / "fold_0.edge_edge.trace.h5");
  EXPECT_EQ(facts.bodies, 49u + 72 - 1);  // Euler's formula of a disc
  EXPECT_EQ(facts.cycles, 2u);
  program.Write("on.cdb", "benchmark on { trace \"fold_0.edge_edge.trace.h5\"; detector grid }");
  const Finished verified = program.Run({"verify", "on.cdb"});
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
  EXPECT_NE(verified.out.find("exact"), std::string::npos) << verified.out;
}

TEST(Trace, OfADeformingMeshSaysWhatIsWrong) {
  const Program program;
  const std::vector<std::string> frames = WriteCloth(program, 2);
  const auto said = [&](const std::vector<std::string>& words, const char* what) {
    std::vector<std::string> all = {"trace"};
    all.insert(all.end(), words.begin(), words.end());
    const Finished refused = program.Run(all);
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find(what), std::string::npos) << refused.err;
  };
  said(frames, "--primitives triangles, vertex_face, edge_edge");
  said({"a.cdb", "b.cdb"}, "'b.cdb' is one file too many");
  said({frames[0], frames[1], "--primitives", "faces"}, "--primitives faces is none of");
  said({frames[0], "--primitives", "edge_edge"}, "there is one frame; name at least two");
  said({frames[0], frames[1], "--primitives", "edge_edge", "--pairs"}, "are for scenarios");
  program.Write("other.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  said({frames[0], "other.obj", "--primitives", "edge_edge"}, "other.obj: it has 3 vertices");
  program.Write("mine.h5", "mine");
  said({frames[0], frames[1], "--primitives", "edge_edge", "-o", "mine.h5"},
       "is not a trace of this run");
}

}  // namespace
}  // namespace cdb::tests
