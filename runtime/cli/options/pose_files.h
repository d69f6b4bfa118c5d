// Tables of poses in HDF5 files: results with `record poses`, and files made by the user.
#pragma once

#include "compiler/schema/value.h"
#include "library/layouts/pose_table.h"

namespace cdb::options {

/// The table for a call in the plan. In a table from a results file, orientations refer to the
/// bodies' own axes and there are no velocities. Throws SceneError that names the file and the
/// remedy.
layouts::PoseTable ReadHdf5Poses(const schema::Call& poses);

}  // namespace cdb::options
