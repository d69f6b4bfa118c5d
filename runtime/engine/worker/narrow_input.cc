#include "runtime/engine/worker/narrow_input.h"

#include <algorithm>
#include <cstdint>
#include <span>

#include "dsl/text/check.h"

namespace cdb::worker {

NarrowInput::NarrowInput(world::Engine& engine, int fd)
    : engine_(engine), fd_(fd), wall_places_(omissions::kWallCount) {
  CDB_CHECK(engine.timed_world() == nullptr);
  for (const auto& body : engine.objects()) bodies_.push_back(body.get());
  std::uint64_t walls = 0;
  for (const auto& body : engine.walls()) {
    const std::size_t wall =
        static_cast<std::size_t>(body->getUserIndex()) - engine.objects().size();
    walls |= std::uint64_t{1} << wall;
    wall_places_[wall] = static_cast<std::uint32_t>(bodies_.size());
    bodies_.push_back(body.get());
  }
  frames_.resize(bodies_.size() * protocol::kFrameSize);
  protocol::BeginNarrowInput(fd_, walls);
}

void NarrowInput::Begin() {
  engine_.world().BeforeNarrowPhase([this] { Record(); });
}

void NarrowInput::Record() {
  btScalar* to = frames_.data();
  for (const btRigidBody* body : bodies_) {
    const btTransform& pose = body->getWorldTransform();
    const btVector3 axes[] = {pose.getBasis().getColumn(0), pose.getBasis().getColumn(1),
                              pose.getBasis().getColumn(2)};
    to = std::copy_n(pose.getOrigin().m_floats, 3, to);
    for (const btVector3& axis : axes) to = std::copy_n(axis.m_floats, 3, to);
  }
  pairs_.clear();
  btDispatcher& dispatcher = *engine_.world().getDispatcher();
  btOverlappingPairCache& cache = *engine_.world().getPairCache();
  const auto place = [&](const btCollisionObject& body) {
    const auto index = static_cast<std::size_t>(body.getUserIndex());
    const std::size_t objects = engine_.objects().size();
    return index < objects ? static_cast<std::uint32_t>(index) : wall_places_[index - objects];
  };
  for (const btBroadphasePair& pair :
       std::span(cache.getOverlappingPairArrayPtr(),
                 static_cast<std::size_t>(cache.getNumOverlappingPairs()))) {
    const auto* a = static_cast<const btCollisionObject*>(pair.m_pProxy0->m_clientObject);
    const auto* b = static_cast<const btCollisionObject*>(pair.m_pProxy1->m_clientObject);
    if (!dispatcher.needsCollision(a, b)) continue;
    const auto [first, second] = std::minmax({place(*a), place(*b)});
    pairs_.push_back({first, second});
  }
  std::ranges::sort(pairs_);
  protocol::AppendNarrowInput(fd_, std::as_bytes(std::span(frames_)), pairs_);
}

}  // namespace cdb::worker
