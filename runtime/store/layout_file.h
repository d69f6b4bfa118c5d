// A layout written into a file, and the attributes by which a file is known.
#pragma once

#include <string>
#include <string_view>

#include "compiler/plan/plan.h"
#include "runtime/store/hdf5/file.h"
#include "runtime/store/layout.h"

namespace cdb::store {

inline constexpr std::string_view kSchema = "cdb-results";
/// Raised when a reader of the version before would misunderstand a file.
inline constexpr int kSchemaVersion = 1;

/// Makes every dataset, with scales and attributes; coordinates are filled, arrays are not.
void CreateArrays(hdf5::File& file, const Layout& layout);

/// The attributes of the file itself. `what` is the line of `history`.
void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               const Layout& layout, std::string_view what);
/// Throws StoreError where `file` is not of this schema and version.
void CheckHead(const hdf5::File& file, const std::string& name);

}  // namespace cdb::store
