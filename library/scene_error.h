// A scene cannot be built. The message names the cause and a remedy in the user's terms; it becomes
// the message of the run, with status `failed`.
#pragma once

#include <stdexcept>

namespace cdb::library {

class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cdb::library
