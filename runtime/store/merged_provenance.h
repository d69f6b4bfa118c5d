// `/provenance` of a merged file: facts of build and machine. One that is the same in every run is
// an attribute; one that differs is an array over `run`, the ids of the runs.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/store/hdf5/file.h"
#include "runtime/store/store.h"

namespace cdb::store {

/// The dimension of the arrays in the group.
inline constexpr std::string_view kProvenanceRuns = "run";

class MergedProvenance {
 public:
  /// The facts of one run, by name.
  void Add(const std::string& run_id, const std::map<std::string, std::string>& facts);
  /// Makes the group. `of_merging`: facts of this process, used where no run has them.
  hdf5::Group Write(hdf5::File& file, const Provenance& of_merging) const;

 private:
  /// The texts of one fact, each once, and which of them each run has.
  struct Fact {
    std::vector<std::string> texts = {""};  ///< the first: of runs that have none
    std::vector<std::size_t> by_run;        ///< as ids_; runs at the end may be missing
    std::map<std::string, std::size_t> places = {{"", 0}};
  };

  std::vector<std::string> TextsOf(const Fact& fact) const;

  std::vector<std::string> ids_;
  std::map<std::string, Fact> facts_;
};

}  // namespace cdb::store
