// Checks that the Bullet library at run time has the precision that this program was built for.
#pragma once

#include <string>

namespace cdb::world {

/// `single` or `double`: the precision that this program was built for.
const char* EnginePrecision();

/// Empty if they agree; otherwise an error message. Headers of one precision and a library of the
/// other link and run, but compute wrong numbers. Cheap; call it before any other function of
/// Bullet.
std::string PrecisionMismatch();

}  // namespace cdb::world
