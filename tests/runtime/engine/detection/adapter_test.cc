// A detector in Bullet's world: with Bullet's own pairs and contacts passed through the interface,
// every body moves exactly as without it, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "library/detectors/builtin/builtin.h"
#include "library/detectors/bullet/bullet.h"
#include "library/detectors/exact_pairs.h"
#include "library/scene_error.h"
#include "runtime/engine/detection/detectors.h"
#include "tests/runtime/engine/paired_run.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using detection::Detectors;
using detection::NamedDetector;
using Eigen::Vector3d;

NamedDetector Named(std::shared_ptr<Detector> detector, Phases phases = kBroad) {
  return {.name = "tested", .phases = phases, .max_bodies = 0, .detector = std::move(detector)};
}

/// Lists the exact pairs in each cycle, as the referee finds them.
class Exact : public Detector {
 public:
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    pairs = detectors::ExactPairs(scene);
  }
};

plan::Scene Sorted(plan::Scene scene) {
  SetWorld(scene, "pair_order", Word("sorted"));
  return scene;
}

/// Balls that move freely in a cube, filling an eighth of it. None sleeps: sleeping depends on
/// which non-overlapping pairs are listed, and Bullet's detectors differ in these.
plan::Scene Gas(std::uint64_t quantity) {
  plan::Scene scene = EngineScene(quantity, std::cbrt(static_cast<double>(quantity)) * 2);
  SetWorld(scene, "acceleration", Vector3d(0, 0, 0));
  SetWorld(scene, "timestep", 1.0 / 60);
  SetWorld(scene, "sleeping", false);
  SetGroup(scene, "size", 1.2);
  SetGroup(scene, "linear_velocity", Normal(0.0, 3.0));
  SetGroup(scene, "angular_velocity", Normal(0.0, 1.0));
  return Sorted(scene);
}

/// The same, falling on the floor and coming to rest there.
plan::Scene Pile(std::uint64_t quantity) {
  plan::Scene scene = Gas(quantity);
  SetWorld(scene, "sleeping", true);
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  SetGroup(scene, "restitution", 0.2);
  SetGroup(scene, "friction", 0.5);
  SetGroup(scene, "rolling_friction", 0.1);
  return scene;
}

plan::Scene Mixed(std::uint64_t quantity) {
  plan::Scene scene = Pile(quantity);
  SetGroup(scene, "type", AnyType());
  SetGroup(scene, "size", Uniform(0.6, 1.2));
  SetGroup(scene, "orientation", Word("random"));
  return scene;
}

plan::Scene Boxes(std::uint64_t quantity) {
  plan::Scene scene = Pile(quantity);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 0.8);
  return scene;
}

/// The state after `steps` steps. The default is the scene's detectors.
std::string HashAfter(const plan::Scene& scene, const layouts::InitialState& state, int steps,
                      const Detectors* detectors = nullptr) {
  auto omissions = omissions::KeepEverything(scene);
  const auto engine = detectors == nullptr
                          ? std::make_unique<world::Engine>(scene, state, omissions)
                          : std::make_unique<world::Engine>(scene, state, omissions, *detectors);
  Steps(*engine, steps);
  return probes::StateHash(*engine);
}

std::string BulletAlone(plan::Scene scene, const layouts::InitialState& state, int steps,
                        const char* detector = "dbvt") {
  SetWorld(scene, "detector", Word(detector));
  return HashAfter(scene, state, steps);
}

/// The final state with Bullet's pairs, and its contacts, passed through the interface.
std::string Through(const plan::Scene& scene, const layouts::InitialState& state, int steps,
                    const char* broad, bool contacts) {
  Detectors detectors{.broad = detection::MakeDetector(broad, scene), .narrow = {}};
  if (contacts) detectors.narrow = detection::MakeDetector("bullet", scene);
  return HashAfter(scene, state, steps, &detectors);
}

/// The ordinary build compares the motion; sanitizers check the same code in fewer steps.
constexpr int StepsHere(int all) { return kAnySanitizer ? (all + 2) / 3 : all; }

void ExpectBulletThroughTheAdapter(const plan::Scene& scene, int all_steps) {
  const int steps = StepsHere(all_steps);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const std::string alone = BulletAlone(scene, state, steps);
  EXPECT_EQ(Through(scene, state, steps, "dbvt", false), alone) << "dbvt";
  EXPECT_EQ(Through(scene, state, steps, "dbvt", true), alone) << "dbvt with contacts";
  EXPECT_EQ(Through(scene, state, steps, "sap32", true), alone) << "sap32 with contacts";
}

TEST(Adapter, GasOf216BallsMovesAsInBulletAlone) { ExpectBulletThroughTheAdapter(Gas(216), 1000); }
TEST(Adapter, GasOf1000BallsMovesAsInBulletAlone) { ExpectBulletThroughTheAdapter(Gas(1000), 150); }
TEST(Adapter, PileOf216BallsMovesAsInBulletAlone) {
  ExpectBulletThroughTheAdapter(Pile(216), 1000);
}
TEST(Adapter, PileOf1000BallsMovesAsInBulletAlone) {
  ExpectBulletThroughTheAdapter(Pile(1000), 150);
}
TEST(Adapter, MixedShapesMoveAsInBulletAlone) { ExpectBulletThroughTheAdapter(Mixed(216), 400); }
TEST(Adapter, CuboidsMoveAsInBulletAlone) { ExpectBulletThroughTheAdapter(Boxes(216), 400); }

TEST(Adapter, BoxWallsAndFaithfulContactsMakeNoDifference) {
  plan::Scene scene = Gas(125);
  SetWorld(scene, "world.wall_shape", Word("box"));
  SetWorld(scene, "contact", Word("faithful"));
  SetGroup(scene, "restitution", 1.0);
  ExpectBulletThroughTheAdapter(scene, 300);
}

TEST(Adapter, EveryExactDetectorOfOursMovesTheBodiesAlike) {
  constexpr int kSteps = StepsHere(200);
  for (const plan::Scene& scene : {Gas(216), Mixed(216)}) {
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    const std::string alone = BulletAlone(scene, state, kSteps);
    Detectors exact{.broad = Named(std::make_shared<Exact>()), .narrow = {}};
    EXPECT_EQ(HashAfter(scene, state, kSteps, &exact), alone);
    for (const DetectorEntry& entry : builtin::BuiltinDetectors()) {
      if (!schema::FindDetector(entry.name)->FindsPairs()) continue;
      plan::Scene named = scene;
      SetWorld(named, "detector", Word(entry.name));
      SetWorld(named, "narrow_phase", Word("bullet"));
      EXPECT_EQ(HashAfter(named, state, kSteps), alone) << entry.name;
    }
  }
}

TEST(Adapter, BulletsFourFindTheSamePairsAloneAndWithContactsOfAnother) {
  const plan::Scene scene = Gas(216);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const std::string alone = BulletAlone(scene, state, 200);
  for (const char* broad : {"simple", "sap", "sap32", "dbvt"}) {
    EXPECT_EQ(BulletAlone(scene, state, 200, broad), alone) << broad << " alone";
    EXPECT_EQ(Through(scene, state, 200, broad, true), alone) << broad;
  }
}

TEST(Adapter, SweepsFindTheWallThatStandsInTheWay) {
  plan::Scene scene = EngineScene(1, 500);
  SetWorld(scene, "world.wall_shape", Word("box"));
  SetGroup(scene, "linear_velocity", Vector3d(20000, 100, 0));
  const std::string through_the_wall = BulletAlone(scene, layouts::MakeInitialState(scene), 20);
  SetGroup(scene, "ccd", true);
  ExpectBulletThroughTheAdapter(scene, 20);
  EXPECT_NE(BulletAlone(scene, layouts::MakeInitialState(scene), 20), through_the_wall);
}

/// The number of sleeping objects.
std::size_t Asleep(const world::Engine& engine) {
  std::size_t count = 0;
  for (const auto& body : engine.objects()) count += body->getActivationState() == ISLAND_SLEEPING;
  return count;
}

TEST(Adapter, AStackFallsAsleepAsInBulletAlone) {
  plan::Scene scene = Sorted(EngineScene(5, 20));
  SetWorld(scene, "acceleration", Vector3d(0, -9.8, 0));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 1.0);
  layouts::InitialState state = layouts::DrawObjects(scene);
  for (std::size_t i = 0; i < 5; ++i)
    state.objects[i].pose.position = {0, -9.5 + static_cast<double>(i), 0};
  const auto omissions = omissions::KeepEverything(scene);
  const Detectors detectors{.broad = Named(std::make_shared<Exact>()),
                            .narrow = detection::MakeDetector("bullet", scene)};
  world::Engine alone(scene, state, omissions), through(scene, state, omissions, detectors);
  for (int step = 0; step < 400; ++step) {
    alone.Step();
    through.Step();
    ASSERT_EQ(Asleep(through), Asleep(alone)) << "step " << step;
    ASSERT_EQ(probes::StateHash(through), probes::StateHash(alone)) << "step " << step;
  }
  EXPECT_EQ(Asleep(through), 5u);
}

TEST(Adapter, WhatIsLeftOutMakesNoDifference) {
  for (const char* order : {"sorted", "listed"}) {
    for (plan::Scene scene : {Gas(60), Pile(60), Mixed(40)}) {
      SetWorld(scene, "pair_order", Word(order));
      SetWorld(scene, "cycles", std::uint64_t{150});
      SetWorld(scene, "omit", schema::WordList{"auto"});
      for (const char* detector : {"octree", "null"}) {
        SCOPED_TRACE(std::string(detector) + ", " + order);
        SetWorld(scene, "detector", Word(detector));
        RunPaired(scene);
      }
    }
  }
}

TEST(Adapter, NullFindsNothingAndMovesOn) {
  plan::Scene scene = Gas(50);
  SetWorld(scene, "detector", Word("null"));
  SetWorld(scene, "cycles", std::uint64_t{20});
  SetWorld(scene, "record", schema::WordList{"timing", "counts"});
  Recorded recorded = RunHere(scene);
  ASSERT_TRUE(recorded.done()) << recorded.message();
  for (const std::int32_t pairs : recorded.recording.Ints("pairs")) EXPECT_EQ(pairs, 0);
  EXPECT_GT(recorded.header().scalars.harness_ns, 0);
}

/// Lists the exact pairs and then calls a function of the test.
class Meddler : public Exact {
 public:
  using Pairs = std::function<void(std::vector<Pair>&)>;
  explicit Meddler(Pairs meddle) : meddle_(std::move(meddle)) {}
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    Exact::FindPairs(scene, pairs);
    meddle_(pairs);
  }

 private:
  Pairs meddle_;
};

TEST(Adapter, PairsListedTwiceOrTheOtherWayRoundCountOnce) {
  const plan::Scene scene = Gas(216);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const std::string alone = BulletAlone(scene, state, 200);
  int cycle = 0;
  for (const Meddler::Pairs& meddle : {
           Meddler::Pairs([](std::vector<Pair>& pairs) {
             const std::vector<Pair> once = pairs;
             pairs.insert(pairs.end(), once.begin(), once.end());
           }),
           Meddler::Pairs([](std::vector<Pair>& pairs) {
             for (Pair& pair : pairs) std::swap(pair.a, pair.b);
           }),
           Meddler::Pairs([&cycle](std::vector<Pair>& pairs) {
             std::shuffle(pairs.begin(), pairs.end(), std::mt19937(7));
             if (++cycle % 2 == 0) std::ranges::reverse(pairs);
             if (cycle % 3 == 0 && !pairs.empty()) pairs.push_back(pairs.front());
             if (cycle % 5 == 0 && !pairs.empty())
               pairs.push_back({pairs.back().b, pairs.back().a});
           }),
       }) {
    Detectors detectors{.broad = Named(std::make_shared<Meddler>(meddle)), .narrow = {}};
    EXPECT_EQ(HashAfter(scene, state, 200, &detectors), alone);
  }
}

/// The error message of a step with these detectors.
std::string MessageOf(const Detectors& detectors) {
  plan::Scene scene = Boxes(60);
  SetGroup(scene, "size", 1.1);
  try {
    world::Engine engine(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene),
                         detectors);
    Steps(engine, 100);
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "no error";
}

std::string MessageOfPairs(Meddler::Pairs meddle) {
  return MessageOf({.broad = Named(std::make_shared<Meddler>(std::move(meddle))), .narrow = {}});
}

void ExpectMentions(const std::string& message, std::initializer_list<const char*> texts) {
  for (const char* text : texts)
    EXPECT_NE(message.find(text), std::string::npos) << message << "\nlacks " << text;
}

TEST(Adapter, PairsThatMakeNoSenseFailWithTheirMessage) {
  ExpectMentions(MessageOfPairs([](auto& pairs) {
                   pairs.push_back({3, 1000});
                 }),
                 {"`tested`", "FindPairs of cycle 1", "(3, 1000)", "66 bodies"});
  ExpectMentions(MessageOfPairs([](auto& pairs) {
                   pairs.push_back({5, 5});
                 }),
                 {"`tested`", "FindPairs of cycle 1", "body 5 with itself"});
  int cycle = 0;
  ExpectMentions(MessageOfPairs([&](auto&) {
                   if (++cycle == 7) throw std::runtime_error("out of ideas");
                 }),
                 {"`tested`", "FindPairs of cycle 7", "out of ideas"});
  ExpectMentions(MessageOfPairs([](auto&) { throw 5; }),
                 {"`tested`", "other than a std::exception"});
}

/// Bullet's contacts, changed by a function of the test.
class ContactMeddler : public Detector {
 public:
  using Contacts = std::function<void(std::span<const Pair>, std::vector<Contact>&)>;
  explicit ContactMeddler(Contacts meddle)
      : bullet_(detection::MakeDetector("bullet", EngineScene(1, 1))), meddle_(std::move(meddle)) {}
  void Prepare(const Scene& scene) override { bullet_.detector->Prepare(scene); }
  bool Handles(const Scene& scene, Id a, Id b) const override {
    return bullet_.detector->Handles(scene, a, b);
  }
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    bullet_.detector->FindContacts(scene, pairs, contacts);
    if (!contacts.empty()) meddle_(pairs, contacts);
  }

 private:
  NamedDetector bullet_;
  Contacts meddle_;
};

std::string MessageOfContacts(ContactMeddler::Contacts meddle) {
  return MessageOf({.broad = Named(std::make_shared<Exact>()),
                    .narrow = Named(std::make_shared<ContactMeddler>(std::move(meddle)), kNarrow)});
}

TEST(Adapter, ContactsThatMakeNoSenseFailWithTheirMessage) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(MessageOfContacts([](auto, auto&) {}), "no error");
  ExpectMentions(MessageOfContacts([](auto, auto& contacts) { contacts[0].on_b.y = kNan; }),
                 {"`tested`", "FindContacts of cycle ", "a number that is not finite"});
  ExpectMentions(MessageOfContacts([](auto, auto& contacts) { contacts[0].distance = kNan; }),
                 {"`tested`", "a number that is not finite"});
  ExpectMentions(MessageOfContacts([](auto, auto& contacts) { contacts[0].normal.x += 2; }),
                 {"`tested`", "a normal of length"});
  ExpectMentions(MessageOfContacts([](auto, auto& contacts) {
                   Vec3& normal = contacts[0].normal;
                   normal = {-normal.x, -normal.y, -normal.z};
                   contacts[0].distance = -0.5;
                 }),
                 {"`tested`", "contradicts itself"});
  ExpectMentions(MessageOfContacts([](auto, auto& contacts) { contacts[0].a = 64; }),
                 {"`tested`", "a pair that it was not given"});
  ExpectMentions(MessageOfContacts([](auto, auto& contacts) { contacts[0].b = 4000000000; }),
                 {"`tested`", "a pair that it was not given"});
  ExpectMentions(MessageOfContacts([](auto, auto&) { throw std::runtime_error("no luck"); }),
                 {"`tested`", "FindContacts of cycle ", "no luck"});
}

TEST(Adapter, ContactsMayComeInAnyOrder) {
  const plan::Scene scene = Boxes(125);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const std::string alone = BulletAlone(scene, state, 200);
  // The contacts of one pair keep their order, because each is matched with the points already in
  // the manifold.
  Detectors detectors{
      .broad = Named(std::make_shared<Exact>()),
      .narrow = Named(std::make_shared<ContactMeddler>([](auto, std::vector<Contact>& contacts) {
                        std::ranges::stable_sort(contacts, {}, [](const Contact& contact) {
                          return (contact.a * 7919 + contact.b * 104729) % 1000;
                        });
                      }),
                      kNarrow)};
  EXPECT_EQ(HashAfter(scene, state, 200, &detectors), alone);
}

TEST(Adapter, ASceneSaysWhatItCannotHave) {
  const auto message = [](const char* detector, const char* narrow_phase) -> std::string {
    plan::Scene scene = Gas(10);
    SetWorld(scene, "detector", Word(detector));
    SetWorld(scene, "narrow_phase", Word(narrow_phase));
    try {
      WholeEngine(scene, layouts::MakeInitialState(scene));
    } catch (const library::SceneError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message("null", "bullet"), "no error");
  ExpectMentions(message("nonesuch", "own"), {"`nonesuch`", "does not exist in this version"});
  ExpectMentions(message("dbvt", "null"), {"`null`", "finds pairs but no contacts"});
  plan::Scene scene = Gas(10);
  NamedDetector small = Named(std::make_shared<Exact>());
  small.max_bodies = 15;
  try {
    world::Engine(scene, layouts::MakeInitialState(scene), omissions::KeepEverything(scene),
                  {.broad = small, .narrow = {}});
    ADD_FAILURE() << "takes more than it holds";
  } catch (const library::SceneError& error) {
    ExpectMentions(error.what(), {"`tested`", "at most 15 bodies", "has 16"});
  }
}

}  // namespace
}  // namespace cdb::tests
