#include "runtime/engine/world/population.h"

#include <algorithm>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/engine.h"

namespace cdb::world {

Population::Population(const plan::Scene& scene, Engine& engine)
    : engine_(engine), since_(engine.objects().size(), 0) {
  std::size_t first = 0;
  for (std::size_t group = 0; group < scene.groups.size(); ++group) {
    const plan::Group& own = scene.groups[group];
    const std::size_t end = first + own.settings.Count("quantity");
    if (const auto spawning = analysis::SpawningOf(own); spawning && end > first)
      sources_.push_back(
          {*spawning, layouts::Emitter(scene, engine.initial_state().objects, group), first});
    if (const auto removal = analysis::RemovalOf(own); removal && end > first) {
      Sink sink{first, end, *removal, {}, false};
      if (removal->outside_cube) sink.box = layouts::CubeOf(engine.side());
      if (removal->outside_box != nullptr) sink.box = layouts::BoxOf(*removal->outside_box);
      sink.has_box = removal->outside_cube || removal->outside_box != nullptr;
      sinks_.push_back(sink);
    }
    first = end;
  }
}

void Population::BeforeStep(std::uint64_t step) {
  last_ = {};
  RemoveAt(step);
  for (Source& source : sources_) SpawnAt(source, step);
}

bool Population::Leaves(const Sink& sink, std::size_t object, std::uint64_t step) const {
  if (sink.removal.after && step - since_[object] >= *sink.removal.after) return true;
  const Eigen::Vector3d centre =
      ToEigen(engine_.objects()[object]->getWorldTransform().getOrigin());
  if (sink.removal.below && centre.y() < *sink.removal.below) return true;
  return sink.has_box && ((centre.array() < sink.box.lower.array()).any() ||
                          (centre.array() > sink.box.upper.array()).any());
}

void Population::RemoveAt(std::uint64_t step) {
  std::vector<std::size_t> leaving;
  for (const Sink& sink : sinks_)
    for (std::size_t i = sink.first; i < sink.end; ++i)
      if (engine_.IsPresent(i) && Leaves(sink, i, step)) leaving.push_back(i);
  if (leaving.empty()) return;
  const std::int64_t begin = Now();
  engine_.Remove(leaving);
  last_.ns += static_cast<double>(Now() - begin);
  last_.departed = static_cast<std::int32_t>(leaving.size());
}

void Population::SpawnAt(Source& source, std::uint64_t step) {
  layouts::Emitter& emitter = source.emitter;
  const std::size_t due =
      emitter.first() + source.spawning.DueAt(step, emitter.end() - emitter.first());
  if (source.next == due) return;
  emitter.Begin();
  for (std::size_t i = 0; i < engine_.objects().size(); ++i)
    if (engine_.IsPresent(i)) emitter.Meet(i, ExactPose(*engine_.objects()[i]));
  for (; source.next < due; ++source.next) {
    const auto place = emitter.FindPlace(source.next);
    if (!place) break;
    const std::int64_t begin = Now();
    engine_.Add(source.next, *place);
    last_.ns += static_cast<double>(Now() - begin);
    since_[source.next] = step;
    ++last_.spawned;
  }
  last_.waiting += static_cast<std::int32_t>(due - source.next);
}

}  // namespace cdb::world
