// The usual causes of verdicts and of noise, and what to do about them (explanation.h).
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "runtime/manual/explanation.h"
#include "runtime/protocol/verdict.h"
#include "runtime/terminal/console.h"

namespace cdb::manual {
namespace {

struct Remedy {
  std::string_view name, causes, remedies;
};

constexpr Remedy kRemedies[] = {
    {"unknown", "`record` lacks stability, or the run was not executed.",
     "Record stability, as by default; `cdb run` executes missing runs."},
    {"stable", "", ""},
    {"drifting",
     "The time step is too long for the contacts or springs. Default contacts push overlaps apart "
     "and change rebounds. In a scene that must rest, it did not come to rest in its cycles. The "
     "solver does not "
     "converge in a chain of gears or joints, so that a motor misses its speed (motor_error).",
     "A shorter timestep; more solver.iterations; contact faithful for rebounds; more cycles for a "
     "scene that comes to rest late; precision double far from the origin."},
    {"penetrating",
     "The solver does not carry the load: a tall stack, heavy objects on light ones, something "
     "that presses, or small objects under a long time step. Joints of long chains give way.",
     "A shorter timestep; more solver.iterations; masses that differ less; larger objects; no "
     "overlap at the start."},
    {"collapsed",
     "A stack is too high for the time step and the iterations, or carries too heavy a load. "
     "Objects fell asleep before they were at rest.",
     "A shorter timestep; more solver.iterations; masses that differ less; sleeping off."},
    {"clamped",
     "Bullet limits the turn of a step to about a quarter of a circle: small or thin objects spin "
     "fast after an impact.",
     "A shorter timestep; larger or less elongated objects; angular_damping."},
    {"tunnelled",
     "An object moves farther in a step than it and the obstacle are thick: it is small, fast or "
     "thin, or falls from a height onto a thin slab.",
     "ccd on for the fast objects; a shorter timestep; thicker obstacles; larger or slower "
     "objects."},
    {"exploded",
     "Springs or links are too stiff for the time step, objects overlap deeply at the start, or "
     "something crushes them.",
     "A shorter timestep; softer springs; no overlap at the start; masses that differ less."},
    {"frozen",
     "Coordinates are so large that a motion of one step is lost by rounding: a large world, or a "
     "very short time step.",
     "precision double; a smaller world around the origin; a longer timestep."},
    {"removed",
     "An object left the scene, or is very large or fast: Bullet drops boxes beyond 1e6 m.",
     "Walls or a floor that keep the objects; fewer cycles; slower or smaller objects."},
    {"non_finite", "The simulation exploded, or a parameter is extreme.",
     "As for `exploded`; look at the first bad cycle with `cdb view`."},
    {"timed_out", "The run takes longer than its timeout.",
     "A longer timeout; fewer objects or cycles; `cdb plan --estimate` predicts times."},
    {"crashed", "The detector or the engine failed, or the run needs more memory than there is.",
     "The message of the run, in `cdb show`; another detector; fewer objects; `cdb run --only` "
     "repeats this run alone."},
    {"noisy",
     "Other programs, parallel runs (`--jobs`), or other virtual machines used the processor "
     "during the run, or its frequency changed. The times are then too long.",
     "Stop other programs; `cdb doctor` checks whether the machine is quiet. `cdb run FILE "
     "--retry-noisy 3` repeats a noisy run at once, `cdb run FILE --retry noisy` those of finished "
     "results. More repeats make the medians firmer."},
};

/// The criterion of `noisy`, which is not a verdict.
constexpr std::string_view kNoisy =
    "More than 2 % of the time was not spent on a processor, or other programs used a processor, "
    "or a few pauses dominate the mean.";

}  // namespace

std::string RemedyText(std::string_view name) {
  const auto row = std::ranges::find(kRemedies, name, &Remedy::name);
  if (row == std::end(kRemedies)) return {};
  const auto verdict = std::ranges::find(protocol::Verdicts(), name, &protocol::VerdictInfo::name);
  const bool is_verdict = verdict != protocol::Verdicts().end();
  std::string text =
      fmt::format("{} ({})\n{}", name, is_verdict ? "verdict on a run" : "disturbance of a run",
                  terminal::Wrapped(is_verdict ? verdict->doc : kNoisy, 2));
  if (!row->causes.empty())
    text += fmt::format("\nUSUAL CAUSES\n{}\nREMEDIES\n{}", terminal::Wrapped(row->causes, 2),
                        terminal::Wrapped(row->remedies, 2));
  return text + fmt::format("\nMore: cdb doc {}\n", is_verdict ? "verdicts" : "noise");
}

std::vector<std::string> RemedyNames() {
  std::vector<std::string> names;
  for (const Remedy& row : kRemedies) names.emplace_back(row.name);
  return names;
}

}  // namespace cdb::manual
