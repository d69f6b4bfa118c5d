// A scene for each closed form, for tests of the closed forms and of the engine.
#pragma once

#include <string>
#include <vector>

#include "library/closed_forms/closed_form.h"
#include "tests/library/layouts/layout_scene.h"

namespace cdb::tests {

/// Gap above the floor, or between neighbours, in m: nearly zero, because layouts let no surfaces
/// touch.
inline constexpr double kHair = 1e-6;

inline schema::Value At(double x, double y, double z) {
  return Layout("at", {{"x", x}, {"y", y}, {"z", z}});
}

inline void SetTime(plan::Scene& scene, double timestep, double seconds) {
  SetWorld(scene, "timestep", timestep);
  SetWorld(scene, "cycles", static_cast<std::uint64_t>(std::llround(seconds / timestep)));
}

/// One object of size 1 in the middle of a cube of side 10 with only a floor, 1 s at 60 Hz, without
/// sleeping.
inline plan::Scene OneObjectScene() {
  plan::Scene scene = LayoutScene(1, 10, At(0, 0, 0));
  SetWorld(scene, "world.walls", Word("floor"));
  SetWorld(scene, "sleeping", false);
  SetTime(scene, 1.0 / 60, 1);
  return scene;
}

/// A ball thrown upwards.
inline plan::Scene FlightScene() {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "linear_velocity", Eigen::Vector3d(3, 5, -1));
  return scene;
}

/// A ball that falls 4.5 m onto the floor.
inline plan::Scene BounceScene(double restitution = 1) {
  plan::Scene scene = OneObjectScene();
  SetGroup(scene, "restitution", restitution);
  SetGroup(scene, "friction", 0.0);
  return scene;
}

/// A box twice as wide as high on a slope of `angle`, downhill along x.
inline plan::Scene SlopeScene(double angle, double friction) {
  plan::Scene scene = OneObjectScene();
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "aspect", schema::Ratio{{1, 0.5, 1}});
  SetGroup(scene, "location", Layout("stack", {{"gap", kHair}}));
  SetGroup(scene, "friction", friction);
  SetWorld(scene, "acceleration",
           Eigen::Vector3d(9.8 * std::sin(angle), -9.8 * std::cos(angle), 0));
  return scene;
}

/// A box with three different sides that rotates almost about its middle axis.
inline plan::Scene SpinScene() {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Eigen::Vector3d(0, 0, 0));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "aspect", schema::Ratio{{1, 1.5, 2}});
  SetGroup(scene, "angular_velocity", Eigen::Vector3d(0.2, 3, 0.1));
  return scene;
}

/// Two balls 2 m apart that approach each other at 4 m/s; the second is `mass` times as heavy.
inline plan::Scene HeadOnScene(double mass, double restitution) {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration", Eigen::Vector3d(0, 0, 0));
  SetGroup(scene, "friction", 0.0);
  SetGroup(scene, "restitution", std::sqrt(restitution));
  SetGroup(scene, "location", At(-1.5, 0, 0));
  SetGroup(scene, "linear_velocity", Eigen::Vector3d(3, 0, 0));
  const std::size_t second = AddGroup(scene, "second", 1, At(1.5, 0, 0));
  SetGroup(scene, "linear_velocity", Eigen::Vector3d(-1, 0, 0), second);
  SetGroup(scene, "mass", mass, second);
  return scene;
}

/// A plate of 10 kg on 5 x 5 balls of 1 kg, on a slope of `angle`.
inline plan::Scene RollingScene(double angle) {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "world.side", 40.0);
  SetWorld(scene, "acceleration",
           Eigen::Vector3d(9.8 * std::sin(angle), -9.8 * std::cos(angle), 0));
  SetGroup(scene, "quantity", std::uint64_t{25});
  SetGroup(scene, "friction", 1.0);
  SetGroup(scene, "location",
           Layout("stack", {{"height", std::uint64_t{1}}, {"gap", kHair}, {"spacing", 3.0}}));
  const std::size_t plate = AddGroup(scene, "plate", 1, At(0, -20 + 1 + 0.5 + 2 * kHair, 0));
  SetGroup(scene, "type", Word("cuboid"), plate);
  SetGroup(scene, "size", 20.0, plate);
  SetGroup(scene, "aspect", schema::Ratio{{1, 0.05, 1}}, plate);
  SetGroup(scene, "mass", 10.0, plate);
  return scene;
}

/// Cubes of side 1.
inline plan::Scene StackScene(std::uint64_t quantity) {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "world.side", 40.0);
  SetGroup(scene, "quantity", quantity);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "location", Layout("stack", {{"gap", kHair}}));
  return scene;
}

/// A box that slides at 3 m/s on the level floor and stops after 3/(0.4 g) s.
inline plan::Scene BrakingScene() {
  plan::Scene scene = SlopeScene(0, 0.8);
  SetGroup(scene, "location", At(-2, -4.75 + kHair, 0));
  SetGroup(scene, "linear_velocity", Eigen::Vector3d(3, 0, 0));
  return scene;
}

/// A ball on a slope of `angle`, downhill along x.
inline plan::Scene RollScene(double angle, double friction) {
  plan::Scene scene = SlopeScene(angle, friction);
  SetGroup(scene, "type", Word("sphere"));
  SetGroup(scene, "aspect", schema::Ratio{{1, 1, 1}});
  return scene;
}

/// A ball thrown along the floor at 7 m/s; it rolls after 2/7 of 7/(0.2 g), 1.02 s.
inline plan::Scene BowlScene() {
  plan::Scene scene = RollScene(0, 0.4);
  SetWorld(scene, "world.side", 40.0);
  SetGroup(scene, "mass", 7.0);
  SetGroup(scene, "location", At(-10, -19.5 + kHair, 0));
  SetGroup(scene, "linear_velocity", Eigen::Vector3d(7, 0, 0));
  SetTime(scene, 1.0 / 60, 2);
  return scene;
}

/// A ball that hits the floor after 0.5 s at 45 degrees.
inline plan::Scene ObliqueScene(double friction) {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "acceleration", Eigen::Vector3d(0, 0, 0));
  SetGroup(scene, "restitution", 0.8);
  SetGroup(scene, "friction", friction);
  SetGroup(scene, "location", At(-1, -3, 0));
  SetGroup(scene, "linear_velocity", Eigen::Vector3d(3, -3, 0));
  return scene;
}

/// A ball of 1 kg that hangs from a spring of 40 N/m.
inline plan::Scene SpringScene(double damping) {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "size", 0.2);
  SetGroup(scene, "links.type", Word("spring"));
  SetGroup(scene, "links.stiffness", 40.0);
  SetGroup(scene, "links.damping", damping);
  return scene;
}

/// A rod of 1 m on a ball joint at its upper end, released at `angle` from its equilibrium.
inline plan::Scene PendulumScene(double angle) {
  plan::Scene scene = OneObjectScene();
  SetWorld(scene, "world.walls", Word("none"));
  SetWorld(scene, "acceleration",
           Eigen::Vector3d(9.8 * std::sin(angle), -9.8 * std::cos(angle), 0));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", 0.1);
  SetGroup(scene, "aspect", schema::Ratio{{1, 10, 1}});
  SetGroup(scene, "links.type", Word("ball"));
  return scene;
}

/// The box of SpinScene, rotating even closer to its middle axis, for 12 s.
inline plan::Scene FlipScene() {
  plan::Scene scene = SpinScene();
  SetGroup(scene, "angular_velocity", Eigen::Vector3d(0.5, 5, 0.25));
  SetTime(scene, 1.0 / 60, 12);
  return scene;
}

inline std::unique_ptr<closed_forms::ClosedForm> FormOf(std::string_view name,
                                                        const plan::Scene& scene) {
  return closed_forms::MakeClosedForm(name, scene, layouts::MakeInitialState(scene));
}

}  // namespace cdb::tests
