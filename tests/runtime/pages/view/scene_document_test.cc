// The document of a page, for real runs.
#include "runtime/pages/view/scene_document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/pages/view/glb.h"
#include "tests/runtime/pages/view/unpack.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr const char* kFallScenario = R"(benchmark fall "Falling <b>things</b>" {
  cycles 12
  world.side 10
  record timing, counts, stability, contacts, poses, boxes
  objects floor { quantity 1; type cuboid; size 4; location at(0, -3, 0); mass fixed }
  objects { quantity 6; type any(sphere, capsule, cone, tetrahedron); aspect 1 : 2 : 1; size 1
    angular_velocity uniform(-3, 3) }
}
)";

class SceneDocumentTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    program_ = new Program;
    program_->Write("fall.cdb", kFallScenario);
    const Finished run = program_->Run({"run", "-q", "fall.cdb"});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  static void TearDownTestSuite() { delete program_; }

  static results::ResultFile File() { return results::ResultFile(program_->folder() / "fall.h5"); }
  static view::SceneRecording Recording(const view::FrameChoice& choice = {}) {
    const results::ResultFile file = File();
    return view::ReadRecording(file, view::DefaultCell(file), choice);
  }
  static json RunOf(const view::SceneRecording& recording) {
    return json::parse(view::SceneDocument("title", {&recording, 1})).at("runs").at(0);
  }

  static Program* program_;
};
Program* SceneDocumentTest::program_ = nullptr;

TEST_F(SceneDocumentTest, HasThePosesOfTheFile) {
  const results::ResultFile file = File();
  const json run = RunOf(Recording());
  ASSERT_EQ(run["frames"]["count"], 12);
  const auto positions = Unpack<float>(run["frames"]["position"]);
  const auto words = Unpack<std::uint16_t>(run["frames"]["orientation"]);
  ASSERT_EQ(positions.size(), 12U * 7 * 3);
  for (std::size_t cycle = 0; cycle < 12; ++cycle) {
    const std::vector<double> poses = file.ReadCycle("poses", {{}, 0}, cycle);
    for (std::size_t body = 0; body < 7; ++body) {
      const double* pose = &poses[body * protocol::kPoseSize];
      const std::size_t at = 3 * (cycle * 7 + body);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(positions[at + i], static_cast<float>(pose[i]));
      const Eigen::Quaterniond q(pose[6], pose[3], pose[4], pose[5]);
      EXPECT_LT(UnpackQuaternion(&words[at]).angularDistance(q), 4 * view::kQuaternionError + 1e-6);
      // The floor does not move; the falling object does.
      EXPECT_EQ(words[at + 2] >> 15, body == 0 && cycle > 0 ? 1 : 0);
    }
  }
}

TEST_F(SceneDocumentTest, HasSeriesContactsAndBoxes) {
  const results::ResultFile file = File();
  const json run = RunOf(Recording());
  const auto counts = Unpack<std::int32_t>(run["contacts"]["count"]);
  const std::vector<double> recorded = file.ReadSeries("contacts", {{}, 0});
  EXPECT_TRUE(std::ranges::equal(counts, recorded));
  EXPECT_EQ(Unpack<float>(run["boxes"]).size(), 12U * 7 * 6);
  EXPECT_EQ(run["durations"].size(), protocol::kPhaseCount);
  const auto step = Unpack<float>(run["durations"][5]["values"]);
  const std::vector<double> step_ns = file.ReadDuration(protocol::Phase::kStep, {{}, 0});
  ASSERT_EQ(step.size(), step_ns.size());
  for (std::size_t i = 0; i < step.size(); ++i) EXPECT_EQ(step[i], static_cast<float>(step_ns[i]));
}

TEST_F(SceneDocumentTest, ShowsOnlyTheCyclesThatAreChosen) {
  const json run = RunOf(Recording({.first = 2, .last = 9, .every = 3}));
  EXPECT_EQ(run["frames"]["count"], 3);  // 2, 5, 8
  EXPECT_EQ(run["frames"]["first"], 2);
  const std::vector<double> poses = File().ReadCycle("poses", {{}, 0}, 5);
  const auto positions = Unpack<float>(run["frames"]["position"]);
  EXPECT_EQ(positions[3 * (7 + 4)], static_cast<float>(poses[4 * protocol::kPoseSize]));
}

TEST_F(SceneDocumentTest, ThinsWhatIsTooLargeAndSaysSo) {
  view::FrameChoice choice;
  choice.budget_bytes = Unpack<char>(RunOf(Recording())["frames"]["position"]).size();
  const view::SceneRecording recording = Recording(choice);
  EXPECT_GT(recording.every, 1U);
  EXPECT_LT(recording.FrameCount(), 12U);
  ASSERT_EQ(recording.notices.size(), 1U);
  EXPECT_THAT(recording.notices[0], HasSubstr("the page would be too large"));
}

TEST_F(SceneDocumentTest, RefusesCyclesThatDidNotRun) {
  for (const char* cycles : {"12..", "3..12", "5..4"}) {
    view::FrameChoice choice;
    view::ParseCycles(cycles, choice);
    EXPECT_THROW(Recording(choice), files::StoreError) << cycles;
  }
  view::FrameChoice choice;
  for (const char* cycles : {"", "a..b", "1..2..3", "-1"})
    EXPECT_THROW(view::ParseCycles(cycles, choice), files::StoreError) << cycles;
}

// A .glb file is a header and two chunks; its animation has the times and positions of the poses.
TEST_F(SceneDocumentTest, IsWrittenAsBinaryGltf) {
  const view::SceneRecording recording = Recording();
  const std::string glb = view::SceneGlb(recording);
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, &glb[at], 4);
    return value;
  };
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(word(8), glb.size());
  const std::size_t length = word(12);
  const json document = json::parse(glb.substr(20, length));
  const std::string binary = glb.substr(28 + length);
  const auto floats = [&](std::size_t accessor) {
    const json& view =
        document["bufferViews"][document["accessors"][accessor]["bufferView"].get<std::size_t>()];
    std::vector<float> values(view["byteLength"].get<std::size_t>() / 4);
    std::memcpy(values.data(), &binary[view["byteOffset"].get<std::size_t>()], values.size() * 4);
    return values;
  };
  const json& animation = document["animations"][0];
  ASSERT_EQ(animation["channels"].size(), 14U);
  const auto times = floats(animation["samplers"][0]["input"]);
  ASSERT_EQ(times.size(), 12U);
  EXPECT_FLOAT_EQ(times[11], static_cast<float>(11.0 / 60));
  const auto positions = floats(animation["samplers"][2 * 3]["output"]);  // of body 3
  for (std::size_t frame = 0; frame < 12; ++frame)
    EXPECT_EQ(positions[3 * frame + 1],
              static_cast<float>(recording.poses[(frame * 7 + 3) * protocol::kPoseSize + 1]));
}

// The errors of a run are series over its samples.
TEST(SceneDocument, HasTheErrorsOfARun) {
  const Program program;
  program.Write("flight.cdb", R"(benchmark flight {
  cycles 20; timestep 1 / 20; world.side 500; world.walls none
  record timing, counts, poses
  objects { quantity 2; linear_velocity uniform(-20, 20) }
  accuracy { metrics position; interval 1 / 4; closed_form flight }
})");
  const Finished run = program.Run({"run", "-q", "flight.cdb"});
  ASSERT_EQ(run.status, 0) << run.err;
  const results::ResultFile file(program.folder() / "flight.h5");
  const view::SceneRecording recording = view::ReadRecording(file, {{}, 0}, {});
  const auto error =
      std::ranges::find(recording.series, "error of position", &view::CycleSeries::name);
  ASSERT_NE(error, recording.series.end());
  EXPECT_EQ(error->interval_s, 0.25);
  ASSERT_EQ(error->values.size(), 5U);  // at 0, 1/4, ... 1 s
  EXPECT_LT(error->values[0], 1e-6);    // float32
  EXPECT_GT(error->values[4], error->values[0]);
}

TEST(SceneDocument, HasTheNodesOfSoftBodies) {
  const Program program;
  program.Write("soft.cdb", R"(benchmark soft {
  cycles 10; world { side 10; walls none }
  record timing, counts, vertices
  objects ball { quantity 1; size 2; mass fixed; location at(-3, 0, 0) }
  objects rope { quantity 1; type rope(segments: 3); size 1; margin 0.01; location at(2, 1, 0) }
  objects cloth { quantity 1; type cloth(columns: 2, rows: 1); size 1; margin 0.01
    location at(1, 3, 0) }
  objects moves { quantity 1; size 1; mass 1; location at(0, -3, 0); linear_velocity (0, 0, 6) }
})");
  const Finished run = program.Run({"run", "-q", "soft.cdb"});
  ASSERT_EQ(run.status, 0) << run.err;
  const results::ResultFile file(program.folder() / "soft.h5");
  const view::SceneRecording recording = view::ReadRecording(file, {{}, 0}, {});
  const json shown = json::parse(view::SceneDocument("soft", {&recording, 1}))["runs"][0];
  // Only the balls have a mesh.
  EXPECT_EQ(Unpack<std::int32_t>(shown["parts"]["body"]), (std::vector<std::int32_t>{0, 3}));
  const json& soft = shown["soft"];
  EXPECT_EQ(soft["nodes"], 10);
  ASSERT_EQ(soft["bodies"].size(), 2u);
  EXPECT_EQ(soft["bodies"][1]["first"], 4);
  EXPECT_EQ(Unpack<std::int32_t>(soft["bodies"][0]["links"]),
            (std::vector<std::int32_t>{0, 1, 1, 2, 2, 3}));
  EXPECT_EQ(Unpack<std::int32_t>(soft["bodies"][1]["triangles"]).size(), 4u * 3);
  const auto position = Unpack<float>(soft["position"]);
  ASSERT_EQ(position.size(), 10u * 10 * 3);
  const std::vector<double> nodes = file.ReadCycle("vertex_positions", {{}, 0}, 9);
  for (std::size_t i = 0; i < 30; ++i)
    EXPECT_EQ(position[9 * 30 + i], static_cast<float>(nodes[i]));
  // A soft body is where the middle of its nodes is.
  const auto places = Unpack<float>(shown["frames"]["position"]);
  EXPECT_NEAR(places[(9 * 4 + 1) * 3], 2, 1e-5);
  EXPECT_NEAR(places[(9 * 4 + 1) * 3 + 1], nodes[1], 1e-5);
  EXPECT_EQ(places[9 * 4 * 3], -3);                          // the ball
  EXPECT_NEAR(places[(9 * 4 + 3) * 3 + 2], 10 * 0.1, 1e-4);  // the one that moves, at 60 Hz
}

TEST(SceneDocument, ShowsTheStartOfSoftBodies) {
  const Program program;
  program.Write("soft.cdb", R"(benchmark soft {
  world { side 10; walls none }
  objects { quantity 1; type rope(segments: 2); size 2; location at(2, 1, 0) }
})");
  ASSERT_EQ(program.Run({"plan", "soft.cdb", "-o", "soft.yaml"}).status, 0);
  const plan::Plan plan = yaml::FromYaml(program.Read("soft.yaml"), "soft.yaml");
  const view::SceneRecording recording = view::StartOf(plan, plan.runs[0]);
  const json shown = json::parse(view::SceneDocument("soft", {&recording, 1}))["runs"][0];
  const auto position = Unpack<float>(shown["soft"]["position"]);
  ASSERT_EQ(position.size(), 9u);
  for (std::size_t node = 0; node < 3; ++node) {
    EXPECT_NEAR(position[3 * node], 1 + static_cast<double>(node), 1e-6);
    EXPECT_EQ(position[3 * node + 1], 1);
  }
  const Finished glb = program.Run({"view", "soft.cdb", "--gltf", "soft.glb"});
  EXPECT_NE(glb.status, 0);
  EXPECT_THAT(glb.err, HasSubstr("soft bodies"));
}

// With CDB_UPDATE_GOLDEN=1 in the environment, the file is rewritten instead.
TEST(SceneDocument, IsAsItWas) {
  const Program program;
  program.Write("two.cdb", R"(benchmark two "Two objects" {
  world { side 10; walls floor }
  objects { quantity 1; type tetrahedron; size 1; location at(1, 2, 3) }
  objects ball { quantity 1; size 2; mass fixed; location at(-3, 0, 0) }
})");
  ASSERT_EQ(program.Run({"plan", "two.cdb", "-o", "two.yaml"}).status, 0);
  const plan::Plan plan = yaml::FromYaml(program.Read("two.yaml"), "two.yaml");
  view::SceneRecording recording = view::StartOf(plan, plan.runs[0]);
  json document = json::parse(view::SceneDocument("two", {&recording, 1}));
  // The ball has hundreds of vertices, whose last bits depend on the standard library's sine.
  for (json& mesh : document["runs"][0]["meshes"])
    if (mesh["name"] == "sphere") mesh = {{"name", "sphere"}};
  const std::string golden = (SourceFolder() / "tests/golden/view/two.json").string();
  const std::string text = document.dump(2) + "\n";
  if (const char* update = std::getenv("CDB_UPDATE_GOLDEN"); update != nullptr)
    WriteFile(golden, text);
  EXPECT_EQ(text, ReadFile(golden));
}

}  // namespace
}  // namespace cdb::tests
