#include "runtime/results/store.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "runtime/results/hdf5/file.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using hdf5::Type;

class PoseArraysOf : public testing::Test {
 protected:
  void Add(hdf5::File& file, const char* name, const hdf5::Shape& shape,
           Type type = Type::kFloat64) {
    hdf5::Dataset dataset = file.CreateDataset({name, type, shape, {}, 0});
    if (type == Type::kText) {
      dataset.WriteText(std::vector<std::string>(hdf5::Product(shape), "x"));
      return;
    }
    std::vector<double> values(hdf5::Product(shape));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i);
    dataset.Write(values);
  }
  std::string Fault() {
    try {
      results::ReadPoseArrays(path_);
    } catch (const files::StoreError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "start.h5";
};

TEST_F(PoseArraysOf, AreReadAsTheyStand) {
  hdf5::File file = hdf5::File::Create(path_);
  Add(file, "position", {2, 3}, Type::kFloat32);
  Add(file, "angular_velocity", {2, 3}, Type::kInt32);
  file.Close();
  const auto arrays = results::ReadPoseArrays(path_);
  ASSERT_TRUE(arrays);
  EXPECT_EQ(arrays->position, (std::vector<double>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(arrays->angular_velocity.size(), 6u);
  EXPECT_TRUE(arrays->orientation.empty() && arrays->linear_velocity.empty());
}

TEST_F(PoseArraysOf, AreRefusedInOtherShapes) {
  const std::pair<const char*, hdf5::Shape> shapes[] = {
      {"position", {6}}, {"position", {2, 4}}, {"position", {2, 3, 1}}, {"position", {}}};
  for (const auto& [name, shape] : shapes) {
    hdf5::File file = hdf5::File::Create(path_);
    Add(file, name, shape);
    file.Close();
    EXPECT_NE(Fault().find("its `position` should be an array of numbers"), std::string::npos)
        << Fault();
  }
  hdf5::File file = hdf5::File::Create(path_);
  Add(file, "position", {2, 3});
  Add(file, "orientation", {3, 4});
  file.Close();
  EXPECT_NE(Fault().find("`orientation` should be an array of numbers with 2 rows and 4 columns"),
            std::string::npos)
      << Fault();
  hdf5::File text = hdf5::File::Create(path_);
  Add(text, "position", {2, 3}, Type::kText);
  text.Close();
  EXPECT_NE(Fault().find("array of numbers"), std::string::npos) << Fault();
}

TEST_F(PoseArraysOf, SayTheOrderOfTheirQuaternions) {
  const auto write = [&](const char* order) {
    hdf5::File file = hdf5::File::Create(path_);
    Add(file, "position", {2, 3});
    Add(file, "orientation", {2, 4});
    if (order != nullptr) file.OpenDataset("orientation").SetText("order", order);
    file.Close();
  };
  const auto quaternions = [&] { return results::ReadPoseArrays(path_)->orientation; };
  const std::vector<double> as_written = {0, 1, 2, 3, 4, 5, 6, 7};
  write(nullptr);
  EXPECT_EQ(quaternions(), as_written);
  write("wxyz");
  EXPECT_EQ(quaternions(), as_written);
  for (const char* order : {"xyzw", "x, y, z, w"}) {
    write(order);
    EXPECT_EQ(quaternions(), (std::vector<double>{3, 0, 1, 2, 7, 4, 5, 6})) << order;
  }
  write("zyxw");
  EXPECT_NE(Fault().find("should be `wxyz` or `xyzw`, not `zyxw`"), std::string::npos) << Fault();
}

TEST_F(PoseArraysOf, AreTransposedInFilesOfMatlab) {
  const auto write = [&](const hdf5::Shape& shape, bool is_matlab) {
    hdf5::File file = hdf5::File::Create(path_);
    Add(file, "position", shape);
    if (is_matlab) file.OpenDataset("position").SetText("MATLAB_class", "double");
    file.Close();
  };
  write({3, 2}, true);
  EXPECT_EQ(results::ReadPoseArrays(path_)->position, (std::vector<double>{0, 2, 4, 1, 3, 5}));
  write({3, 2}, false);
  EXPECT_NE(Fault().find("it has 3 rows and 2 columns: write it by f[\"position\"] = position.T"),
            std::string::npos)
      << Fault();
  write({3, 3}, true);
  EXPECT_NE(Fault().find("it has 3 by 3 from MATLAB, which may be transposed"), std::string::npos);
  write({3, 3}, false);
  EXPECT_EQ(results::ReadPoseArrays(path_)->position.size(), 9u);
}

TEST_F(PoseArraysOf, AreReadByColumns) {
  hdf5::File file = hdf5::File::Create(path_);
  Add(file, "position", {2, 3});
  Add(file, "t", {2});
  Add(file, "poses", {2, 3, 4});
  file.Close();
  EXPECT_EQ(results::ReadColumns(path_, {"/poses[1,:,2]", "/poses[:,0,3]"}),
            (std::vector<std::vector<double>>{{14, 18, 22}, {3, 15}}));
  EXPECT_EQ(results::ReadColumns(path_, {"/position[:,1]", "position[1,:]", "t"}),
            (std::vector<std::vector<double>>{{1, 4}, {3, 4, 5}, {0, 1}}));
  const std::pair<const char*, const char*> rows[] = {
      {"/position", "`/position`: it has the shape 2 x 3: name a column, as in /position[:,0]"},
      {"/position[:,3]", "its shape is 2 x 3"},
      {"/position[0]", "[0] should be such as [:,0] or [0,:]"},
      {"/position[:,]", "should be such as"},
      {"/position[:,:]", "should be such as"},
      {"/poses[:,0]", "its shape is 2 x 3 x 4"},
      {"/poses[:,3,0]", "its shape is 2 x 3 x 4"},
      {"/t/x", "there is no `x`"},
      {"", "not the path of an array"}};
  for (const auto& [column, message] : rows) try {
      results::ReadColumns(path_, {column});
      ADD_FAILURE() << column;
    } catch (const files::StoreError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  EXPECT_EQ(results::ArraysIn(path_), "/poses (2 x 3 x 4), /position (2 x 3), /t (2)");
}

TEST_F(PoseArraysOf, HaveTimesIfAskedFor) {
  const auto write = [&](std::uint64_t times) {
    hdf5::File file = hdf5::File::Create(path_);
    Add(file, "position", {2, 3});
    Add(file, "time", {times});
    file.Close();
  };
  write(2);
  EXPECT_EQ(results::ReadPoseArrays(path_, true)->time, (std::vector<double>{0, 1}));
  EXPECT_TRUE(results::ReadPoseArrays(path_)->time.empty());
  write(3);
  EXPECT_EQ(Fault(), "");
  EXPECT_THROW(results::ReadPoseArrays(path_, true), files::StoreError);
}

TEST_F(PoseArraysOf, NeedHdf5) {
  WriteFile(path_, "x,y,z\n1,2,3\n");
  EXPECT_NE(Fault().find("not HDF5"), std::string::npos) << Fault();
  hdf5::File file = hdf5::File::Create(path_);
  Add(file, "places", {2, 3});
  file.Close();
  EXPECT_NE(Fault().find("it has no dataset `position`, and is not a results file"),
            std::string::npos)
      << Fault();
}

}  // namespace
}  // namespace cdb::tests
