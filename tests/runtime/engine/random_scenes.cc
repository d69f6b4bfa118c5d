#include "tests/runtime/engine/random_scenes.h"

#include <cmath>
#include <initializer_list>
#include <iterator>

#include "library/distributions/stream.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::Value;

/// Generates scenes from random parts.
class Maker {
 public:
  explicit Maker(distributions::Stream& stream) : stream_(stream) {}

  double Log(double least, double most) { return stream_.LogUniform(least, most); }
  double Between(double least, double most) { return stream_.Uniform(least, most); }
  bool Chance(double part) { return stream_.Uniform() < part; }
  std::uint64_t Count(std::uint64_t least, std::uint64_t most) {
    return least +
           static_cast<std::uint64_t>(stream_.Uniform(0, static_cast<double>(most - least + 1)));
  }
  const char* Pick(std::initializer_list<const char*> words) {
    return words.begin()[Count(0, words.size() - 1)];
  }
  Vector3d Direction() { return stream_.Turn() * Vector3d::UnitX(); }

  /// A scene with random values for what a study chooses freely: time step, iterations, length of
  /// the run.
  plan::Scene Make(std::uint64_t quantity, double side) {
    plan::Scene scene = EngineScene(quantity, side);
    SetWorld(scene, "record", schema::WordList{"stability"});
    SetWorld(scene, "cycles", Count(60, 300));
    SetWorld(scene, "timestep", 1 / Log(30, 480));
    SetWorld(scene, "solver.iterations", Count(5, 50));
    SeedStreams(scene, Count(1, 1'000'000));
    return scene;
  }
  double Size() { return Log(0.1, 100); }
  double Gravity() { return Log(1, 50); }
  void Fall(plan::Scene& scene, double gravity) {
    SetWorld(scene, "acceleration", Vector3d(0, -gravity, 0));
  }
  void AddGroup(plan::Scene& scene) {
    scene.groups.push_back(scene.groups[0]);
    scene.groups.back().name = "others";
    SeedStreams(scene, Count(1, 1'000'000));
  }
  static void PutAt(plan::Scene& scene, const Vector3d& place, std::size_t group = 0) {
    SetGroup(scene, "location",
             Layout("at", {{"x", place.x()}, {"y", place.y()}, {"z", place.z()}}), group);
  }

 private:
  distributions::Stream& stream_;
};

plan::Scene Trajectory(Maker& make) {
  const double far = make.Log(1, 1e9);
  plan::Scene scene = make.Make(1, 4 * far + 1000);
  const double size = make.Size();
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "size", size);
  make.PutAt(scene, far * make.Direction());
  SetGroup(scene, "linear_velocity", Vector3d(make.Log(1e-1, 1e4) * make.Direction()));
  make.Fall(scene, make.Chance(0.5) ? 0 : make.Gravity());
  return scene;
}

plan::Scene Fast(Maker& make) {
  const double size = make.Log(1, 1e7);
  plan::Scene scene = make.Make(1, 10 * size);
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "size", size);
  SetGroup(scene, "linear_velocity", Vector3d(make.Log(1, 1e9) * make.Direction()));
  make.PutAt(scene, Vector3d::Zero());
  make.Fall(scene, make.Chance(0.5) ? 0 : make.Gravity());
  return scene;
}

plan::Scene Spin(Maker& make) {
  plan::Scene scene = make.Make(1, 1000);
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "size", make.Size());
  SetGroup(scene, "type", Word(make.Pick({"sphere", "cuboid", "cylinder", "cone", "capsule"})));
  if (make.Chance(0.5))
    SetGroup(scene, "aspect", schema::Ratio{{1, make.Log(0.3, 3), make.Log(0.3, 3)}});
  make.PutAt(scene, Vector3d::Zero());
  SetGroup(scene, "angular_velocity", Vector3d(make.Log(0.1, 1e4) * make.Direction()));
  make.Fall(scene, make.Chance(0.7) ? 0 : make.Gravity());
  return scene;
}

plan::Scene Stack(Maker& make) {
  const std::uint64_t n = make.Count(1, 20);
  const double size = make.Size();
  plan::Scene scene = make.Make(n, 25 * size);
  SetWorld(scene, "world.walls", Word("floor"));
  SetWorld(scene, "world.wall_shape", Word(make.Pick({"plane", "box"})));
  SetWorld(scene, "timestep", 1 / make.Log(15, 1000));
  SetWorld(scene, "solver.iterations", static_cast<std::uint64_t>(make.Log(1, 100)));
  SetGroup(scene, "type", Word(make.Pick({"cuboid", "cuboid", "cylinder"})));
  SetGroup(scene, "size", size);
  SetGroup(scene, "location", Layout("stack"));
  make.Fall(scene, make.Log(1, 1000));
  return scene;
}

plan::Scene Pyramid(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = make.Make(make.Chance(0.5) ? 5 : 14, 10 * size);
  SetWorld(scene, "timestep", 1 / make.Log(15, 1000));
  SetWorld(scene, "solver.iterations", static_cast<std::uint64_t>(make.Log(1, 100)));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", size);
  SetGroup(scene, "location", Layout("pyramid"));
  make.Fall(scene, make.Log(1, 1000));
  return scene;
}

/// One cuboid on the other, both at rest.
plan::Scene Two(Maker& make, double below, double above) {
  const double side = 10 * (below + above), gap = 1e-3 * std::min(below, above);
  plan::Scene scene = make.Make(1, side);
  SetWorld(scene, "expect", Word("rest"));
  SetGroup(scene, "type", Word("cuboid"));
  make.AddGroup(scene);
  SetGroup(scene, "size", below, 0);
  SetGroup(scene, "size", above, 1);
  const double floor = -side / 2 + gap;
  make.PutAt(scene, {0, floor + below / 2, 0}, 0);
  make.PutAt(scene, {0, floor + below + gap + above / 2, 0}, 1);
  return scene;
}

plan::Scene MassRatio(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = Two(make, size, size);
  SetWorld(scene, "solver.iterations", static_cast<std::uint64_t>(make.Log(1, 100)));
  const double ratio = make.Log(1, 1e6);
  SetGroup(scene, "mass", ratio, make.Chance(0.7) ? 1 : 0);
  return scene;
}

plan::Scene SizeRatio(Maker& make) {
  const double ratio = make.Log(1, 1e5);
  return Two(make, ratio, 1);
}

plan::Scene HeavyMass(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = Two(make, size, size);
  const double mass = make.Log(1, kEpsilon < 1e-10 ? 1e20 : 1e12);
  SetGroup(scene, "mass", mass, 0);
  SetGroup(scene, "mass", mass, 1);
  return scene;
}

plan::Scene Drop(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = make.Make(make.Count(1, 8), make.Between(6, 15) * size);
  SetWorld(scene, "world.wall_shape", Word(make.Pick({"plane", "box"})));
  SetGroup(scene, "type", Word(make.Pick({"sphere", "cuboid", "cylinder", "cone", "capsule"})));
  SetGroup(scene, "size", size);
  SetGroup(scene, "orientation", Word("random"));
  SetWorld(scene, "timestep", 1 / make.Log(15, 1000));
  make.Fall(scene, make.Log(1, 1e6));
  return scene;
}

plan::Scene Shot(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = make.Make(1, make.Between(6, 30) * size);
  SetWorld(scene, "world.wall_shape", Word(make.Chance(0.8) ? "box" : "plane"));
  SetGroup(scene, "type", Word(make.Pick({"sphere", "cuboid", "cylinder"})));
  SetGroup(scene, "size", size);
  SetGroup(scene, "ccd", make.Chance(0.3));
  make.PutAt(scene, Vector3d::Zero());
  const double step = scene.world.Real("timestep");
  SetGroup(scene, "linear_velocity", Vector3d(size / step * make.Log(1e-2, 1e3), 0, 0));
  make.Fall(scene, make.Chance(0.5) ? 0 : make.Gravity());
  return scene;
}

plan::Scene SoftContact(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = make.Make(make.Count(1, 4), 10 * size);
  const double mass = make.Log(0.1, 100), gravity = make.Gravity();
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", size);
  SetGroup(scene, "mass", mass);
  SetGroup(scene, "location", Layout("stack"));
  SetGroup(scene, "contact_stiffness", mass * gravity / make.Log(1e-5, 10));
  SetGroup(scene, "contact_damping", make.Log(0.1, 100));
  make.Fall(scene, gravity);
  return scene;
}

plan::Scene ThinShape(Maker& make) {
  const double aspect = make.Log(1, 1e4);
  plan::Scene scene = make.Make(make.Count(2, 6), 4 * aspect);
  SetGroup(scene, "type",
           Word(make.Pick({"sphere", "cuboid", "cylinder", "cone", "capsule", "tetrahedron"})));
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "aspect",
           make.Chance(0.5) ? schema::Ratio{{1, 1, aspect}} : schema::Ratio{{1, aspect, 1}});
  SetGroup(scene, "linear_velocity",
           Uniform(Vector3d(-aspect, -aspect, -aspect), Vector3d(aspect, aspect, aspect)));
  make.Fall(scene, make.Chance(0.5) ? 0 : make.Gravity());
  return scene;
}

plan::Scene FarFloor(Maker& make) {
  const double size = make.Size();
  plan::Scene scene =
      make.Make(make.Count(1, 3), size * make.Log(10, kEpsilon < 1e-10 ? 1e18 : 1e9));
  SetWorld(scene, "world.walls", Word("floor"));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", size);
  SetGroup(scene, "location", Layout("stack", {{"gap", 0.01 * size}}));
  make.Fall(scene, make.Gravity());
  return scene;
}

plan::Scene Gas(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = make.Make(make.Count(5, 20), make.Between(6, 12) * size);
  SetWorld(scene, "world.wall_shape", Word(make.Pick({"plane", "box"})));
  SetGroup(scene, "type", Word(make.Pick({"sphere", "cuboid", "cylinder"})));
  SetGroup(scene, "size", Uniform(0.5 * size, size));
  const double speed = size * make.Log(0.1, 100);
  SetGroup(scene, "linear_velocity",
           Uniform(Vector3d(-speed, -speed, -speed), Vector3d(speed, speed, speed)));
  SetGroup(scene, "restitution", make.Chance(0.5) ? 0.0 : make.Between(0, 1));
  make.Fall(scene, make.Chance(0.5) ? 0 : make.Gravity());
  return scene;
}

plan::Scene Heap(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = make.Make(make.Count(5, 15), 6 * size);
  const double masses = make.Log(1, 1e4);
  SetGroup(scene, "type", Word(make.Pick({"sphere", "cuboid"})));
  SetGroup(scene, "size", size);
  SetGroup(scene, "mass",
           schema::Distribution{schema::DistributionKind::kLogUniform, {1.0, masses}, {}});
  make.Fall(scene, make.Gravity());
  return scene;
}

plan::Scene Spring(Maker& make) {
  const std::uint64_t n = make.Count(1, 6);
  const double size = make.Size();
  plan::Scene scene = make.Make(n, 100 * size);
  const double mass = make.Log(0.1, 100), step = scene.world.Real("timestep");
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "size", size);
  SetGroup(scene, "mass", mass);
  SetGroup(scene, "location", Layout("line"));
  SetGroup(scene, "links.type", Word("spring"));
  SetGroup(scene, "links.stiffness", mass * std::pow(make.Log(1e-2, 1e2) / step, 2));
  if (make.Chance(0.5)) SetGroup(scene, "links.damping", mass / step * make.Log(1e-3, 10));
  SetGroup(scene, "linear_velocity", Vector3d(0, -size * make.Log(0.1, 10), 0));
  make.Fall(scene, make.Chance(0.5) ? 0 : make.Gravity());
  return scene;
}

plan::Scene Chain(Maker& make) {
  const double size = make.Size();
  plan::Scene scene = make.Make(make.Count(2, 8), 100 * size);
  SetWorld(scene, "solver.iterations", static_cast<std::uint64_t>(make.Log(1, 100)));
  SetWorld(scene, "world.walls", Word("none"));
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "size", size);
  SetGroup(scene, "location", Layout("line"));
  SetGroup(scene, "links.type", Word(make.Pick({"ball", "hinge", "fixed"})));
  SetGroup(scene, "links.end_mass", make.Log(1, 1e6));
  make.Fall(scene, make.Gravity());
  return scene;
}

struct Theme {
  std::string_view name;
  plan::Scene (*make)(Maker&);
};

constexpr Theme kThemes[] = {
    {"flight", Trajectory},
    {"fast", Fast},
    {"spin", Spin},
    {"stack", Stack},
    {"pyramid", Pyramid},
    {"mass ratio", MassRatio},
    {"size ratio", SizeRatio},
    {"heavy mass", HeavyMass},
    {"drop", Drop},
    {"shot", Shot},
    {"soft contact", SoftContact},
    {"thin shape", ThinShape},
    {"far floor", FarFloor},
    {"gas", Gas},
    {"heap", Heap},
    {"spring", Spring},
    {"chain", Chain},
};

}  // namespace

std::vector<RandomScene> RandomScenes(std::size_t count, std::uint64_t seed) {
  distributions::Stream stream(seed);
  Maker maker(stream);
  std::vector<RandomScene> scenes;
  for (std::size_t i = 0; i < count; ++i) {
    const Theme& theme = kThemes[i % std::size(kThemes)];
    scenes.push_back({theme.name, theme.make(maker)});
  }
  return scenes;
}

}  // namespace cdb::tests
