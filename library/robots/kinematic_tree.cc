#include "library/robots/kinematic_tree.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/plan/input_file.h"
#include "compiler/plan/text_table.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/distributions/draw.h"
#include "library/layouts/joint_pairs.h"
#include "library/scene_error.h"

namespace cdb::robots {
namespace {

using layouts::JointPair;
using objects::Pose;

static_assert(KinematicTree::Hold::kNone == JointPair::kWorld);

Pose Times(const Pose& outer, const Pose& inner) {
  return {outer.position + outer.orientation * inner.position,
          outer.orientation * inner.orientation};
}

Pose Inverse(const Pose& pose) {
  const Eigen::Quaterniond back = pose.orientation.conjugate();
  return {back * -pose.position, back};
}

/// The origin of the child at a position, in the frame of its parent.
Pose MovedTo(const KinematicTree::Hold& hold, double position) {
  const double by = position - hold.start;
  Pose moved = hold.origin;
  if (hold.is_slider) {
    moved.position += by * hold.axis;
    return moved;
  }
  const Eigen::Quaterniond turn = layouts::TurnAbout(by * hold.axis);
  moved.position = hold.at + turn * (moved.position - hold.at);
  moved.orientation = turn * moved.orientation;
  return moved;
}

}  // namespace

KinematicTree::KinematicTree(const plan::Scene& scene, const layouts::InitialState& state)
    : is_link_(state.objects.size(), 0) {
  for (const layouts::ObjectState& object : state.objects) {
    placed_.push_back(object.pose);
    solids_.push_back(object.solid);
  }
  std::map<const plan::Joint*, std::size_t> numbers;
  for (const analysis::Freedom& freedom : analysis::FreedomsOf(scene))
    numbers.emplace(freedom.joint, freedoms_++);
  const auto origin_of = [&](std::size_t object) {
    return object == Hold::kNone ? Pose() : objects::OriginOf(solids_[object], placed_[object]);
  };
  std::vector<JointPair> pairs = layouts::JointPairsOf(scene);
  std::vector<char> is_held(state.objects.size(), 0);
  for (const JointPair& pair : pairs) {
    for (const std::size_t object : {pair.parent, pair.child})
      if (object != Hold::kNone) is_link_[object] = 1;
    is_held[pair.child] = 1;
  }
  // A parent is placed before its children.
  while (!pairs.empty()) {
    const auto ready = std::ranges::find_if(pairs, [&](const JointPair& pair) {
      return pair.parent == Hold::kNone || is_held[pair.parent] == 0;
    });
    CDB_CHECK(ready != pairs.end());
    const plan::GroupSettings& settings = ready->joint->settings;
    const auto number = numbers.find(ready->joint);
    const bool moves = number != numbers.end();
    holds_.push_back({ready->parent, ready->child, moves ? number->second : Hold::kNone,
                      settings.WordOr("joints.type") == "slider", settings.Vector("joints.at"),
                      settings.Vector("joints.axis").stableNormalized(),
                      moves ? settings.Real("joints.start") : 0.0,
                      Times(Inverse(origin_of(ready->parent)), origin_of(ready->child))});
    is_held[ready->child] = 0;
    moved_.push_back(ready->child);
    pairs.erase(ready);
  }
}

void KinematicTree::PosesAt(std::span<const double> positions,
                            std::vector<objects::Pose>& poses) const {
  CDB_CHECK(positions.size() == freedoms_);
  poses = placed_;
  for (const Hold& hold : holds_) {
    const Pose frame = hold.parent == Hold::kNone
                           ? Pose()
                           : objects::OriginOf(solids_[hold.parent], poses[hold.parent]);
    Pose origin = Times(
        frame, hold.freedom == Hold::kNone ? hold.origin : MovedTo(hold, positions[hold.freedom]));
    origin.orientation.normalize();
    poses[hold.child] = objects::BodyOf(solids_[hold.child], origin);
  }
}

namespace {

std::vector<double> DrawnPositions(const plan::Scene& scene,
                                   const std::vector<analysis::Freedom>& freedoms,
                                   std::size_t count) {
  std::vector<double> positions(count * freedoms.size());
  for (std::size_t j = 0; j < freedoms.size(); ++j) {
    if (freedoms[j].driver) continue;
    distributions::Stream stream =
        distributions::NamedStream(scene, freedoms[j].joint->name, analysis::kPositionStream + 1);
    for (std::size_t i = 0; i < count; ++i)
      positions[i * freedoms.size() + j] = stream.Uniform(freedoms[j].lower, freedoms[j].upper);
  }
  for (std::size_t i = 0; i < count; ++i)
    analysis::Follow(freedoms, std::span(positions).subspan(i * freedoms.size(), freedoms.size()));
  return positions;
}

std::vector<double> PathPositions(const std::vector<analysis::Freedom>& freedoms,
                                  std::size_t count) {
  std::vector<double> positions;
  for (std::size_t i = 0; i < count; ++i) {
    const double part = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
    for (const analysis::Freedom& freedom : freedoms)
      positions.push_back((1 - part) * freedom.start + part * freedom.goal);
    analysis::Follow(freedoms, std::span(positions).last(freedoms.size()));
  }
  return positions;
}

std::vector<double> ListedPositions(const schema::Call& list,
                                    const std::vector<analysis::Freedom>& freedoms,
                                    std::size_t count) {
  std::string why;
  const auto text = plan::ReadInputFile(analysis::FileOfList(list), why);
  if (!text)
    throw library::SceneError(fmt::format("cannot read '{}': {}", analysis::FileOfList(list), why));
  try {
    analysis::ConfigurationList read = analysis::ReadConfigurationList(list, *text, freedoms);
    const auto* planned = std::get_if<schema::Text>(&schema::ArgumentOf(list, "sha256"));
    if ((planned != nullptr && planned->text != read.sha256) || read.count < count)
      throw library::SceneError(
          fmt::format("{}: it differs from the file that the plan was made with",
                      analysis::FileOfList(list)),
          "plan again from the .cdb file, or put the other file back");
    read.positions.resize(count * freedoms.size());
    return std::move(read.positions);
  } catch (const plan::TableError& error) {
    throw library::SceneError(error.what(), error.remedy);
  }
}

}  // namespace

std::vector<double> PositionsOf(const plan::Scene& scene) {
  const std::vector<analysis::Freedom> freedoms = analysis::FreedomsOf(scene);
  const std::size_t count = scene.world.Count("cycles");
  if (const schema::Call* list = analysis::ConfigurationListOf(scene))
    return ListedPositions(*list, freedoms, count);
  return scene.world.WordOr("configurations.positions") == "path"
             ? PathPositions(freedoms, count)
             : DrawnPositions(scene, freedoms, count);
}

}  // namespace cdb::robots
