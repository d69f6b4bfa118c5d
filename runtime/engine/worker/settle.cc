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
#include <functional>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "compiler/yaml/plan_yaml.h"
#include "library/content_cache.h"
#include "library/distributions/draw.h"
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

/// While they drop, in least half extents: Bullet's margin, and the way that an object moves before
/// its contacts are found anew.
constexpr double kDropMargin = 0.008, kReuseTolerance = 0.005;
/// From this round on, a pile is at rest if less than this part of its objects moves, as objects
/// that roll find no rest without rolling friction. It is that of the verdict `collapsed`.
constexpr int kEnoughRounds = 4;
/// Up to this round, a pile is watched for kSleepSpan; from then on, for kRestSpan.
constexpr int kPatientRounds = 8;
constexpr double kRestlessPart = 0.01;
/// Times that objects are watched, for which those that moved then calm down.
constexpr int kMostCalm = 2;

/// The data shared by all stages.
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

/// `poses` with only the objects of the piles able to move, and without velocities.
InitialState QuietState(const Settling& settling, const InitialState& poses) {
  InitialState state = poses;
  for (ObjectState& object : state.objects) {
    object.mass = 0;
    object.is_kinematic = false;
  }
  for (const std::uint32_t i : settling.falling.objects) {
    ObjectState& object = state.objects[i];
    object.mass = poses.objects[i].mass;
    object.linear_velocity.setZero();
    object.angular_velocity.setZero();
  }
  return state;
}

/// Pushed to the side and spinning, without bounces.
InitialState PushedState(const Settling& settling) {
  InitialState state = QuietState(settling, settling.dropped);
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
    object.numbers.ForEach([](const schema::Parameter& parameter, double& number) {
      if (parameter.IsIgnoredBy(schema::Parameter::kDrop)) number = 0;
    });
    object.numbers["margin"] = kDropMargin * object.solid.LeastHalfExtent();
  }
  return state;
}

/// The objects with their poses in the engine.
InitialState StateOf(const Settling& settling, const world::Engine& engine) {
  InitialState state = settling.dropped;
  for (const std::uint32_t i : settling.falling.objects)
    state.objects[i].pose = world::ToPose(engine.objects()[i]->getWorldTransform());
  return state;
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

/// The answer of the worker of that precision about the scene.
std::string AskWorker(std::string_view precision, const plan::Scene& scene,
                      const SettlingListener& listener) {
  const std::string program = (std::filesystem::read_symlink("/proc/self/exe").parent_path() /
                               (precision == "double" ? "cdb-worker-f64" : "cdb-worker-f32"))
                                  .string();
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

std::vector<ContactReuse::Body> BodiesOf(const Settling& settling) {
  std::vector<ContactReuse::Body> bodies;
  for (const ObjectState& object : settling.dropped.objects)
    bodies.push_back(
        {object.solid.OuterRadius(), kReuseTolerance * object.solid.LeastHalfExtent()});
  return bodies;
}

/// The poses in which the objects lie after their fall.
InitialState Dropped(const Settling& settling) {
  plan::Scene scene = yaml::DropScene(settling.scene);
  scene.world.Set("timestep", settling.falling.DropTimestep());
  world::Engine engine(scene, PushedState(settling), omissions::KeepEverything(scene));
  FallDown(engine, settling.falling, BodiesOf(settling), [&](std::size_t at_rest) {
    settling.Tell(protocol::SettlingPhase::kSettling, at_rest);
  });
  return StateOf(settling, engine);
}

/// The poses from which nothing moves, in the engine of the run. Throws SceneError if there are
/// none.
InitialState Rested(const Settling& settling, InitialState state) {
  plan::Scene scene = yaml::RestScene(settling.scene);
  if (yaml::SharesPile(settling.scene)) scene.world.Set("timestep", settling.falling.Timestep());
  const std::size_t count = settling.falling.objects.size();
  const auto few =
      static_cast<std::size_t>(std::ceil(kRestlessPart * static_cast<double>(count))) - 1;
  const double calm = std::max(kRestSpan, settling.falling.UnitOfTime());
  double seconds = 0, steps = 0;
  for (int round = 0; round < kLeastRounds || (round < kMostRounds && steps < kMostSteps);
       ++round) {
    world::Engine engine(scene, QuietState(settling, state), omissions::KeepEverything(scene));
    // The first round closes the gaps that are left by the drop.
    const bool is_first = round == 0;
    const std::size_t permitted = is_first ? count : round >= kEnoughRounds ? few : 0;
    const double span = is_first || round >= kPatientRounds ? kRestSpan : kSleepSpan;
    const Unrest unrest = WatchUnrest(engine, settling.falling, span, permitted);
    settling.Tell(protocol::SettlingPhase::kSettling, count - unrest.restless.size());
    if (!is_first && unrest.moved.size() <= permitted) return state;
    const double rest = is_first ? 0 : std::min(round, kMostCalm) * calm;
    CalmDown(engine, settling.falling, BodiesOf(settling), rest, unrest.restless);
    state = StateOf(settling, engine);
    seconds += unrest.seconds + rest;
    steps += (unrest.seconds + rest) / static_cast<double>(engine.timestep());
  }
  if (scene.world.WordOr("expect") == "anything") return state;
  world::Engine engine(scene, QuietState(settling, state), omissions::KeepEverything(scene));
  const Unrest unrest = WatchUnrest(engine, settling.falling);
  throw SceneError(fmt::format(
      "the pile does not come to rest: after {:.3g} s, {} of {} objects still move, one "
      "by {:.2g} of its least side in {:.2g} s; Bullet may never hold it still with "
      "these settings: use a shorter timestep, more friction or rolling_friction, "
      "larger or fewer objects, or `expect anything` to begin with a pile that moves",
      seconds, unrest.moved.size(), count, unrest.way, unrest.seconds));
}

constexpr std::string_view kDropKind = "drop", kPileKind = "pile";
/// Increase it with every change here that affects where objects come to rest.
constexpr std::string_view kVersion = "11";

/// The numbers of the objects that determine the poses: settings of the group may be drawn, or
/// depend on others.
std::string NumbersOf(const InitialState& state, std::string_view kind) {
  std::string bytes;
  const auto add = [&](double number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  for (const ObjectState& object : state.objects) {
    add(object.mass);
    layouts::DrawnNumbers numbers = object.numbers;
    numbers.ForEach([&](const schema::Parameter& parameter, double number) {
      if (kind == kPileKind || !parameter.IsIgnoredBy(schema::Parameter::kDrop)) add(number);
    });
  }
  return bytes + PosesOf(state);
}

/// The cache key, from everything that determines the poses: the scene, the dropped objects, and
/// the programs.
std::string KeyOf(const Settling& settling, std::string_view kind) {
  return library::CacheKeyOf(fmt::format(
      "{}\nBullet {}\n{}\n{}\n{}{}\n{}", kVersion, btGetVersion(), __VERSION__,
      meshes::DecomposerVersion(), objects::ModelsText(settling.dropped.forms),
      kind == kPileKind ? yaml::PileText(settling.scene) : yaml::DropText(settling.scene),
      NumbersOf(settling.dropped, kind)));
}

std::optional<InitialState> Kept(const Settling& settling, std::string_view kind) {
  InitialState state = settling.dropped;
  const auto kept = library::FindCached(library::CacheFolder(), kind, KeyOf(settling, kind));
  if (kept && TakePoses(*kept, state)) return state;
  return std::nullopt;
}

/// Takes the result from the cache, or makes and stores it. Only one process makes it; others that
/// need it wait.
InitialState KeptOrMade(const Settling& settling, std::string_view kind,
                        const std::function<InitialState()>& make) {
  if (auto kept = Kept(settling, kind)) return *std::move(kept);
  const std::string key = KeyOf(settling, kind);
  const library::CacheLock lock(library::CacheFolder(), kind, key,
                                [&] { settling.Tell(protocol::SettlingPhase::kWaiting, 0); });
  if (auto kept = Kept(settling, kind)) return *std::move(kept);
  settling.Tell(protocol::SettlingPhase::kSettling, 0);
  const InitialState state = make();
  library::StoreCached(library::CacheFolder(), kind, key, PosesOf(state));
  return state;
}

/// The precision in which the piles come to rest.
std::string RestPrecision(const plan::Scene& scene) {
  return std::string(yaml::RestScene(scene).world.WordOr("precision"));
}

/// `kind`: the result that the worker of that precision is asked for.
InitialState KeptOrAsked(const Settling& settling, std::string_view kind,
                         std::string_view precision) {
  if (auto kept = Kept(settling, kind)) return *std::move(kept);
  const std::string answer = AskWorker(precision, settling.scene, settling.listener);
  if (!answer.starts_with(kSettled)) throw SceneError(answer);
  InitialState state = settling.dropped;
  if (!TakePoses(std::string_view(answer).substr(kSettled.size()), state))
    throw std::runtime_error("the settled pile is incomplete");
  return state;
}

InitialState AfterDrop(const Settling& settling) {
  if (std::string_view(world::EnginePrecision()) != "double")
    return KeptOrAsked(settling, kDropKind, "double");
  return KeptOrMade(settling, kDropKind, [&] { return Dropped(settling); });
}

}  // namespace

void SettlePiles(const plan::Scene& scene, InitialState& state, const SettlingListener& listener) {
  const InitialState dropped = state;
  Settling settling = PrepareToSettle(scene, dropped);
  settling.listener = listener;
  state = KeptOrAsked(settling, kPileKind, RestPrecision(scene));
}

void SettleForAnother(const plan::Run& run, int fd) {
  std::string answer(kSettled);
  try {
    const InitialState dropped = layouts::MakeInitialState(run.scene);
    Settling settling = PrepareToSettle(run.scene, dropped);
    settling.listener = [fd](const SettlingProgress& progress) {
      protocol::WriteAll(fd, ProgressLine(progress));
    };
    const bool rests_here = RestPrecision(run.scene) == world::EnginePrecision();
    answer += PosesOf(rests_here ? KeptOrMade(settling, kPileKind,
                                              [&] { return Rested(settling, AfterDrop(settling)); })
                                 : AfterDrop(settling));
  } catch (const std::bad_alloc&) {
    answer = kOutOfMemory;
  } catch (const std::exception& error) {
    answer = error.what();
  }
  protocol::WriteAll(fd, answer);
}

}  // namespace cdb::worker
