// Tables of poses in HDF5 files: results with `record poses`, and files of the user's own.
#pragma once

#include "compiler/schema/value.h"
#include "library/layouts/pose_table.h"

namespace cdb::options {

/// The table of a call of the plan. Of a results file, orientations are of the bodies' own axes and
/// there are no velocities. Throws SceneError that names the file and what to do.
layouts::PoseTable ReadHdf5Poses(const schema::Call& poses);

}  // namespace cdb::options
