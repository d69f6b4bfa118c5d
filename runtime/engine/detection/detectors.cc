#include "runtime/engine/detection/detectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <system_error>

#include "compiler/schema/catalogue.h"
#include "library/detectors/builtin/builtin.h"
#include "library/detectors/bullet/bullet.h"
#include "library/detectors/plugin.h"
#include "library/scene_error.h"
#include "runtime/engine/detection/plugin_detectors.h"

namespace cdb::detection {
namespace {

using detectors::LoadedDetector;
using library::SceneError;

const DetectorEntry* Find(std::span<const DetectorEntry> entries, std::string_view name) {
  const auto entry = std::ranges::find(entries, name, &DetectorEntry::name);
  return entry == entries.end() ? nullptr : &*entry;
}

/// The file of an optional part: as built, beside the worker; as installed, in the folder of
/// libraries.
std::string FileOf(const schema::DetectorPart& part) {
  const std::filesystem::path folder =
      std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::string file = fmt::format("cdb-detectors-{}.so", part.name);
  for (const char* place : {"detectors", CDB_INSTALLED_DETECTORS}) {
    std::error_code error;
    if (std::filesystem::exists(folder / place / file, error)) return folder / place / file;
  }
  return {};
}

std::optional<LoadedDetector> FindInPart(std::string_view name, std::string_view part_name) {
  const schema::DetectorPart* part = schema::FindDetectorPart(part_name);
  if (part == nullptr) return std::nullopt;
  const std::string file = FileOf(*part);
  if (file.empty())
    throw SceneError(fmt::format(
        "detector `{}` is in the module `{}`, which this cdb {}; {}", name, part->name,
        part->is_built ? "was built with but cannot find" : "was built without",
        part->is_built ? fmt::format("put cdb-detectors-{}.so into the folder detectors beside "
                                     "cdb-worker-f64, or install cdb again",
                                     part->name)
                       : fmt::format("install {} and build cdb again", part->package)));
  try {
    const auto all = detectors::LoadPlugin(file);
    const LoadedDetector* loaded = detectors::FindDetector(all, name);
    return loaded == nullptr ? std::nullopt : std::optional(*loaded);
  } catch (const detectors::PluginError& error) {
    throw SceneError(fmt::format("detector `{}`: {}", name, error.what()));
  }
}

std::optional<LoadedDetector> FindAnywhere(std::string_view name) {
  for (const auto entries : {builtin::BuiltinDetectors(), bullet::BulletDetectors()})
    if (const DetectorEntry* entry = Find(entries, name)) return LoadedDetector(*entry);
  const schema::DetectorInfo* info = schema::FindDetector(name);
  return info == nullptr ? std::nullopt : FindInPart(name, info->part);
}

}  // namespace

NamedDetector MakeDetector(std::string_view name, const plan::Scene& scene) {
  const Options options{static_cast<unsigned>(scene.world.Count("threads"))};
  const auto plugin = std::ranges::find(scene.plugins, name, &schema::PluginDetector::name);
  const bool is_plugin = plugin != scene.plugins.end();
  const auto index = static_cast<std::size_t>(plugin - scene.plugins.begin());
  const std::optional<LoadedDetector> loaded =
      is_plugin ? LoadPluginDetector(scene, index) : FindAnywhere(name);
  if (!loaded) throw SceneError(fmt::format("detector `{}` does not exist in this version", name));
  NamedDetector made{.name = std::string(name),
                     .phases = loaded->phases,
                     .max_bodies = loaded->max_bodies,
                     .detector = nullptr,
                     .lists_all_points = !is_plugin && schema::ListsAllPoints(name),
                     .threads = options.threads};
  const auto failed = [&](std::string_view why) {
    return SceneError(fmt::format("detector `{}` cannot be made: {}", name, why));
  };
  try {
    made.detector = is_plugin ? MakePluginDetector(index, *loaded, options) : loaded->make(options);
  } catch (const std::exception& error) {
    throw failed(error.what());
  } catch (...) {
    throw failed("it throws something other than a std::exception");
  }
  if (made.detector == nullptr) throw failed("its function returns nothing");
  return made;
}

NamedDetector MakeNarrowPhase(std::string_view name, const plan::Scene& scene) {
  NamedDetector narrow = MakeDetector(name, scene);
  if (!HasAny(narrow.phases, cdb::kNarrow))
    throw SceneError(fmt::format(
        "narrow_phase `{}` finds pairs but no contacts; choose another, or bullet", name));
  return narrow;
}

Detectors MakeDetectors(const plan::Scene& scene) {
  const std::string_view name = scene.world.WordOr("detector");
  const std::string_view narrow = scene.world.WordOr("narrow_phase");
  const bool own_contacts = narrow == "own" || narrow == name;
  if ((own_contacts || narrow == "bullet") && IsBullets(name)) return {};
  Detectors detectors;
  detectors.broad = MakeDetector(name, scene);
  if (!HasAny(detectors.broad.phases, cdb::kBroad))
    throw SceneError(fmt::format(
        "detector `{0}` finds contacts but no pairs; write it as `narrow_phase {0}`", name));
  if (own_contacts) {
    if (HasAny(detectors.broad.phases, cdb::kNarrow)) detectors.narrow = detectors.broad;
  } else if (narrow != "bullet") {
    detectors.narrow = MakeNarrowPhase(narrow, scene);
  }
  return detectors;
}

bool IsBullets(std::string_view detector) {
  return Find(bullet::BulletDetectors(), detector) != nullptr;
}

void Blame(const NamedDetector& detector, std::string_view in, std::uint64_t cycle) {
  const auto blamed = [&](std::string_view why) {
    return SceneError(fmt::format("detector `{}` failed in {}{}: {}", detector.name, in,
                                  cycle > 0 ? fmt::format(" of cycle {}", cycle) : "", why));
  };
  try {
    throw;
  } catch (const std::exception& error) {
    throw blamed(error.what());
  } catch (...) {
    throw blamed("it throws something other than a std::exception");
  }
}

void CheckHolds(std::string_view detector, std::uint64_t max_bodies, std::size_t bodies) {
  if (max_bodies == 0 || bodies <= max_bodies) return;
  throw SceneError(
      fmt::format("detector `{}` handles at most {} bodies, walls included, but this scene has {}; "
                  "choose another detector or fewer objects",
                  detector, max_bodies, bodies));
}

}  // namespace cdb::detection
