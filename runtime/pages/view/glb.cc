#include "runtime/pages/view/glb.h"

#include <array>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "runtime/pages/view/scene_document.h"

namespace cdb::view {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126, kUnsignedInt = 5125;          // component types
constexpr int kArrayBuffer = 34962, kIndexBuffer = 34963;  // targets of buffer views
constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

/// Okabe and Ito's colours, as linear values, the same as on the page.
constexpr std::array<std::array<double, 3>, 6> kGroupColours = {{{0, 0.168, 0.445},
                                                                 {0.791, 0.347, 0},
                                                                 {0, 0.342, 0.171},
                                                                 {0.604, 0.191, 0.386},
                                                                 {0.093, 0.456, 0.812},
                                                                 {0.665, 0.112, 0}}};

void AppendWord(std::string& bytes, std::uint32_t word) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(word >> shift & 255);
}

void AppendChunk(std::string& bytes, std::uint32_t kind, std::string chunk, char padding) {
  while (chunk.size() % 4 != 0) chunk += padding;
  AppendWord(bytes, static_cast<std::uint32_t>(chunk.size()));
  AppendWord(bytes, kind);
  bytes += chunk;
}

class GlbMaker {
 public:
  explicit GlbMaker(const SceneRecording& recording)
      : recording_(recording), tessellation_(recording.ObjectCount()) {}

  std::string Make() {
    document_ = {{"asset", {{"version", "2.0"}, {"generator", "cdb"}}},
                 {"scene", 0},
                 {"scenes", Json::array()}};
    for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"})
      document_[list] = Json::array();
    AddMaterials();
    if (!recording_.cycles.empty()) AddTimes();
    Json roots = Json::array();
    for (std::size_t body = 0; body < recording_.ObjectCount(); ++body)
      roots.push_back(AddBody(body));
    document_["scenes"].push_back({{"name", recording_.benchmark}, {"nodes", roots}});
    if (!channels_.empty())
      document_["animations"] =
          Json::array({{{"name", "recorded"}, {"channels", channels_}, {"samplers", samplers_}}});
    document_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
    return Bytes();
  }

 private:
  std::string Bytes() {
    std::string chunks;
    AppendChunk(chunks, kJsonChunk, document_.dump(-1, ' ', false, Json::error_handler_t::replace),
                ' ');
    AppendChunk(chunks, kBinaryChunk, binary_, '\0');
    std::string bytes;
    AppendWord(bytes, kMagic);
    AppendWord(bytes, kVersion);
    AppendWord(bytes, static_cast<std::uint32_t>(12 + chunks.size()));
    return bytes + chunks;
  }

  template <typename Value>
  std::size_t AddView(const std::vector<Value>& values, int target) {
    Json view = {{"buffer", 0},
                 {"byteOffset", binary_.size()},
                 {"byteLength", values.size() * sizeof(Value)}};
    if (target != 0) view["target"] = target;
    const std::size_t at = binary_.size();
    binary_.resize(at + values.size() * sizeof(Value));
    std::memcpy(&binary_[at], values.data(), values.size() * sizeof(Value));
    document_["bufferViews"].push_back(std::move(view));
    return document_["bufferViews"].size() - 1;
  }

  /// `width`: floats per element. Adds minimum and maximum where glTF requires them.
  std::size_t AddFloats(const std::vector<float>& values, std::size_t width, int target,
                        bool has_extremes) {
    static constexpr const char* kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    Json accessor = {{"bufferView", AddView(values, target)},
                     {"componentType", kFloat},
                     {"count", values.size() / width},
                     {"type", kTypes[width]}};
    if (has_extremes) {
      std::vector<float> low(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(width));
      std::vector<float> high = low;
      for (std::size_t i = 0; i < values.size(); ++i) {
        low[i % width] = std::min(low[i % width], values[i]);
        high[i % width] = std::max(high[i % width], values[i]);
      }
      accessor["min"] = low;
      accessor["max"] = high;
    }
    document_["accessors"].push_back(std::move(accessor));
    return document_["accessors"].size() - 1;
  }

  void AddMaterials() {
    for (std::size_t i = 0; i < recording_.scene.groups.size(); ++i) {
      const auto& colour = kGroupColours[i % kGroupColours.size()];
      document_["materials"].push_back({{"name", recording_.scene.groups[i].name},
                                        {"pbrMetallicRoughness",
                                         {{"baseColorFactor", {colour[0], colour[1], colour[2], 1}},
                                          {"metallicFactor", 0},
                                          {"roughnessFactor", 0.7}}}});
    }
  }

  void AddTimes() {
    const double step = recording_.scene.world.Real("timestep");
    std::vector<float> times;
    for (const std::uint64_t cycle : recording_.cycles)
      times.push_back(
          static_cast<float>(static_cast<double>(cycle - recording_.cycles.front()) * step));
    times_ = AddFloats(times, 1, 0, true);
  }

  Json AttributesOf(std::size_t mesh) {
    const TriangleMesh& source = tessellation_.meshes()[mesh];
    std::vector<float> positions, normals;
    for (const Eigen::Vector3f& v : source.positions)
      positions.insert(positions.end(), v.begin(), v.end());
    for (const Eigen::Vector3f& v : source.normals)
      normals.insert(normals.end(), v.begin(), v.end());
    Json attributes;
    attributes["POSITION"] = AddFloats(positions, 3, kArrayBuffer, true);
    attributes["NORMAL"] = AddFloats(normals, 3, kArrayBuffer, false);
    const std::size_t view = AddView(source.indices, kIndexBuffer);
    document_["accessors"].push_back({{"bufferView", view},
                                      {"componentType", kUnsignedInt},
                                      {"count", source.indices.size()},
                                      {"type", "SCALAR"}});
    return {{"attributes", attributes}, {"indices", document_["accessors"].size() - 1}};
  }

  /// A glTF mesh is one of our meshes in the colour of a group.
  std::size_t MeshOf(std::size_t mesh, std::size_t group) {
    if (const auto found = meshes_.find({mesh, group}); found != meshes_.end())
      return found->second;
    if (primitives_.size() <= mesh) primitives_.resize(mesh + 1);
    if (primitives_[mesh].is_null()) primitives_[mesh] = AttributesOf(mesh);
    Json primitive = primitives_[mesh];
    primitive["material"] = group;
    document_["meshes"].push_back({{"name", tessellation_.meshes()[mesh].name},
                                   {"primitives", Json::array({std::move(primitive)})}});
    return meshes_[{mesh, group}] = document_["meshes"].size() - 1;
  }

  std::size_t AddNode(Json node) {
    document_["nodes"].push_back(std::move(node));
    return document_["nodes"].size() - 1;
  }

  /// A moving node, with a child node for each part. Returns its index.
  std::size_t AddBody(std::size_t body) {
    const layouts::ObjectState& object = recording_.state.objects[body];
    Json children = Json::array();
    for (const Part& part : tessellation_.PartsOf(object.solid)) {
      const Eigen::Quaternionf q = part.rotation.cast<float>().normalized();
      children.push_back(AddNode({{"mesh", MeshOf(part.mesh, object.group)},
                                  {"translation", {0, part.offset_y, 0}},
                                  {"rotation", {q.x(), q.y(), q.z(), q.w()}},
                                  {"scale", {part.scale.x(), part.scale.y(), part.scale.z()}}}));
    }
    std::vector<float> positions, turns;
    ReadMotion(body, positions, turns);
    const std::size_t node =
        AddNode({{"name", recording_.scene.groups[object.group].name + " " + std::to_string(body)},
                 {"translation", {positions[0], positions[1], positions[2]}},
                 {"rotation", {turns[0], turns[1], turns[2], turns[3]}},
                 {"children", children}});
    if (!recording_.cycles.empty()) {
      Animate(node, "translation", AddFloats(positions, 3, 0, false));
      Animate(node, "rotation", AddFloats(turns, 4, 0, false));
    }
    return node;
  }

  void ReadMotion(std::size_t body, std::vector<float>& positions, std::vector<float>& turns) {
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    Eigen::Quaternionf turn = Eigen::Quaternionf::Identity();
    for (std::size_t frame = 0; frame < recording_.FrameCount(); ++frame) {
      const double* p =
          &recording_.poses[(frame * recording_.ObjectCount() + body) * protocol::kPoseSize];
      const Eigen::Vector3f next(static_cast<float>(p[0]), static_cast<float>(p[1]),
                                 static_cast<float>(p[2]));
      const Eigen::Quaternionf q = Eigen::Quaterniond(p[6], p[3], p[4], p[5]).cast<float>();
      if (next.allFinite()) position = next;
      if (q.coeffs().allFinite() && q.norm() > 0) turn = q.normalized();
      positions.insert(positions.end(), position.begin(), position.end());
      turns.insert(turns.end(), turn.coeffs().begin(), turn.coeffs().end());
    }
  }

  void Animate(std::size_t node, const char* path, std::size_t values) {
    samplers_.push_back({{"input", times_}, {"interpolation", "STEP"}, {"output", values}});
    channels_.push_back(
        {{"sampler", samplers_.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  }

  const SceneRecording& recording_;
  Tessellation tessellation_;
  Json document_, channels_ = Json::array(), samplers_ = Json::array();
  std::string binary_;
  std::size_t times_ = 0;
  std::vector<Json> primitives_;  ///< of our meshes, without a material
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> meshes_;  ///< by mesh and group
};

}  // namespace

std::string SceneGlb(const SceneRecording& recording) { return GlbMaker(recording).Make(); }

}  // namespace cdb::view
