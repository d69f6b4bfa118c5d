#include "library/meshes/importer/scene_mesh.h"

#include <assimp/config.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/BaseImporter.h>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "library/meshes/mesh.h"
#include "library/scene_error.h"

namespace cdb::importer {
namespace {

using Eigen::Matrix4d;
using library::SceneError;

/// Opens no file, and keeps the name of the first one that a format asks for.
class NoFiles : public Assimp::IOSystem {
 public:
  explicit NoFiles(std::string& wanted) : wanted_(wanted) {}
  bool Exists(const char* file) const override {
    if (wanted_.empty()) wanted_ = file;
    return false;
  }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char*) override {
    Exists(file);
    return nullptr;
  }
  void Close(Assimp::IOStream*) override {}

 private:
  std::string& wanted_;
};

/// Leaves only the importers of this extension: a file is not read as what its name does not say.
void KeepImportersOf(std::string_view extension, Assimp::Importer& importer) {
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    std::set<std::string> extensions;
    importer.GetImporter(i)->GetExtensionList(extensions);
    // CheckGltf refuses version 1.
    const std::string_view name = importer.GetImporter(i)->GetInfo()->mName;
    if (!extensions.contains(std::string(extension.substr(1))) || name.starts_with("glTF "))
      others.push_back(importer.GetImporter(i));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;
  }
}

Matrix4d ToEigen(const aiMatrix4x4& m) {
  Matrix4d matrix;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column) matrix(row, column) = m[row][column];
  return matrix;
}

std::optional<double> RealOf(const aiMetadata& data, const char* key) {
  float single = 0;
  double real = 0;
  std::int32_t whole = 0;
  if (data.Get(key, real)) return real;
  if (data.Get(key, single)) return single;
  if (data.Get(key, whole)) return whole;
  return std::nullopt;
}

/// From the axes and the unit of an FBX file to metres with y up.
Matrix4d FrameOfFbx(const aiScene& scene) {
  const auto fact = [&](const char* key, double otherwise) {
    return scene.mMetaData == nullptr ? otherwise
                                      : RealOf(*scene.mMetaData, key).value_or(otherwise);
  };
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  const auto row = [&](int to, const char* axis, const char* sign, double otherwise) {
    const double from = fact(axis, otherwise);
    for (int i = 0; i < 3; ++i)
      if (from == i) axes(to, i) = fact(sign, 1) < 0 ? -1 : 1;
  };
  row(0, "CoordAxis", "CoordAxisSign", 0);
  row(1, "UpAxis", "UpAxisSign", 1);
  row(2, "FrontAxis", "FrontAxisSign", 2);
  if (std::abs(axes.determinant()) != 1)
    throw SceneError("its GlobalSettings name an axis twice", "export it again");
  Matrix4d frame = Matrix4d::Identity();
  frame.topLeftCorner<3, 3>() = fact("UnitScaleFactor", 1) * 0.01 * axes;
  return frame;
}

class PlyWriter {
 public:
  PlyWriter(const aiScene& scene, std::string_view extension, double unit) : scene_(scene) {
    Matrix4d frame = Matrix4d::Identity();
    frame.topLeftCorner<3, 3>() *= unit;
    // Newer versions of assimp put the axes and the unit of FBX there.
    const bool is_fbx = extension == ".fbx";
    if (is_fbx) frame = FrameOfFbx(scene);
    Add(*scene.mRootNode, is_fbx ? frame : frame * ToEigen(scene.mRootNode->mTransformation));
  }

  std::string Take() const {
    if (face_count_ == 0)
      throw SceneError(left_out_.empty() ? "has no meshes" : "has no faces, only " + LeftOut(), "");
    const std::string comments = LeftOut().empty() ? "" : fmt::format("comment {}\n", LeftOut());
    return fmt::format(
               "ply\nformat binary_{}_endian 1.0\n{}element vertex {}\nproperty double x\n"
               "property double y\nproperty double z\nelement face {}\n"
               "property list uint uint vertex_indices\nend_header\n",
               std::endian::native == std::endian::little ? "little" : "big", comments,
               vertex_count_, face_count_) +
           vertices_ + faces_;
  }

 private:
  void Add(const aiNode& node, const Matrix4d& to_scene) {
    if (std::ranges::count(node.mChildren, node.mChildren + node.mNumChildren, nullptr) > 0)
      throw SceneError("refers to an object that assimp does not find", "");
    for (unsigned i = 0; i < node.mNumMeshes; ++i) Add(*scene_.mMeshes[node.mMeshes[i]], to_scene);
    for (unsigned i = 0; i < node.mNumChildren; ++i)
      Add(*node.mChildren[i], to_scene * ToEigen(node.mChildren[i]->mTransformation));
  }

  void Add(const aiMesh& mesh, const Matrix4d& to_scene) {
    // The vertices of lines and points would be part of a convex hull.
    constexpr std::uint32_t kUnused = ~std::uint32_t{0};
    std::vector<std::uint32_t> numbers(mesh.mNumVertices, kUnused);
    const bool is_mirrored = to_scene.topLeftCorner<3, 3>().determinant() < 0;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices < 3) {
        ++left_out_[face.mNumIndices == 2 ? "line" : "point"];
        continue;
      }
      Append(std::uint32_t{face.mNumIndices}, faces_);
      ++face_count_;
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const unsigned index = face.mIndices[is_mirrored ? face.mNumIndices - 1 - k : k];
        if (index >= mesh.mNumVertices)
          throw SceneError("a face has a vertex that is not there", "");
        if (numbers[index] == kUnused) numbers[index] = AddVertex(mesh.mVertices[index], to_scene);
        Append(numbers[index], faces_);
      }
    }
    if (mesh.HasBones()) ++left_out_["skin"];
    if (mesh.mNumAnimMeshes > 0) ++left_out_["morph target"];
  }

  std::uint32_t AddVertex(const aiVector3D& v, const Matrix4d& to_scene) {
    const Eigen::Vector4d at = to_scene * Eigen::Vector4d(v.x, v.y, v.z, 1);
    if (!(at.array().abs() <= meshes::kLargestCoordinate).all())
      throw SceneError(fmt::format("a vertex is at ({}, {}, {})", at.x(), at.y(), at.z()), "");
    if (vertex_count_ >= meshes::kMaxVertices)
      throw SceneError(fmt::format("more than {} vertices", meshes::kMaxVertices),
                       "simplify the model first");
    Append(at.head<3>().eval(), vertices_);
    return vertex_count_++;
  }

  template <typename T>
  static void Append(const T& value, std::string& to) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
  }

  /// `3 lines, 1 skin`.
  std::string LeftOut() const {
    std::string text;
    for (const auto& [what, count] : left_out_)
      text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", count, what, count > 1 ? "s" : "");
    return text;
  }

  const aiScene& scene_;
  std::string vertices_, faces_;
  std::uint32_t vertex_count_ = 0, face_count_ = 0;
  std::map<std::string, std::uint64_t> left_out_;
};

}  // namespace

std::string PlyOf(std::string bytes, std::string_view extension) {
  if (bytes.empty()) throw SceneError("is empty", "");
  if (extension == ".gltf" || extension == ".glb") bytes = CheckedGltf(std::move(bytes));
  const double unit = UnitOf(bytes, extension);
  std::string wanted;
  // Never destroyed: version 5.2 frees pictures of 3MF files twice.
  Assimp::Importer& importer = *new Assimp::Importer;
  importer.SetIOHandler(new NoFiles(wanted));
  KeepImportersOf(extension, importer);
  // Skeletons without a mesh would be drawn as meshes.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_MD5_NO_ANIM_AUTOLOAD, true);
  const std::string hint(extension.substr(1));
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, hint.c_str());
  if (scene == nullptr && !wanted.empty())
    throw SceneError(fmt::format("needs another file, '{}'", wanted),
                     "export it as one file, such as GLB, OBJ, PLY or STL");
  if (scene == nullptr)
    throw SceneError(fmt::format("assimp cannot read it: {}", importer.GetErrorString()), "");
  if (scene->mRootNode == nullptr) throw SceneError("has no scene", "");
  return PlyWriter(*scene, extension, unit).Take();
}

}  // namespace cdb::importer
