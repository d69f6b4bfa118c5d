// A setting that the rest of a scene rules out.
#pragma once

#include <string>

#include "compiler/schema/schema.h"

namespace cdb::analysis {

struct SettingFault {
  std::string group;                   ///< empty for a parameter of the world
  const schema::Parameter* parameter;  ///< whose value is at fault
  std::string word = {};               ///< of a list
  std::string message, help;
};

}  // namespace cdb::analysis
