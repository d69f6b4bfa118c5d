#include "runtime/results/versions.h"

#include <fmt/format.h>

#include "runtime/results/layout.h"
#include "runtime/results/store.h"

namespace cdb::results {

int ReadVersion(const hdf5::File& file, const std::string& name) {
  if (file.Text("schema") != kSchema)
    throw files::StoreError(
        fmt::format("{}: is HDF5, but not a result of cdb; it was left as it is: "
                    "choose another file",
                    name));
  const double version = file.Number("schema_version");
  if (!(version >= kOldestSchemaVersion && version <= kSchemaVersion))
    throw files::StoreError(
        fmt::format("{}: is a result of schema version {}, and this cdb reads versions "
                    "{} to {}; it was left as it is: use the cdb that wrote it",
                    name, version, kOldestSchemaVersion, kSchemaVersion));
  return static_cast<int>(version);
}

std::string PathIn(int version, std::string_view path) {
  if (version == 1) {
    // Version 1 had the facts of a run in the root, where axes could collide with them.
    constexpr struct {
      std::string_view now, then;
    } kRenamed[] = {{"run/load_average", "load"},
                    {"accuracy/step_size", "accuracy/timestep"},
                    {"accuracy/reference/reference", "reference"}};
    for (const auto& [now, then] : kRenamed)
      if (path == now) return std::string(then);
    if (path.starts_with(kRunGroup)) path.remove_prefix(kRunGroup.size());
  }
  return std::string(path);
}

}  // namespace cdb::results
