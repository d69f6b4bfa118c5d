#include "library/layouts/pose_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "compiler/plan/input_file.h"
#include "compiler/schema/parametrised_words.h"
#include "library/layouts/pose_columns.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using layouts::PoseTable;

std::string FaultOf(const std::string& csv) {
  try {
    layouts::ParsePoseCsv(csv, "start.csv");
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(PoseCsv, ReadsColumnsInAnyOrder) {
  const PoseTable table = layouts::ParsePoseCsv(
      "\xEF\xBB\xBF# a comment\r\n z , x, y,wy,wx,wz\r\n\r\n3,1,+2,5,4,6\r\n-0.3,.1,2e-1,0,0,0",
      "start.csv");
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_TRUE(table.has_angular_velocity);
  EXPECT_FALSE(table.has_linear_velocity || table.has_orientation);
  EXPECT_EQ(table.rows[0].position, Vector3d(1, 2, 3));
  EXPECT_EQ(table.rows[0].angular_velocity, Vector3d(4, 5, 6));
  EXPECT_EQ(table.rows[1].position, Vector3d(0.1, 0.2, -0.3));
}

TEST(PoseCsv, ReadsBackToTheBit) {
  const PoseTable table = layouts::ParsePoseCsv(
      "x,y,z,qw,qx,qy,qz,vx,vy,vz\n"
      "0.1,1e-300,-123456789.125,0.5,0.5,-0.5,0.50001,1,2,3\n0,0,0,1,0,0,0,0,0,0\n",
      "start.csv");
  const PoseTable back = layouts::ParsePoseCsv(layouts::ToCsv(table), "again.csv");
  ASSERT_EQ(back.rows.size(), 2u);
  EXPECT_EQ(back.rows[0].position, table.rows[0].position);
  EXPECT_EQ(back.rows[0].orientation.coeffs(), table.rows[0].orientation.coeffs());
  EXPECT_NEAR(back.rows[0].orientation.norm(), 1, 1e-15);
  EXPECT_EQ(layouts::ToCsv(back), layouts::ToCsv(table));
}

TEST(PoseCsv, RefusesByLineAndColumn) {
  const std::pair<const char*, const char*> rows[] = {
      {"", "start.csv: it is empty; write a line of column names first"},
      {"x,y,z\n", "it has no objects; write a line for each object"},
      {"x,y\n1,2\n", "start.csv:1: 1 of the columns x, y, z are missing"},
      {"x,y,z,vx\n1,2,3,4\n", "start.csv:1: 2 of the columns vx, vy, vz are missing; give all"},
      {"x,y,z,mass\n", "start.csv:1: `mass` is not a known column; name those to read"},
      {"x,y,z,mass\n1,2,3,4\n",
       "`mass` is not a known column; name those to read: columns: \"x=x, y=y, z=z\"; it has #1"},
      {"id,pos.x,pos.y,pos.z\n",
       "start.csv:1: `id`, `pos.x`, `pos.y`, `pos.z` are not known columns; name those to read: "
       "columns: \"x=pos.x, y=pos.y, z=pos.z\""},
      {"Frame,X,Y,Z,X,Y,Z\n1,2,3,4,5,6,7\n", "name those to read: columns: \"x=…, y=…, z=…\"; it"},
      {"1,2,3\n", "start.csv: it has no headings; write a line of column names first: x,y,z"},
      {"x [s],y,z\n1,2,3\n", "the column `x [s]` cannot be x in this unit; x is in m or"},
      {"x,y,z,roll,pitch,yaw\n", "the angles in the column `roll` have no unit; write deg or rad"},
      {"x,y,z,roll [deg],pitch [deg],yaw [deg]\n1,2,3,0,0,0\n", "the meaning of rx, ry, rz"},
      {"x,y,z,x\n", "the column `x` occurs twice"},
      {"x,y,z\n1,2,3\n1,2\n", "start.csv:3: 2 values in this line, but 3 columns"},
      {"x,y,z\n1,2,3,\n", "start.csv:2: 4 values in this line"},
      {"x,y,z\n\n# no\n1,2,nan\n", "start.csv:4: z is `nan`, which is not a finite number"},
      {"x,y,z\n1,inf,2\n", "y is `inf`"},
      {"x,y,z\n1,,2\n", "y is ``"},
      {"x,y,z\n1,2 m,2\n", "y is `2 m`"},
      {"x,y,z\n1,1e300,2\n", "y is 1e+300, beyond 1e+15"},
      {"x,y,z,qw,qx,qy,qz\n1,2,3,0,0,0,0\n", "start.csv:2: qw, qx, qy, qz are not a unit"},
  };
  for (const auto& [csv, message] : rows)
    EXPECT_NE(FaultOf(csv).find(message), std::string::npos) << csv << "\n" << FaultOf(csv);
}

/// Reads one row with arguments, each a name and a word or, for `columns`, a text.
layouts::PoseRow RowWith(const std::string& text, std::string_view word,
                         const std::vector<std::pair<std::string, std::string>>& arguments) {
  schema::Call call = layouts::TableCall(word, "start.csv");
  const auto rows = schema::FindParametrisedWord(word)->arguments;
  for (const auto& [name, value] : arguments) {
    const auto row = std::ranges::find(rows, name, &schema::Parameter::name);
    call.arguments[static_cast<std::size_t>(row - rows.begin())] =
        name == "columns" ? schema::Value(schema::Text{value}) : schema::Value(Word(value));
  }
  return layouts::ParsePoseText(text, call).rows.back();
}

TEST(PoseText, ReadsNamedColumns) {
  const std::string rosbag =
      "%time,field.header.seq,field.pose.position.x,field.pose.position.y,field.pose.position.z\n"
      "1305031102175304000,1,0,0,0\n1305031102675304000,2,1,2,3\n";
  const auto row = RowWith(rosbag, "path",
                           {{"columns",
                             "t=%time [ns], x=field.pose.position.x, y=field.pose.position.y, "
                             "z=field.pose.position.z"},
                            {"start", "first"},
                            {"up", "z"}});
  EXPECT_NEAR(row.time, 0.5, 1e-6);
  EXPECT_EQ(row.position, Vector3d(1, 3, -2));
}

TEST(PoseText, ReadsRotationsInTheOrderNamed) {
  using Eigen::AngleAxisd, Eigen::Quaterniond;
  const Quaterniond x(AngleAxisd(0.3, Vector3d::UnitX())), y(AngleAxisd(0.4, Vector3d::UnitY())),
      z(AngleAxisd(0.5, Vector3d::UnitZ()));
  const std::string text = "x,y,z,roll [rad],pitch [rad],yaw [rad]\n1,2,3,0.3,0.4,0.5\n";
  const auto turn = [&](const char* rotation, const char* up = "y") {
    return RowWith(text, "poses", {{"rotation", rotation}, {"up", up}}).orientation;
  };
  EXPECT_LT(turn("intrinsic_zyx").angularDistance(z * y * x), 1e-7);
  EXPECT_LT(turn("extrinsic_xyz").angularDistance(z * y * x), 1e-7);
  EXPECT_LT(turn("extrinsic_yzx").angularDistance(x * z * y), 1e-7);
  const Vector3d axis(0.3, 0.4, 0.5);
  EXPECT_LT(turn("vector").angularDistance(Quaterniond(AngleAxisd(axis.norm(), axis.normalized()))),
            1e-7);
  // With z up, what pointed along the file's z points along y.
  const Vector3d up = turn("extrinsic_xyz", "z") * ((z * y * x).inverse() * Vector3d::UnitZ());
  EXPECT_LT((up - Vector3d::UnitY()).norm(), 1e-12);
}

schema::Value Poses(const std::filesystem::path& file, const std::string& sha256) {
  return Layout("poses", {{"file", schema::Text{file.string()}}, {"sha256", schema::Text{sha256}}});
}

class PoseFiles : public testing::Test {
 protected:
  schema::Value Write(const std::string& csv) {
    WriteFile(folder_.path() / "start.csv", csv);
    return Poses(folder_.path() / "start.csv", plan::Sha256Hex(csv));
  }
  TemporaryFolder folder_;
};

TEST_F(PoseFiles, PlaceTurnAndMove) {
  plan::Scene scene =
      LayoutScene(2, 40,
                  Write("x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz\n1,2,3,0,1,0,0,4,5,6,7,8,9\n"
                        "-5,0,0,1,0,0,0,0,0,0,0,0,0\n"));
  SetGroup(scene, "type", Word("cone"));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  EXPECT_EQ(state.objects[0].pose.position, Vector3d(1, 2, 3));
  EXPECT_EQ(state.objects[0].pose.orientation.coeffs(), Eigen::Vector4d(1, 0, 0, 0));
  EXPECT_EQ(state.objects[0].linear_velocity, Vector3d(4, 5, 6));
  EXPECT_EQ(state.objects[0].angular_velocity, Vector3d(7, 8, 9));
  EXPECT_EQ(state.objects[1].pose.position, Vector3d(-5, 0, 0));
  EXPECT_EQ(state.objects[1].linear_velocity, Vector3d::Zero());
}

TEST_F(PoseFiles, AreCheckedAsOtherLayouts) {
  const schema::Value close = Write("x,y,z\n0,0,0\n0.5,0,0\n");
  EXPECT_NE(FailureOf(LayoutScene(2, 40, close)).find("overlaps"), std::string::npos);
  EXPECT_EQ(FailureOf(LayoutScene(3, 40, close)),
            "group `objects` has 3 objects, but its file has the poses of 2; remove the quantity, "
            "or name another file");
  const schema::Value low = Write("x,y,z\n0,-19.6,0\n");
  plan::Scene scene = LayoutScene(1, 40, low);
  EXPECT_NE(FailureOf(scene).find("reaches 0.1 m through the cube's wall -y"), std::string::npos)
      << FailureOf(scene);
  // Permits an object that lay on the floor when it was recorded.
  SetGroup(scene, "overlap", true);
  EXPECT_EQ(FailureOf(scene), "");
  SetGroup(scene, "location", Write("x,y,z\n0,-20.1,0\n"));
  EXPECT_NE(FailureOf(scene).find("wall -y"), std::string::npos);
}

TEST_F(PoseFiles, RefuseAChangedFile) {
  const schema::Value poses = Write("x,y,z\n0,0,0\n");
  EXPECT_EQ(FailureOf(LayoutScene(1, 40, poses)), "");
  WriteFile(folder_.path() / "start.csv", "x,y,z\n0,0,1\n");
  EXPECT_NE(FailureOf(LayoutScene(1, 40, poses))
                .find("differs from the file that the plan was made with"),
            std::string::npos);
}

TEST(PackedPoses, ComeBackByTheirCall) {
  layouts::SetPoseReader([](const schema::Call& poses) {
    const bool is_first = std::get<schema::Text>(schema::ArgumentOf(poses, "file")).text == "a.h5";
    PoseTable table;
    table.has_orientation = is_first;
    table.rows.resize(is_first ? 2 : 1);
    table.rows[0].position = {0.1, 0.2, 0.3};
    return table;
  });
  const auto any = [](const char* file) { return Layout("poses", {{"file", schema::Text{file}}}); };
  plan::Scene scene = LayoutScene(2, 40, any("a.h5"));
  AddGroup(scene, "b", 1, any("b.h5"));
  const std::string packed = layouts::PackPoses(scene);
  const PoseTable a = layouts::UnpackPoses(packed, *schema::AsCall(any("a.h5"))),
                  b = layouts::UnpackPoses(packed, *schema::AsCall(any("b.h5")));
  EXPECT_EQ(a.rows.size(), 2u);
  EXPECT_TRUE(a.has_orientation);
  EXPECT_EQ(b.rows.size(), 1u);
  EXPECT_FALSE(b.has_orientation);
  EXPECT_EQ(b.rows[0].position, Vector3d(0.1, 0.2, 0.3));
  EXPECT_THROW(layouts::UnpackPoses(packed, *schema::AsCall(any("c.h5"))), library::SceneError);
  layouts::SetPoseReader({});
}

TEST(PackedPoses, KeepTheTimesOfPaths) {
  PoseTable table;
  table.has_time = table.has_orientation = true;
  table.rows.resize(2);
  table.rows[1].time = 0.5;
  table.rows[1].position = {0.1, 0.2, 0.3};
  layouts::SetPoseReader([&](const schema::Call&) { return table; });
  const auto path = Layout("path", {{"file", schema::Text{"a.h5"}}});
  const std::string packed = layouts::PackPoses(LayoutScene(1, 40, path));
  const schema::Call& call = *schema::AsCall(path);
  EXPECT_EQ(layouts::ToCsv(layouts::UnpackPoses(packed, call)), layouts::ToCsv(table));
  EXPECT_EQ(layouts::ReadPath(call).PositionAt(0.25), Vector3d(0.05, 0.1, 0.15));
  layouts::SetPoseReader({});
}

}  // namespace
}  // namespace cdb::tests
