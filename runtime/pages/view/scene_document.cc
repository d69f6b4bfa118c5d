#include "runtime/pages/view/scene_document.h"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "runtime/pages/view/packing.h"
#include "runtime/pages/view/tessellation.h"

namespace cdb::view {
namespace {

using Json = nlohmann::ordered_json;

void Append(std::vector<double>& values, const Eigen::Vector3d& vector) {
  values.insert(values.end(), vector.begin(), vector.end());
}

std::string PackVectors(const std::vector<Eigen::Vector3f>& vectors) {
  std::vector<double> values;
  for (const Eigen::Vector3f& vector : vectors) Append(values, vector.cast<double>());
  return PackFloats(values);
}

Json MeshesOf(const Tessellation& tessellation) {
  Json meshes = Json::array();
  for (const TriangleMesh& mesh : tessellation.meshes()) {
    const std::vector<std::int32_t> indices(mesh.indices.begin(), mesh.indices.end());
    meshes.push_back({{"name", mesh.name},
                      {"positions", PackVectors(mesh.positions)},
                      {"normals", PackVectors(mesh.normals)},
                      {"indices", PackInts(indices)}});
  }
  return meshes;
}

void AddBodies(const SceneRecording& recording, Json& run) {
  Tessellation tessellation(recording.ObjectCount());
  std::vector<std::int32_t> groups, part_bodies, part_meshes;
  std::vector<double> masses, sides, places, radii;
  for (std::size_t i = 0; i < recording.ObjectCount(); ++i) {
    const layouts::ObjectState& object = recording.state.objects[i];
    groups.push_back(static_cast<std::int32_t>(object.group));
    masses.push_back(object.mass);
    Append(sides, object.solid.sides);
    radii.push_back(object.solid.OuterRadius());
    for (const Part& part : tessellation.PartsOf(object.solid)) {
      part_bodies.push_back(static_cast<std::int32_t>(i));
      part_meshes.push_back(static_cast<std::int32_t>(part.mesh));
      Append(places, part.scale);
      const Eigen::Quaterniond& q = part.rotation;
      places.insert(places.end(), {q.x(), q.y(), q.z(), q.w(), part.offset_y});
    }
  }
  run["meshes"] = MeshesOf(tessellation);
  run["bodies"] = {{"count", recording.ObjectCount()},
                   {"group", PackInts(groups)},
                   {"mass", PackFloats(masses)},
                   {"sides", PackFloats(sides)},
                   {"radius", PackFloats(radii)}};
  run["parts"] = {{"body", PackInts(part_bodies)},
                  {"mesh", PackInts(part_meshes)},
                  {"place", PackFloats(places)}};
}

void AddFrames(const SceneRecording& recording, Json& run) {
  std::vector<double> positions;
  std::vector<std::uint16_t> orientations;
  const std::vector<double>& poses = recording.poses;
  for (std::size_t i = 0; i < poses.size() / protocol::kPoseSize; ++i) {
    const double* pose = &poses[i * protocol::kPoseSize];
    positions.insert(positions.end(), pose, pose + 3);
    const auto words = PackQuaternion({pose[6], pose[3], pose[4], pose[5]}, recording.unmoved[i]);
    orientations.insert(orientations.end(), words.begin(), words.end());
  }
  run["frames"] = {{"count", recording.FrameCount()},
                   {"is_start", recording.cycles.empty()},
                   {"first", recording.cycles.empty() ? 0 : recording.cycles.front()},
                   {"every", recording.every},
                   {"position", PackFloats(positions)},
                   {"orientation", PackShorts(orientations)}};
}

Json ContactsOf(const SceneRecording& recording) {
  std::vector<std::int32_t> counts, bodies;
  std::vector<double> points, normals, distances;
  for (const auto& frame : recording.contacts) {
    counts.push_back(static_cast<std::int32_t>(frame.size()));
    for (const protocol::ContactRecord& contact : frame) {
      bodies.push_back(static_cast<std::int32_t>(contact.body_a));
      bodies.push_back(static_cast<std::int32_t>(contact.body_b));
      points.insert(points.end(), std::begin(contact.point), std::end(contact.point));
      normals.insert(normals.end(), std::begin(contact.normal), std::end(contact.normal));
      distances.push_back(contact.distance);
    }
  }
  return {{"count", PackInts(counts)},
          {"body", PackInts(bodies)},
          {"point", PackFloats(points)},
          {"normal", PackFloats(normals)},
          {"distance", PackFloats(distances)}};
}

Json SeriesOf(const std::vector<CycleSeries>& all) {
  Json list = Json::array();
  for (const CycleSeries& series : all)
    list.push_back({{"name", series.name},
                    {"unit", series.unit},
                    {"interval", series.interval_s},
                    {"values", PackFloats(series.values)}});
  return list;
}

Json RunOf(const SceneRecording& recording) {
  const plan::WorldSettings& world = recording.scene.world;
  const Eigen::Vector3d& acceleration = recording.state.acceleration;
  Json run = {{"file", recording.file},
              {"benchmark", recording.benchmark},
              {"title", recording.title},
              {"name", recording.name},
              {"is_run", recording.is_run},
              {"status", std::string(results::StatusName(recording.status))},
              {"verdict", std::string(protocol::VerdictName(recording.judgement.verdict))},
              {"first_bad_cycle", recording.judgement.first_bad_cycle},
              {"message", recording.message},
              {"timestep", world.Real("timestep")},
              {"warmup", world.Count("warmup")},
              {"cycles", recording.n_cycles},
              {"side", world.Real("world.side")},
              {"walls", std::string(world.WordOr("world.walls"))},
              {"detector", std::string(world.WordOr("detector"))},
              {"acceleration", {acceleration.x(), acceleration.y(), acceleration.z()}},
              {"record", world.Words("record")},
              {"notices", recording.notices}};
  run["groups"] = Json::array();
  for (const plan::Group& group : recording.scene.groups)
    run["groups"].push_back({{"name", group.name}, {"quantity", group.settings.Count("quantity")}});
  AddBodies(recording, run);
  AddFrames(recording, run);
  run["boxes"] = recording.boxes.empty() ? Json() : Json(PackFloats(recording.boxes));
  run["contacts"] = recording.has_contacts ? ContactsOf(recording) : Json();
  run["durations"] = SeriesOf(recording.durations);
  run["series"] = SeriesOf(recording.series);
  return run;
}

}  // namespace

std::string SceneDocument(const std::string& title, std::span<const SceneRecording> recordings) {
  Json document = {{"title", title}, {"runs", Json::array()}};
  for (const SceneRecording& recording : recordings) document["runs"].push_back(RunOf(recording));
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace cdb::view
