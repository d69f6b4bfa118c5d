// Builders of scenes with known outcomes (known_scenes.h).
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/known_scenes.h"

namespace cdb::tests {

inline constexpr double kKnownHz = 60;
/// One object of a scene, in a separate group.
struct KnownBody {
  std::string_view type = "sphere";
  Eigen::Vector3d sides = Eigen::Vector3d::Ones();  ///< m
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), spin = Eigen::Vector3d::Zero(),
                  turn = Eigen::Vector3d::Zero();
  double mass = 1;  ///< kg; 0: fixed
  double friction = 0.5, restitution = 0;
  bool ccd = false;
  bool is_kinematic = false;
};

/// Starts without walls, or with the given ones; adds each object as a separate group.
class KnownBuilder {
 public:
  explicit KnownBuilder(double side, std::string_view walls = "none", std::uint64_t cycles = 120)
      : scene_(EngineScene(1, side)) {
    SetWorld(scene_, "record", schema::WordList{"stability"});
    SetWorld(scene_, "world.walls", Word(walls));
    SetWorld(scene_, "cycles", cycles);
  }
  KnownBuilder& World(schema::WorldParameter parameter, schema::Value value) {
    SetWorld(scene_, parameter, std::move(value));
    return *this;
  }
  KnownBuilder& Group(schema::GroupParameter parameter, schema::Value value) {
    SetGroup(scene_, parameter, std::move(value), count_ - 1);
    return *this;
  }
  KnownBuilder& Weightless() { return World("acceleration", Eigen::Vector3d(0, 0, 0)); }
  KnownBuilder& Add(const KnownBody& body) {
    if (count_++ > 0) scene_.groups.push_back(scene_.groups[0]);
    scene_.groups.back().name = fmt::format("group{}", count_);
    Group("type", Word(body.type));
    Group("size", body.sides.x());
    Group("aspect", schema::Ratio{body.sides / body.sides.x()});
    Group("location", Layout("at", {{"x", body.at.x()}, {"y", body.at.y()}, {"z", body.at.z()}}));
    Group("linear_velocity", body.velocity);
    Group("angular_velocity", body.spin);
    Group("orientation", body.turn);
    Group("mass", body.is_kinematic ? Word("kinematic")
                  : body.mass > 0   ? schema::Value(body.mass)
                                    : Word("fixed"));
    Group("friction", body.friction);
    Group("restitution", body.restitution);
    Group("ccd", body.ccd);
    return *this;
  }
  plan::Scene Done() {
    SeedStreams(scene_);
    return scene_;
  }

 private:
  plan::Scene scene_;
  std::size_t count_ = 0;
};

/// One function for each fault and its sound look-alikes.
class KnownCatalogue {
 public:
  std::vector<KnownScene> scenes;

  void Passing();
  void PassingOffCentre();
  void NotPassing();
  void NotPassingOffCentre();
  void Crushing();
  void NotCrushing();
  void Losing();
  void NotLosing();
  void Sleeping();
  void NotSleeping();

 private:
  void Begin(Fault fault, bool is_sound, std::string_view family, std::string_view why) {
    head_ = {fault, is_sound, family, why, {}, {}};
  }
  void Add(std::string variant, KnownBuilder builder) {
    KnownScene scene = head_;
    scene.variant = std::move(variant);
    scene.scene = builder.Done();
    scenes.push_back(std::move(scene));
  }

  KnownScene head_;
};

/// A body on the floor of a cube of 20 m, with its lower side at `height`.
inline KnownBody Standing(std::string_view type, const Eigen::Vector3d& sides, double height,
                          double mass) {
  const double below = type == "cone" ? sides.y() / 4 : sides.y() / 2;
  return {.type = type,
          .sides = sides,
          .at = {0, -10 + 1.001 * height + below + 1e-3, 0},
          .mass = mass};
}

}  // namespace cdb::tests
