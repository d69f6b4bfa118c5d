#include "runtime/engine/worker/settle.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <numeric>
#include <span>
#include <string>
#include <system_error>

#include "compiler/yaml/plan_yaml.h"
#include "library/content_cache.h"
#include "library/distributions/draw.h"
#include "library/layouts/bodies.h"
#include "library/layouts/clearance.h"
#include "library/layouts/exact_layouts.h"
#include "library/meshes/decompose.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "runtime/engine/worker/come_to_rest.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/file_descriptor_io.h"

namespace cdb::worker {
namespace {

using Eigen::Vector3d;
using layouts::InitialState;
using layouts::ObjectState;
using library::SceneError;

// As fractions of the growth of an object.
constexpr double kSettleMargin = 0.4, kReuseTolerance = 0.25;

/// The data shared by all tries.
struct Settling {
  const plan::Scene& scene;
  const InitialState& dropped;
  Falling falling = {};
  SettlingListener listener = {};  ///< may be empty

  void Tell(protocol::SettlingPhase phase, std::size_t at_rest) const {
    if (listener)
      listener({phase, static_cast<std::uint32_t>(at_rest),
                static_cast<std::uint32_t>(falling.objects.size())});
  }
};

Settling PrepareToSettle(const plan::Scene& scene, const InitialState& dropped) {
  Settling settling{scene, dropped};
  Falling& falling = settling.falling;
  for (std::size_t i = 0; i < dropped.objects.size(); ++i) {
    const ObjectState& object = dropped.objects[i];
    if (!layouts::IsPile(scene.groups[object.group])) continue;
    if (object.IsFixed())
      throw SceneError(
          fmt::format("the objects of group `{}` are fixed and cannot settle into a pile; give "
                      "them a mass, or another layout",
                      scene.groups[object.group].name));
    falling.objects.push_back(static_cast<std::uint32_t>(i));
    falling.diameter += 2 * object.solid.OuterRadius();
    falling.least_half_extent += object.solid.LeastHalfExtent();
  }
  falling.diameter /= static_cast<double>(falling.objects.size());
  falling.least_half_extent /= static_cast<double>(falling.objects.size());
  if (scene.world.WordOr("world.walls") == "none")
    throw SceneError("a pile needs a floor: set world.walls to floor or all");
  const Vector3d& g = dropped.acceleration;
  if (!(g.y() < 0) || std::hypot(g.x(), g.z()) > analysis::kMostTiltOfPiles * -g.y())
    throw SceneError(
        "a pile needs an acceleration that points down to the floor, such as (0, -9.8, 0)");
  falling.gravity = -g.y();
  return settling;
}

plan::Scene QuietScene(const Settling& settling, double growth) {
  plan::Scene scene = yaml::SettlingScene(settling.scene);
  scene.world.Set("timestep", settling.falling.Timestep(growth));
  return scene;
}

/// The objects without bounces; those outside the pile stand still.
InitialState QuietState(const Settling& settling) {
  InitialState state = settling.dropped;
  for (ObjectState& object : state.objects) {
    object.mass = 0;
    object.is_kinematic = false;
  }
  for (const std::uint32_t i : settling.falling.objects) {
    ObjectState& object = state.objects[i];
    object.mass = settling.dropped.objects[i].mass;
    object.numbers.ForEach([](const schema::Parameter& parameter, double& number) {
      if (parameter.IsIgnoredBy(schema::Parameter::kPile)) number = 0;
    });
  }
  return state;
}

/// Pushed to the side and spinning.
InitialState PushedState(const Settling& settling) {
  InitialState state = QuietState(settling);
  const Falling& falling = settling.falling;
  const double push = 0.5 * std::sqrt(falling.gravity * falling.diameter);
  for (const std::uint32_t i : falling.objects) {
    ObjectState& object = state.objects[i];
    const std::string& group = settling.scene.groups[object.group].name;
    // A stream for each object, so that its numbers do not depend on the other objects in the pile.
    distributions::Stream stream(
        plan::StreamSeed(settling.scene.seeds.at(group + ".location"), std::to_string(i)));
    const auto drawn = [&](double most) { return stream.Uniform(-most, most); };
    object.linear_velocity = {drawn(push), 0, drawn(push)};
    const double spin = push / falling.diameter;
    object.angular_velocity = {drawn(spin), drawn(spin), drawn(spin)};
  }
  return state;
}

/// Without motion, in the poses of `settled`.
InitialState RestingState(const Settling& settling, const InitialState& settled) {
  InitialState state = QuietState(settling);
  for (const std::uint32_t i : settling.falling.objects) {
    ObjectState& object = state.objects[i];
    object.pose = settled.objects[i].pose;
    object.linear_velocity.setZero();
    object.angular_velocity.setZero();
  }
  return state;
}

InitialState Enlarged(const Settling& settling, InitialState state, double growth) {
  std::map<const objects::Compound*, std::shared_ptr<const objects::Compound>> grown;
  for (const std::uint32_t i : settling.falling.objects) {
    ObjectState& object = state.objects[i];
    object.solid.sides *= growth;
    if (const auto& compound = settling.dropped.objects[i].solid.compound) {
      auto& shared = grown[compound.get()];
      if (shared == nullptr)
        shared =
            std::make_shared<const objects::Compound>(compound->shared_form(), object.solid.sides);
      object.solid.compound = shared;
    }
    // Corners rounded by Bullet's margin would sink into the object below.
    object.numbers["margin"] = kSettleMargin * (growth - 1) * object.solid.LeastHalfExtent();
  }
  return state;
}

/// All objects, with the sizes of `growth`.
std::vector<ContactReuse::Body> BodiesOf(const InitialState& state, double growth) {
  std::vector<ContactReuse::Body> bodies;
  for (const ObjectState& object : state.objects) {
    const objects::Solid& solid = object.solid;
    bodies.push_back(
        {growth * solid.OuterRadius(), kReuseTolerance * (growth - 1) * solid.LeastHalfExtent()});
  }
  return bodies;
}

/// The dropped objects with their poses in the engine.
InitialState StateOf(const Settling& settling, const world::Engine& engine) {
  InitialState state = settling.dropped;
  for (const std::uint32_t i : settling.falling.objects)
    state.objects[i].pose = world::ToPose(engine.objects()[i]->getWorldTransform());
  return state;
}

/// Throws SceneError if objects overlap or reach through a wall.
void CheckClearance(const plan::Scene& scene, InitialState& state) {
  const layouts::Bodies bodies(scene, state);
  std::vector<std::uint32_t> all(state.objects.size());
  std::iota(all.begin(), all.end(), 0u);
  layouts::CheckClearance(bodies, all);
}

constexpr std::size_t kPoseSize = 7;  ///< position, and w, x, y, z of the orientation

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

/// False, with nothing changed, if the bytes were not written by PosesOf for the same number of
/// objects.
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

/// Precedes the poses in an answer; any other text is an error message. Lines of progress come
/// before it.
constexpr std::string_view kSettled = "settled\n";
constexpr std::string_view kProgress = "progress ";
constexpr std::string_view kOutOfMemory = "out of memory\n";

std::string ProgressLine(const SettlingProgress& progress) {
  return fmt::format("{}{} {} {}\n", kProgress, static_cast<std::uint32_t>(progress.phase),
                     progress.at_rest, progress.objects);
}

/// Takes complete lines of progress from the front of `answer`.
void TakeProgress(std::string& answer, const SettlingListener& listener) {
  for (std::size_t end;
       answer.starts_with(kProgress) && (end = answer.find('\n')) != std::string::npos;
       answer.erase(0, end + 1)) {
    std::uint32_t phase = 0, at_rest = 0, objects = 0;
    if (std::sscanf(answer.c_str() + kProgress.size(), "%u %u %u", &phase, &at_rest, &objects) != 3)
      return;
    if (listener) listener({static_cast<protocol::SettlingPhase>(phase), at_rest, objects});
  }
}

/// Reads until the other end is closed, and returns the answer without the lines of progress.
std::string ReadAnswer(int fd, const SettlingListener& listener) {
  std::string answer;
  char buffer[4096];
  for (;;) {
    const ssize_t count = read(fd, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return answer;
    answer.append(buffer, static_cast<std::size_t>(count));
    TakeProgress(answer, listener);
  }
}

/// The answer of the double-precision worker about the scene.
std::string AskDoubleWorker(const plan::Scene& scene, const SettlingListener& listener) {
  const std::string program =
      (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "cdb-worker-f64").string();
  plan::Run run;
  run.scene = scene;
  run.id = plan::RunId(scene, run.rep);
  const std::string yaml = yaml::RunToYaml(run);
  const int text = memfd_create("cdb-settle", MFD_CLOEXEC);
  if (text < 0) Fail("no memory to settle a pile");
  protocol::WriteAll(text, yaml);
  if (lseek(text, 0, SEEK_SET) != 0) Fail("cannot settle a pile");
  int ends[2];
  if (pipe(ends) != 0) Fail("no pipe to settle a pile");
  // Single-threaded, and nothing between fork and exec needs a lock.
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) Fail("cannot start a worker to settle a pile");
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // is kept across exec
    if (getppid() != parent) _exit(127);
    dup2(text, STDIN_FILENO);
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execl(program.c_str(), program.c_str(), kSettleOption, nullptr);
    _exit(127);
  }
  close(text);
  close(ends[1]);
  std::string answer = ReadAnswer(ends[0], listener);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (answer == kOutOfMemory) throw std::bad_alloc();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error(fmt::format("{} could not settle the pile", program));
  return answer;
}

/// Where the objects come to rest from `start`, enlarged by the first of `growths` that keeps them
/// clear of one another. Throws SceneError if none does, or if they do not come to rest.
InitialState Rested(const Settling& settling, const InitialState& start,
                    std::span<const double> growths, int clearing_time) {
  InitialState rested;
  std::string overlap;
  for (const double growth : growths) {
    const plan::Scene quiet = QuietScene(settling, growth);
    world::Engine engine(quiet, Enlarged(settling, start, growth),
                         omissions::KeepEverything(quiet));
    const auto is_clear = [&] {
      rested = StateOf(settling, engine);
      try {
        CheckClearance(settling.scene, rested);
        return true;
      } catch (const SceneError& error) {
        overlap = error.what();
        return false;
      }
    };
    const auto tell = [&](std::size_t at_rest) {
      settling.Tell(protocol::SettlingPhase::kSettling, at_rest);
    };
    if (ComeToRest(engine, settling.falling, BodiesOf(settling.dropped, growth), clearing_time,
                   tell, is_clear))
      return rested;
  }
  throw SceneError(fmt::format("the objects of the pile penetrate one another: {}", overlap));
}

InitialState Settled(const Settling& settling) {
  InitialState settled =
      Rested(settling, PushedState(settling), kSettleGrowth, kSettleClearingTime);
  try {
    settled = Rested(settling, RestingState(settling, settled), kCloseGrowth, kCloseClearingTime);
  } catch (const SceneError&) {
    // The pile keeps its wider gaps.
  }
  return settled;
}

constexpr std::string_view kKind = "pile";
/// Increase it with every change here that affects where objects come to rest.
constexpr std::string_view kVersion = "5";

/// The numbers of the objects that determine the poses: settings of the group may be drawn, or
/// depend on others.
std::string NumbersOf(const InitialState& state) {
  std::string bytes;
  const auto add = [&](double number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  for (const ObjectState& object : state.objects) {
    add(object.mass);
    layouts::DrawnNumbers numbers = object.numbers;
    numbers.ForEach([&](const schema::Parameter& parameter, double number) {
      if (!parameter.IsIgnoredBy(schema::Parameter::kPile)) add(number);
    });
  }
  return bytes + PosesOf(state);
}

/// The cache key, from everything that determines the poses: the scene, the dropped objects, and
/// the programs.
std::string KeyOf(const Settling& settling) {
  return library::CacheKeyOf(
      fmt::format("{}\nBullet {}\n{}\n{}\n{}{}\n{}", kVersion, btGetVersion(), __VERSION__,
                  meshes::DecomposerVersion(), objects::ModelsText(settling.dropped.forms),
                  yaml::PileText(settling.scene), NumbersOf(settling.dropped)));
}

/// Takes the result from the cache, or makes and stores it. Only one process makes it; others that
/// need it wait.
InitialState FoundOrSettled(const Settling& settling, const std::filesystem::path& folder,
                            const std::string& key) {
  const library::CacheLock lock(folder, kKind, key,
                                [&] { settling.Tell(protocol::SettlingPhase::kWaiting, 0); });
  InitialState state = settling.dropped;
  if (const auto kept = library::FindCached(folder, kKind, key))
    if (TakePoses(*kept, state)) return state;
  settling.Tell(protocol::SettlingPhase::kSettling, 0);
  state = Settled(settling);
  library::StoreCached(folder, kKind, key, PosesOf(state));
  return state;
}

}  // namespace

void SettlePiles(const plan::Scene& scene, InitialState& state, const SettlingListener& listener) {
  const InitialState dropped = state;
  Settling settling = PrepareToSettle(scene, dropped);
  settling.listener = listener;
  const std::filesystem::path folder = library::CacheFolder();
  const std::string key = KeyOf(settling);
  if (const auto kept = library::FindCached(folder, kKind, key))
    if (TakePoses(*kept, state)) return;
  if (std::string_view(world::EnginePrecision()) != "double") {
    const std::string answer = AskDoubleWorker(scene, listener);
    if (!answer.starts_with(kSettled)) throw SceneError(answer);
    if (!TakePoses(std::string_view(answer).substr(kSettled.size()), state))
      throw std::runtime_error("the settled pile is incomplete");
    return;
  }
  state = FoundOrSettled(settling, folder, key);
}

void SettleForAnother(const plan::Run& run, int fd) {
  std::string answer(kSettled);
  try {
    InitialState state = layouts::MakeInitialState(run.scene);
    SettlePiles(run.scene, state, [fd](const SettlingProgress& progress) {
      protocol::WriteAll(fd, ProgressLine(progress));
    });
    answer += PosesOf(state);
  } catch (const std::bad_alloc&) {
    answer = kOutOfMemory;
  } catch (const std::exception& error) {
    answer = error.what();
  }
  protocol::WriteAll(fd, answer);
}

}  // namespace cdb::worker
