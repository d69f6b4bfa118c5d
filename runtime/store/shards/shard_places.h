// Where the shards of a merge are.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cdb::shards {

class ShardPlaces {
 public:
  /// Folders of shards, and single shards.
  explicit ShardPlaces(const std::vector<std::filesystem::path>& paths);

  /// In the first place that has the run's shard; nullopt where none has.
  std::optional<std::filesystem::path> Find(const std::string& run_id) const;

 private:
  struct Place {
    std::filesystem::path path;
    bool is_folder;
  };
  std::vector<Place> places_;
};

}  // namespace cdb::shards
