#include "runtime/results/mesh_arrays.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"
#include "tests/library/deforming/folding_cloth.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using hdf5::Type;

class MeshArrays : public testing::Test {
 protected:
  /// A file of a cloth, whose arrays may be spoiled. Closed with the object that holds it.
  struct Arrays {
    std::vector<double> faces, vertices;
    hdf5::Shape face_shape, vertex_shape;
  };
  Arrays Cloth() const {
    Arrays arrays;
    for (const auto& triangle : cloth_.triangles)
      arrays.faces.insert(arrays.faces.end(), triangle.begin(), triangle.end());
    for (const auto& frame : cloth_.frames)
      for (const Eigen::Vector3d& at : frame)
        arrays.vertices.insert(arrays.vertices.end(), at.begin(), at.end());
    arrays.face_shape = {cloth_.triangles.size(), 3};
    arrays.vertex_shape = {cloth_.frames.size(), cloth_.vertices(), 3};
    return arrays;
  }
  void Write(const Arrays& arrays) const {
    hdf5::File file = hdf5::File::Create(path_);
    if (!arrays.faces.empty())
      file.CreateDataset({"faces", Type::kInt32, arrays.face_shape, {}, 0}).Write(arrays.faces);
    if (!arrays.vertices.empty())
      file.CreateDataset({"vertices", Type::kFloat64, arrays.vertex_shape, {}, 0})
          .Write(arrays.vertices);
    file.Close();
  }
  std::string Fault(const Arrays& arrays) const {
    Write(arrays);
    try {
      results::ReadMeshArrays(path_);
    } catch (const files::StoreError& error) {
      return error.what();
    }
    return "";
  }
  deforming::MeshSequence cloth_ = FoldingCloth(5, 3);
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "cloth.h5";
};

TEST_F(MeshArrays, AreReadAsTheyStand) {
  Write(Cloth());
  const deforming::MeshSequence read = results::ReadMeshArrays(path_);
  EXPECT_EQ(read.triangles, cloth_.triangles);
  EXPECT_EQ(read.frames, cloth_.frames);
}

TEST_F(MeshArrays, AreRefusedInOtherShapes) {
  const auto has = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  Arrays arrays = Cloth();
  arrays.faces.clear();
  has(Fault(arrays), "cloth.h5: it has no dataset `faces`; write f[");
  arrays = Cloth();
  arrays.vertices.clear();
  has(Fault(arrays), "it has no dataset `vertices`");
  arrays = Cloth();
  arrays.vertex_shape = {75, 3};
  has(Fault(arrays), "its `vertices` has the shape 75 x 3");
  arrays = Cloth();
  arrays.face_shape = {3, 32};
  has(Fault(arrays), "its `faces` has the shape 3 x 32");
  arrays = Cloth();
  arrays.faces[4] = -1;
  has(Fault(arrays), "its `faces` has -1 in row 1");
  arrays = Cloth();
  arrays.faces[4] = 25;
  has(Fault(arrays), "cloth.h5: triangle 1 has vertex 25");
  arrays = Cloth();
  arrays.vertices[80] = INFINITY;
  has(Fault(arrays), "cloth.h5: vertex 1 of frame 1 is (");
}

}  // namespace
}  // namespace cdb::tests
