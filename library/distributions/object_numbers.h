// The numeric settings of an object: drawn, or evaluated from others of the same object.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/schema/formula.h"
#include "library/distributions/draw.h"

namespace cdb::distributions {

/// The settings of the objects of one group, one object after the other. Each setting has a
/// separate stream, so that the order of calls does not matter. Not thread-safe; the scene must
/// outlive it. Every call throws SceneError as Draw does, and if a formula gives no number in the
/// domain of its setting.
class ObjectNumbers {
 public:
  ObjectNumbers(const plan::Scene& scene, const plan::Group& group);

  /// Moves to the next object.
  void Next();
  /// m: size, for each side; without the aspect. 0 if it is native.
  Eigen::Vector3d Sides();
  /// m^3; must be set before a mass is computed from a density.
  void SetVolume(double volume) { volume_ = volume; }
  /// For a parameter of the group that draws numbers or switches (0 or 1), but not the size. Empty
  /// if a word was drawn (`mass fixed`, `contact_stiffness rigid`).
  std::optional<double> Find(const schema::Parameter& parameter) {
    return Find(SettingOf(parameter.name));
  }
  /// Empty if a number was drawn. Valid for the lifetime of the scene.
  std::string_view Word(const schema::Parameter& parameter);

 private:
  enum class State { kUnknown, kActive, kKnown };
  struct Setting {
    const schema::Parameter* parameter;
    Draw draw;
    const schema::Formula* formula;  ///< null if it is drawn
    bool is_same, is_density;
    State state = State::kUnknown;
    std::optional<double> number = {};
    std::string_view word = {};
  };

  Setting& SettingOf(std::string_view name);
  std::optional<double> Find(Setting& setting);
  std::optional<double> Make(Setting& setting);
  double Evaluated(const Setting& setting);
  double Side(Setting& size);
  double Named(std::string_view name);

  const plan::Group& group_;
  std::vector<Setting> settings_;
  std::optional<Eigen::Vector3d> sides_;
  std::optional<double> volume_;
  std::uint64_t count_ = 0;  ///< number of objects so far, including this one
};

}  // namespace cdb::distributions
