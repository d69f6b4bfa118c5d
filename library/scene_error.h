// A scene cannot be built. The message gives the cause and a remedy in the user's terms; it becomes
// the message of the run, with status `failed`.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace cdb::library {

class SceneError : public std::runtime_error {
 public:
  explicit SceneError(const std::string& cause) : std::runtime_error(cause), cause_(cause) {}
  /// `what()` is the cause and the remedy, separated by "; ". `group`: the name of the group of
  /// objects at fault, `parameter`: of its setting; empty if no single one is.
  SceneError(const std::string& cause, const std::string& remedy, std::string group = {},
             std::string parameter = {})
      : std::runtime_error(remedy.empty() ? cause : cause + "; " + remedy),
        cause_(cause),
        remedy_(remedy),
        group_(std::move(group)),
        parameter_(std::move(parameter)) {}

  const std::string& cause() const { return cause_; }
  const std::string& remedy() const { return remedy_; }  ///< empty if the cause implies it
  const std::string& group() const { return group_; }
  const std::string& parameter() const { return parameter_; }

 private:
  std::string cause_, remedy_, group_, parameter_;
};

}  // namespace cdb::library
