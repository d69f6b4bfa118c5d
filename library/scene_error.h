// A scene that cannot be made: the message says in the user's words what is in the way and what to
// change. It becomes the run's message, with the status `failed`.
#pragma once

#include <stdexcept>

namespace cdb::library {

class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cdb::library
