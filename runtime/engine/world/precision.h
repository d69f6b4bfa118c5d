// Whether the Bullet library that this program runs with has the precision that it was built for.
#pragma once

#include <string>

namespace cdb::world {

/// `single` or `double`: what this program was built for.
const char* EnginePrecision();

/// Empty where the library agrees; else what is wrong. Headers of one precision and a library of
/// the other link and run, with wrong numbers. Cheap; call it before anything else of Bullet.
std::string PrecisionMismatch();

}  // namespace cdb::world
