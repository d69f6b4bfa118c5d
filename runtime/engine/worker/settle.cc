#include "runtime/engine/worker/settle.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <system_error>

#include "compiler/plan/plan_yaml.h"
#include "library/content_cache.h"
#include "library/distributions/draw.h"
#include "library/layouts/bodies.h"
#include "library/layouts/clearance.h"
#include "library/layouts/exact_layouts.h"
#include "library/meshes/decompose.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/precision.h"
#include "runtime/measure/file_descriptor_io.h"

namespace cdb::worker {
namespace {

using Eigen::Vector3d;
using layouts::InitialState;
using layouts::ObjectState;
using library::SceneError;

constexpr double kSettleMargin = 0.4;  ///< of what an object grows by

/// What is the same for all tries.
struct Settling {
  const plan::Scene& scene;
  const InitialState& dropped;
  std::vector<std::uint32_t> piled;  ///< objects
  double diameter = 0, gravity = 0;  ///< mean, m; m/s^2
  double UnitOfTime() const { return std::sqrt(diameter / gravity); }
};

Settling PrepareToSettle(const plan::Scene& scene, const InitialState& dropped) {
  Settling settling{scene, dropped, {}};
  for (std::size_t i = 0; i < dropped.objects.size(); ++i) {
    const ObjectState& object = dropped.objects[i];
    if (!layouts::IsPile(scene.groups[object.group])) continue;
    if (object.IsFixed())
      throw SceneError(
          fmt::format("the objects of group `{}` are fixed and cannot settle into a pile; give "
                      "them a mass, or another layout",
                      scene.groups[object.group].name));
    settling.piled.push_back(static_cast<std::uint32_t>(i));
    settling.diameter += 2 * object.solid.OuterRadius();
  }
  settling.diameter /= static_cast<double>(settling.piled.size());
  if (scene.world.WordOr("world.walls") == "none")
    throw SceneError("a pile needs a floor: set world.walls to floor or all");
  const Vector3d& g = dropped.acceleration;
  if (!(g.y() < 0) || std::hypot(g.x(), g.z()) > 0.1 * -g.y())
    throw SceneError(
        "a pile settles under an acceleration that points down to the floor, as (0, "
        "-9.8, 0) does");
  settling.gravity = -g.y();
  return settling;
}

/// The scene as it settles: with all that Bullet has, and nothing recorded.
plan::Scene QuietScene(const Settling& settling) {
  plan::Scene scene = settling.scene;
  const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
    scene.world.Set(parameter, std::move(value));
  };
  set("precision", schema::Word{"double"});
  set("detector", schema::Word{"dbvt"});
  set("narrow_phase", schema::Word{"own"});
  set("pair_order", schema::Word{"listed"});
  set("threads", std::uint64_t{1});
  set("contact", schema::Word{"bullet"});
  set("omit", schema::WordList{"none"});
  set("record", schema::WordList{});
  set("sleeping", false);
  // Bullet's own: a sweep of the solver, and a reference run, begin with the same heap too.
  set("solver.iterations", std::uint64_t{10});
  set("solver.erp", 0.2);
  set("solver.warm_start", 0.85);
  set("timestep", std::min(1.0 / 60, settling.UnitOfTime() / 30));
  scene.KeepUsedPlugins();
  return scene;
}

InitialState QuietState(const Settling& settling, double growth) {
  InitialState state = settling.dropped;
  for (ObjectState& object : state.objects) object.mass = 0;
  std::map<const objects::Compound*, std::shared_ptr<const objects::Compound>> grown;
  const double push = 0.5 * std::sqrt(settling.gravity * settling.diameter);
  for (const std::uint32_t i : settling.piled) {
    ObjectState& object = state.objects[i];
    object.mass = settling.dropped.objects[i].mass;
    object.solid.sides *= growth;
    if (const auto& compound = settling.dropped.objects[i].solid.compound) {
      auto& shared = grown[compound.get()];
      if (shared == nullptr)
        shared =
            std::make_shared<const objects::Compound>(compound->shared_form(), object.solid.sides);
      object.solid.compound = shared;
    }
    object.restitution = 0;
    // Corners that Bullet's margin rounds would stand in what they lie on.
    object.margin = kSettleMargin * (growth - 1) * object.solid.LeastHalfExtent();
    object.ccd = false;
    const std::string& group = settling.scene.groups[object.group].name;
    // A stream for each object, so that it does not matter who settles with it.
    distributions::Stream stream(
        plan::StreamSeed(settling.scene.seeds.at(group + ".location"), std::to_string(i)));
    const auto drawn = [&](double most) { return stream.Uniform(-most, most); };
    object.linear_velocity = {drawn(push), 0, drawn(push)};
    const double spin = push / settling.diameter;
    object.angular_velocity = {drawn(spin), drawn(spin), drawn(spin)};
  }
  return state;
}

/// Objects of which some point is faster than `slow`, m/s.
std::size_t Restless(const Settling& settling, const world::Engine& engine, double slow) {
  return static_cast<std::size_t>(std::ranges::count_if(settling.piled, [&](std::uint32_t i) {
    const btRigidBody& body = *engine.objects()[i];
    const double radius = settling.dropped.objects[i].solid.OuterRadius();
    const double fastest = world::ToEigen(body.getLinearVelocity()).norm() +
                           radius * world::ToEigen(body.getAngularVelocity()).norm();
    return !(fastest < slow);
  }));
}

/// Of the velocity is left after a unit of time: first most, so that objects find their places,
/// then less and less, so that nothing jitters. What is not held still falls.
double LeftAfterUnit(double units) {
  constexpr double kFirst = 0.7, kLess = 0.85, kLeast = 0.01;
  constexpr double kThicken = 20;  // units of time
  return std::max(kLeast, kFirst * std::pow(kLess, std::max(0.0, units - kThicken)));
}

void Damp(const Settling& settling, world::Engine& engine, double units) {
  const double left = std::pow(LeftAfterUnit(units), 1 / settling.UnitOfTime());  // after a second
  const auto damping = static_cast<btScalar>(1 - left);
  for (const std::uint32_t i : settling.piled) engine.objects()[i]->setDamping(damping, damping);
}

void ComeToRest(const Settling& settling, world::Engine& engine) {
  const double unit = settling.UnitOfTime();
  const double timestep = static_cast<double>(engine.timestep());
  const int steps_of_unit = static_cast<int>(std::ceil(unit / timestep));
  const double fall = std::sqrt(2 * engine.side() / settling.gravity);
  const double slow = kRestSpeed * std::sqrt(settling.gravity * settling.diameter);
  const auto few = static_cast<std::size_t>(kRestless * static_cast<double>(settling.piled.size()));
  std::size_t restless = 0;
  int checks = 0;
  for (double time = 0; time < kSettleTime * unit + fall; time += steps_of_unit * timestep) {
    Damp(settling, engine, time / unit);
    for (int i = 0; i < steps_of_unit; ++i) engine.Step();
    restless = Restless(settling, engine, slow);
    checks = restless <= few ? checks + 1 : 0;
    if (checks == kRestChecks) return;
  }
  throw SceneError(
      fmt::format("the pile does not come to rest: after {:.4g} s {} of {} objects still move; "
                  "more friction or "
                  "rolling_friction, or fewer objects, would help",
                  kSettleTime * unit + fall, restless, settling.piled.size()));
}

/// The dropped objects with the poses that they have in the engine.
InitialState StateOf(const Settling& settling, const world::Engine& engine) {
  InitialState state = settling.dropped;
  for (const std::uint32_t i : settling.piled)
    state.objects[i].pose = world::ToPose(engine.objects()[i]->getWorldTransform());
  return state;
}

/// Throws SceneError where objects overlap or reach through a wall.
void CheckClearance(const plan::Scene& scene, InitialState& state) {
  const layouts::Bodies bodies(scene, state);
  std::vector<std::uint32_t> all(state.objects.size());
  std::iota(all.begin(), all.end(), 0u);
  layouts::CheckClearance(bodies, all);
}

constexpr std::size_t kPoseSize = 7;  ///< place, and the turn's w, x, y, z

std::string PosesOf(const InitialState& state) {
  std::string bytes;
  for (const ObjectState& object : state.objects) {
    const Vector3d& place = object.pose.position;
    const Eigen::Quaterniond& turn = object.pose.orientation;
    const std::array<double, kPoseSize> pose = {place.x(), place.y(), place.z(), turn.w(),
                                                turn.x(),  turn.y(),  turn.z()};
    bytes.append(reinterpret_cast<const char*>(pose.data()), sizeof pose);
  }
  return bytes;
}

/// False, with nothing changed, where it is not what PosesOf wrote for as many objects.
bool TakePoses(std::string_view bytes, InitialState& state) {
  std::array<double, kPoseSize> pose;
  if (bytes.size() != state.objects.size() * sizeof pose) return false;
  for (ObjectState& object : state.objects) {
    std::memcpy(pose.data(), bytes.data(), sizeof pose);
    bytes.remove_prefix(sizeof pose);
    object.pose.position = {pose[0], pose[1], pose[2]};
    object.pose.orientation = {pose[3], pose[4], pose[5], pose[6]};
  }
  return true;
}

[[noreturn]] void Fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Before the poses; anything else is why there are none.
constexpr std::string_view kSettled = "settled\n";

/// What the other worker writes about the scene.
std::string AskDoubleWorker(const plan::Scene& scene) {
  const std::string program =
      (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "cdb-worker-f64").string();
  plan::Run run;
  run.scene = scene;
  run.id = plan::RunId(scene, run.rep);
  const std::string yaml = plan::RunToYaml(run);
  const int text = memfd_create("cdb-settle", MFD_CLOEXEC);
  if (text < 0) Fail("no memory to settle a pile");
  measure::WriteAll(text, yaml);
  if (lseek(text, 0, SEEK_SET) != 0) Fail("cannot settle a pile");
  int ends[2];
  if (pipe(ends) != 0) Fail("no pipe to settle a pile");
  // One thread alone, and nothing between fork and exec that could need a lock.
  const pid_t child = fork();
  if (child < 0) Fail("cannot start a worker to settle a pile");
  if (child == 0) {
    dup2(text, STDIN_FILENO);
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execl(program.c_str(), program.c_str(), kSettleOption, nullptr);
    _exit(127);
  }
  close(text);
  close(ends[1]);
  std::string answer = measure::ReadAll(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error(fmt::format("{} could not settle the pile", program));
  return answer;
}

InitialState Settled(const Settling& settling) {
  const plan::Scene quiet = QuietScene(settling);
  std::string overlap;
  for (const double growth : kSettleGrowth) {
    world::Engine engine(quiet, QuietState(settling, growth), pruning::KeepEverything(quiet));
    ComeToRest(settling, engine);
    InitialState settled = StateOf(settling, engine);
    try {
      CheckClearance(settling.scene, settled);
      return settled;
    } catch (const SceneError& error) {
      overlap = error.what();
    }
  }
  throw SceneError(fmt::format("the pile pressed its objects into one another: {}", overlap));
}

constexpr std::string_view kKind = "pile";
/// To be raised with everything here that changes where objects come to rest.
constexpr std::string_view kVersion = "1";

/// Of all that decides the poses.
std::string KeyOf(const Settling& settling) {
  plan::Run run;
  run.scene = QuietScene(settling);
  // These decide how long a run is and what it shows.
  for (const schema::WorldParameter parameter :
       std::initializer_list<schema::WorldParameter>{"cycles", "warmup", "timeout", "repeats"})
    run.scene.world.Erase(parameter);
  return library::CacheKeyOf(
      fmt::format("{}\nBullet {}\n{}\n{}{}", kVersion, btGetVersion(), meshes::DecomposerVersion(),
                  objects::ModelsText(settling.dropped.forms), plan::RunToYaml(run)));
}

}  // namespace

bool HasPile(const plan::Scene& scene) {
  return std::ranges::any_of(scene.groups, layouts::IsPile);
}

void SettlePiles(const plan::Scene& scene, InitialState& state) {
  const Settling settling = PrepareToSettle(scene, state);
  const std::filesystem::path folder = library::CacheFolder();
  const std::string key = KeyOf(settling);
  if (const auto kept = library::FindCached(folder, kKind, key))
    if (TakePoses(*kept, state)) return;
  if (std::string_view(world::EnginePrecision()) != "double") {
    const std::string answer = AskDoubleWorker(scene);
    if (!answer.starts_with(kSettled)) throw SceneError(answer);
    if (!TakePoses(std::string_view(answer).substr(kSettled.size()), state))
      throw std::runtime_error("the settled pile is not whole");
    return;
  }
  state = Settled(settling);
  library::StoreCached(folder, kKind, key, PosesOf(state));
}

void SettleForAnother(const plan::Run& run, int fd) {
  std::string answer(kSettled);
  try {
    InitialState state = layouts::MakeInitialState(run.scene);
    SettlePiles(run.scene, state);
    answer += PosesOf(state);
  } catch (const std::exception& error) {
    answer = error.what();
  }
  measure::WriteAll(fd, answer);
}

}  // namespace cdb::worker
