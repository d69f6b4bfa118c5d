// `/provenance` of a merged file: facts of build and machine. One that is the same in every run is
// an attribute; one that differs is an array over `run`, the ids of the runs.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "runtime/store/hdf5/file.h"
#include "runtime/store/store.h"

namespace cdb::store {

class MergedProvenance {
 public:
  /// The facts of one run, by name.
  void Add(const std::string& run_id, const std::map<std::string, std::string>& facts);
  /// Makes the group. `of_merging`: facts of this process, used where no run has them.
  hdf5::Group Write(hdf5::File& file, const Provenance& of_merging) const;

 private:
  std::vector<std::string> ids_;
  std::map<std::string, std::vector<std::string>> facts_;  ///< as ids_; empty where it has none
};

}  // namespace cdb::store
