// Traces of pairs: recorded to the bit, and replayed.
#include "runtime/engine/worker/replay_pairs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "compiler/plan/input_file.h"
#include "compiler/yaml/plan_yaml.h"
#include "runtime/engine/worker/narrow_input.h"
#include "runtime/engine/worker/replay.h"
#include "runtime/protocol/trace_memory.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/compile_text.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

/// Every kind of shape: balls, boxes and rods that collide with each other, a compound, and as
/// ground a plane, a height field and a surface.
std::string Everything(const std::string& ground) {
  return fmt::format(
      "benchmark b {{ cycles 40; precision {}; world {{ side 10; walls floor }}\n"
      "objects {{ quantity 40; type any(sphere, cuboid, capsule, cylinder, cone, tetrahedron)\n"
      "  size uniform(0.6, 1.2); linear_velocity uniform(-6, 6); orientation random }}\n"
      "objects rings {{ quantity 3; type torus; size 1.5; linear_velocity uniform(-3, 3) }}\n"
      "{} }}\n",
      world::EnginePrecision(), ground);
}

class PairTraces : public testing::Test {
 protected:
  plan::Run RunOf(const std::string& text) {
    const compiler::Compilation compiled = CompileText(text, others_);
    EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
    plan::Run run = compiled.plans.at(0).runs.at(0);
    const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
      run.scene.world.Set(parameter, std::move(value));
    };
    set("record", schema::WordList{"boxes", "poses", "counts"});
    set("pair_order", schema::Word{"sorted"});
    set("accuracy.metrics", schema::WordList{"none"});
    return run;
  }

  /// A square in the plane y = 0, and a field with a hill.
  std::string SurfaceGround() {
    const std::string obj = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n";
    return GroundOf("surface", ".obj", obj);
  }
  std::string HeightGround() { return GroundOf("heights", ".csv", "0,0,0\n0,1,0\n0,0,0\n"); }

  std::string GroundOf(const char* type, const char* ending, const std::string& bytes) {
    const std::string file = (folder_ / (std::string(type) + ending)).string();
    WriteFile(file, bytes);
    others_[file] = bytes;
    return fmt::format(
        "objects ground {{ quantity 1; type {}(\"{}\"); size 9; mass fixed; location at(0, -4.6, "
        "0) "
        "}}",
        type, file);
  }

  TemporaryFolder folder_;
  std::map<std::string, std::string> others_;
};

/// What a narrow phase gets.
struct Seen {
  std::vector<std::vector<Pose>> poses;
  std::vector<std::vector<Pair>> pairs;
};

/// Notes what it gets, and finds the contacts of balls about the bodies.
class Spy final : public Detector {
 public:
  explicit Spy(Seen& seen) : seen_(seen) {}
  void FindContacts(const cdb::Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    seen_.poses.emplace_back(scene.poses.begin(), scene.poses.end());
    seen_.pairs.emplace_back(pairs.begin(), pairs.end());
    std::ranges::sort(seen_.pairs.back());
    for (const Pair& pair : pairs) {
      if (scene.shapes[pair.b].kind == ShapeKind::kPlane) continue;
      const Vec3 &a = scene.poses[pair.a].position, &b = scene.poses[pair.b].position;
      const Eigen::Vector3d apart(a.x - b.x, a.y - b.y, a.z - b.z);
      const double distance = apart.norm() - 1;
      if (distance > 0.01 || apart.norm() == 0) continue;
      const Eigen::Vector3d n = apart.normalized();
      const Eigen::Vector3d on_b = Eigen::Vector3d(b.x, b.y, b.z) + 0.5 * n,
                            on_a = on_b + distance * n;
      contacts.push_back({pair.a,
                          pair.b,
                          {on_a.x(), on_a.y(), on_a.z()},
                          {on_b.x(), on_b.y(), on_b.z()},
                          {n.x(), n.y(), n.z()},
                          distance});
    }
  }

 private:
  Seen& seen_;
};

bool SameBits(const double* frame, const Pose& pose) {
  const Vec3 parts[] = {pose.position, pose.x, pose.y, pose.z};
  for (const Vec3& part : parts) {
    const double values[] = {part.x, part.y, part.z};
    if (std::memcmp(values, frame, sizeof values) != 0) return false;
    frame += 3;
  }
  return true;
}

TEST_F(PairTraces, HoldToTheBitWhatANarrowPhaseGets) {
  const plan::Run run = RunOf(Everything(SurfaceGround()));
  Seen seen;
  detection::Detectors detectors;
  detectors.broad = detection::MakeDetector("auto", run.scene);
  detectors.narrow = {"spy", cdb::kNarrow, 0, std::make_shared<Spy>(seen)};
  plan::Scene scene = run.scene;
  scene.world.Set(schema::WorldParameter("record"), schema::WordList{});
  world::Engine engine(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene),
                       detectors);
  const int fd = memfd_create("input", 0);
  worker::NarrowInput input(engine, fd);
  input.Begin();
  constexpr std::uint64_t kSteps = 40;
  Steps(engine, kSteps);
  ASSERT_EQ(seen.pairs.size(), kSteps);
  const std::size_t bodies = engine.objects().size() + engine.walls().size();
  std::size_t at = 8, all = 0;
  for (std::uint64_t cycle = 0; cycle < kSteps; ++cycle) {
    std::uint64_t count = 0;
    ASSERT_EQ(pread(fd, &count, 8, static_cast<off_t>(at)), 8);
    std::vector<btScalar> scalars(bodies * protocol::kFrameSize);
    const auto bytes = static_cast<ssize_t>(scalars.size() * sizeof(btScalar));
    ASSERT_EQ(
        pread(fd, scalars.data(), static_cast<std::size_t>(bytes), static_cast<off_t>(at + 8)),
        bytes);
    const std::vector<double> frames(scalars.begin(), scalars.end());
    std::vector<Pair> pairs(count);
    at += 8 + static_cast<std::size_t>(bytes);
    ASSERT_EQ(pread(fd, pairs.data(), count * 8, static_cast<off_t>(at)),
              static_cast<ssize_t>(count * 8));
    at += count * 8;
    all += count;
    EXPECT_EQ(pairs, seen.pairs[cycle]) << cycle;
    for (std::size_t i = 0; i < bodies; ++i)
      ASSERT_TRUE(SameBits(&frames[i * protocol::kFrameSize], seen.poses[cycle][i])) << i;
  }
  EXPECT_GT(all, 1000u);
  close(fd);
}

/// A run, its recording and its trace of pairs.
struct Traced {
  Recorded live;
  protocol::TraceMemory trace;
};

Traced TraceOf(const plan::Run& run) {
  const int fd = memfd_create("input", 0);
  Recorded live = RunHere(run.scene, {.narrow_input_fd = fd});
  EXPECT_TRUE(live.done()) << live.message();
  protocol::TraceMemory trace =
      protocol::TraceOfPairs(run.scene, live.recording, fd, yaml::RunToYaml(run));
  close(fd);
  return {std::move(live), std::move(trace)};
}

std::span<const protocol::TracePair> PairsOf(const protocol::TraceMemory& trace,
                                             std::uint64_t cycle) {
  const auto first = trace.first_pairs();
  return trace.pairs().subspan(first[cycle], first[cycle + 1] - first[cycle]);
}

/// The run of a narrow phase on the trace.
plan::Run Replaying(const plan::Run& traced, const protocol::TraceMemory& trace,
                    const std::string& narrow_phase, schema::WordList record) {
  plan::Run run;
  run.scene = DefaultScene(trace.shape().bodies, 1);
  run.scene.plugins = traced.scene.plugins;
  SetWorld(run.scene, "trace",
           schema::Call{"file", {schema::Text{"t.h5"}, schema::Text{trace.PairsSha256()}}});
  SetWorld(run.scene, "narrow_phase", Word(narrow_phase.c_str()));
  SetWorld(run.scene, "cycles", trace.shape().cycles);
  SetWorld(run.scene, "warmup", std::uint64_t{0});
  SetWorld(run.scene, "precision", Word(world::EnginePrecision()));
  SetWorld(run.scene, "world.walls", Word("none"));
  SetWorld(run.scene, "record", std::move(record));
  return run;
}

protocol::Recording Replay(const plan::Run& run, const protocol::TraceMemory& trace) {
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  worker::ReplayTrace(run, recording, trace.fd());
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kDone)
      << recording.header().message.str();
  return recording;
}

TEST_F(PairTraces, GiveBulletTheContactsOfTheLiveRun) {
  for (const std::string& ground : {std::string(), SurfaceGround(), HeightGround()}) {
    SCOPED_TRACE(ground);
    const plan::Run run = RunOf(Everything(ground));
    const Traced traced = TraceOf(run);
    const protocol::Recording replayed =
        Replay(Replaying(run, traced.trace, "bullet", {"timing", "counts", "pairs"}), traced.trace);
    const auto live = traced.live.recording.Ints("contacts"), again = replayed.Ints("contacts");
    ASSERT_EQ(again.size(), 40u);
    EXPECT_GT(std::accumulate(live.begin(), live.end(), 0), 100);
    EXPECT_TRUE(std::ranges::equal(again, live));
    EXPECT_TRUE(
        std::ranges::equal(replayed.Ints("manifolds"), traced.live.recording.Ints("manifolds")));
    for (const double ns :
         replayed.Reals("duration").subspan(protocol::IndexOf(protocol::Phase::kNarrow) * 40, 40))
      EXPECT_GT(ns, 0);
    const auto exact = replayed.Ints("exact_contacts");
    EXPECT_GT(std::accumulate(exact.begin(), exact.end(), 0), 50);
    for (const std::int32_t count : replayed.Ints("unhandled_pairs")) EXPECT_EQ(count, 0);
    EXPECT_GE(replayed.Reals("max_depth_error")[39], replayed.Reals("depth_error")[39]);
  }
}

TEST_F(PairTraces, BeginAfterTheWarmup) {
  std::string text = Everything("");
  const Traced whole = TraceOf(RunOf(text));
  text.replace(text.find("cycles 40"), 9, "cycles 37; warmup 3");
  const Traced late = TraceOf(RunOf(text));
  for (std::uint64_t cycle = 0; cycle < 37; ++cycle) {
    ASSERT_TRUE(
        std::ranges::equal(late.trace.FrameBytes(cycle), whole.trace.FrameBytes(cycle + 3)));
    ASSERT_TRUE(std::ranges::equal(PairsOf(late.trace, cycle), PairsOf(whole.trace, cycle + 3)));
  }
}

TEST_F(PairTraces, CountWhatANarrowPhaseLeavesToBullet) {
  const plan::Run run = RunOf(Everything(SurfaceGround()));
  const Traced traced = TraceOf(run);
  for (const schema::DetectorInfo& info : schema::Detectors()) {
    const schema::DetectorPart* part = schema::FindDetectorPart(info.part);
    if (info.name == "bullet" || !info.HasPhase("narrow") || (part != nullptr && !part->is_built))
      continue;
    SCOPED_TRACE(info.name);
    const protocol::Recording replayed = Replay(
        Replaying(run, traced.trace, std::string(info.name), {"counts", "pairs"}), traced.trace);
    const auto unhandled = replayed.Ints("unhandled_pairs"), pairs = replayed.Ints("pairs");
    EXPECT_GT(std::accumulate(unhandled.begin(), unhandled.end(), 0), 0) << "of the surface";
    for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_LE(unhandled[i], pairs[i]);
    for (const std::int32_t count : replayed.Ints("bullet_contacts"))
      EXPECT_EQ(count, 0) << "contacts of others are not judged";
  }
}

TEST_F(PairTraces, OfAnotherRunAreRefused) {
  const plan::Run run = RunOf(Everything(""));
  const Traced traced = TraceOf(run);
  protocol::TraceShape shape = traced.trace.shape();
  --shape.bodies;
  shape.pairs = 0;
  protocol::TraceMemory less = protocol::TraceMemory::Create(shape);
  less.SetRun(traced.trace.walls(), yaml::RunToYaml(run));
  const plan::Run replaying = Replaying(run, less, "bullet", {"counts"});
  protocol::Recording recording = protocol::Recording::Create(replaying.scene);
  worker::ReplayTrace(replaying, recording, less.fd());
  EXPECT_EQ(recording.header().outcome.load(), protocol::WorkerOutcome::kFailed);
  EXPECT_NE(recording.header().message.str().find("record it again"), std::string::npos)
      << recording.header().message.str();
}

}  // namespace
}  // namespace cdb::tests
