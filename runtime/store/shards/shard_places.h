// Finds the shards of a merge.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cdb::shards {

class ShardPlaces {
 public:
  /// `paths`: folders of shards, and single shards.
  explicit ShardPlaces(const std::vector<std::filesystem::path>& paths);

  /// The shard of the run in the first place that has it; nullopt if none has.
  std::optional<std::filesystem::path> Find(const std::string& run_id) const;

 private:
  struct Place {
    std::filesystem::path path;
    bool is_folder;
  };
  std::vector<Place> places_;
};

}  // namespace cdb::shards
