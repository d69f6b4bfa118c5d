#include "runtime/suite/standard.h"

#include <fmt/format.h>

namespace cdb::suite {
namespace {

constexpr Kind kKinds[] = {
    {"games", "many objects in motion, at 240 steps a second"},
    {"granular", "grains and heaps: dense, lasting contacts"},
    {"robotics", "logistics and bin picking: stacks, parts and moving pushers"},
    {"haptics", "one probe among fixed bodies, a thousand steps a second"},
    {"planning", "movers among thousands of fixed obstacles: is there contact?"},
    {"extreme", "unequal sizes, a large world, a fast gas"},
    {"stiff", "settings of Bullet in place of detectors: contacts, joints, time steps"},
};

// One missed pair is one collision that does not happen. The other bounds are rounded values
// between the errors of settings that a viewer accepts and those of settings that visibly fail: a
// stack that slides by a fiftieth of a box, a ball that loses a tenth of its energy, a pendulum
// that gains or loses a twentieth. If hundreds of bodies move, it is a matter of chance whether a
// few overlap by a twentieth of their size: with another seed, the same work gets another verdict.
constexpr auto kPenetrating = measure::Verdict::kPenetrating;
constexpr StandardScene kScenes[] = {
    {"games", "debris", "3000 pieces of debris in orbit", "pairs_missed", 0, kPenetrating},
    {"games", "rubble", "800 falling chunks of rubble", "pairs_missed", 0, kPenetrating},
    {"granular", "drum", "600 grains in a turning drum", "pairs_missed", 0, kPenetrating},
    {"granular", "heap", "a settled heap of 400 objects", "pairs_missed", 0, kPenetrating},
    {"robotics", "warehouse", "1000 stacked boxes and a vehicle", "pairs_missed", 0, kPenetrating},
    {"robotics", "bin", "a finger that pushes 300 parts", "pairs_missed", 0, kPenetrating},
    {"haptics", "probe", "a probe on 2000 fixed bumps, at 1 kHz", "pairs_missed", 0},
    {"planning", "clutter", "20 movers among 4000 obstacles", "pairs_missed", 0},
    {"extreme", "sizes", "2000 bodies of very different sizes", "pairs_missed", 0, kPenetrating},
    {"extreme", "large_world", "2000 bodies in a world of 25 km", "pairs_missed", 0, kPenetrating},
    {"extreme", "swarm", "a fast gas of 3000 balls", "pairs_missed", 0, kPenetrating},
    {"stiff", "stack", "a stack of five boxes that should remain standing", "position", 0.02},
    {"stiff", "bounce", "a ball that bounces without loss", "energy", 0.1},
    {"stiff", "pendulum", "a pendulum on a ball joint", "energy", 0.05},
};

}  // namespace

std::span<const Kind> Kinds() { return kKinds; }
std::span<const StandardScene> StandardScenes() { return kScenes; }

std::string StandardScene::Id() const { return fmt::format("{}/{}", kind, name); }
std::string StandardScene::File() const { return fmt::format("standard/{}/{}", kind, name); }
std::string StandardScene::ResultName() const { return fmt::format("standard_{}.h5", name); }

}  // namespace cdb::suite
