#include "runtime/store/shards/shard_places.h"

#include <algorithm>
#include <system_error>
#include <unordered_set>

#include "runtime/store/shards/shards.h"

namespace cdb::shards {
namespace {

namespace fs = std::filesystem;

}  // namespace

ShardPlaces::ShardPlaces(const std::vector<fs::path>& paths) {
  std::error_code error;
  for (const fs::path& path : paths) places_.push_back({path, fs::is_directory(path, error)});
}

std::optional<fs::path> ShardPlaces::Find(const std::string& run_id) const {
  const std::string name = run_id + ".h5";
  for (const Place& place : places_) {
    fs::path path = place.is_folder ? place.path / name : place.path;
    std::error_code error;
    if ((place.is_folder || path.filename() == name) &&
        fs::symlink_status(path, error).type() != fs::file_type::not_found)
      return path;
  }
  return std::nullopt;
}

bool HasAllShards(const plan::Plan& plan, const std::vector<fs::path>& shards) {
  std::unordered_set<std::string> names;
  for (const fs::path& place : shards) {
    std::error_code error;
    if (!fs::is_directory(place, error)) names.insert(place.filename().string());
    // Reading a folder also makes a network file system look for new files in it.
    for (fs::directory_iterator entry(place, error), end; !error && entry != end;
         entry.increment(error))
      names.insert(entry->path().filename().string());
  }
  const auto has = [&names](const std::string& id) { return names.contains(id + ".h5"); };
  bool has_all = true;
  plan.ForEachRun(
      [&](const std::string& id, const auto&, std::uint64_t) { has_all = has_all && has(id); });
  return has_all &&
         std::ranges::all_of(plan.references, [&](const plan::Run& run) { return has(run.id); });
}

}  // namespace cdb::shards
