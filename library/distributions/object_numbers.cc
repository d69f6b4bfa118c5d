#include "library/distributions/object_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"

namespace cdb::distributions {
namespace {

bool IsBy(std::string_view word, const schema::Value& value) {
  const schema::Call* call = schema::AsCall(value);
  return call != nullptr && call->name == word;
}

/// The formula of a value, also if it is the argument of same( ) or density( ).
const schema::Formula* FormulaIn(const schema::Value& value) {
  const bool has_word = IsBy("same", value) || IsBy("density", value);
  return schema::AsFormula(has_word ? schema::ArgumentOf(*schema::AsCall(value), "value") : value);
}

}  // namespace

ObjectNumbers::ObjectNumbers(const plan::Scene& scene, const plan::Group& group) : group_(group) {
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (!parameter.grouped || !parameter.distribution ||
        (parameter.type != schema::ParameterType::kReal &&
         parameter.type != schema::ParameterType::kSwitch))
      continue;
    const schema::Value& value = group.settings.ValueOf(parameter);
    settings_.push_back({&parameter, Draw(scene, &group, parameter), FormulaIn(value),
                         IsBy("same", value), IsBy("density", value)});
  }
}

void ObjectNumbers::Next() {
  ++count_;
  sides_.reset();
  volume_.reset();
  for (Setting& setting : settings_) setting.state = State::kUnknown;
}

ObjectNumbers::Setting& ObjectNumbers::SettingOf(std::string_view name) {
  const auto found = std::ranges::find(
      settings_, name, [](const Setting& setting) { return setting.parameter->name; });
  CDB_CHECK(found != settings_.end());
  return *found;
}

Eigen::Vector3d ObjectNumbers::Sides() {
  if (sides_) return *sides_;
  Setting& size = SettingOf("size");
  if (size.formula != nullptr || size.is_same) {
    sides_ = Eigen::Vector3d::Constant(Find(size).value_or(size.parameter->number_of_word));
  } else {
    // A constant size applies to every side; a distribution draws each side separately.
    const double x = Side(size), y = Side(size);
    sides_ = Eigen::Vector3d(x, y, Side(size));
    if (sides_->minCoeff() == 0 && !sides_->isZero(0))
      throw library::SceneError(
          fmt::format("`{}.size` draws each side separately, and only some are native",
                      group_.name),
          "write it in same()", group_.name, "size");
  }
  return *sides_;
}

double ObjectNumbers::Side(Setting& size) {
  std::string_view word;
  return size.draw.RealOrWord(&word).value_or(size.parameter->number_of_word);
}

std::string_view ObjectNumbers::Word(const schema::Parameter& parameter) {
  Setting& setting = SettingOf(parameter.name);
  Find(setting);
  return setting.word;
}

std::optional<double> ObjectNumbers::Find(Setting& setting) {
  if (setting.state == State::kKnown) return setting.number;
  if (setting.state == State::kActive)
    throw library::SceneError(
        fmt::format("`{}.{}` depends on itself; plan again", group_.name, setting.parameter->name));
  setting.state = State::kActive;
  setting.number = Make(setting);
  setting.state = State::kKnown;
  return setting.number;
}

std::optional<double> ObjectNumbers::Make(Setting& setting) {
  std::optional<double> number;
  setting.word = {};
  if (setting.formula != nullptr) {
    number = Evaluated(setting);
  } else if (setting.parameter->type == schema::ParameterType::kSwitch) {
    number = setting.draw.On() ? 1 : 0;
  } else if (setting.parameter->words.empty()) {
    number = setting.draw.Real();
  } else {
    number = setting.draw.RealOrWord(&setting.word);
  }
  if (!setting.is_density) return number;
  if (!volume_)
    throw library::SceneError(fmt::format(
        "`{0}.size` depends on `{0}.mass`, which a density gives; plan again", group_.name));
  return *number * *volume_;
}

double ObjectNumbers::Evaluated(const Setting& setting) {
  const double number =
      schema::Evaluate(*setting.formula, [this](std::string_view name) { return Named(name); });
  if (std::isfinite(number) && setting.parameter->domain.Contains(number)) return number;
  throw library::SceneError(
      fmt::format("the {} of object {} of `{}` must be {}, but {} is {}", setting.parameter->name,
                  count_, group_.name, setting.parameter->domain.Text(),
                  schema::FormulaText(*setting.formula),
                  std::isfinite(number) ? fmt::format("{:.6g}", number) : "no finite number"),
      "max() and min() keep a value within limits", group_.name,
      std::string(setting.parameter->name));
}

double ObjectNumbers::Named(std::string_view name) {
  Setting& setting = SettingOf(name);
  if (name == "size" && setting.formula == nullptr) {
    const Eigen::Vector3d sides = Sides();
    if (sides.isZero(0))
      throw library::SceneError(
          fmt::format("`{}.size` is native, which is not a number", group_.name),
          "remove it from the expressions of other settings", group_.name, std::string(name));
    if (sides.x() == sides.y() && sides.y() == sides.z()) return sides.x();
    throw library::SceneError(
        fmt::format("`{}.size` draws each side separately, so that an object has no single size",
                    group_.name),
        "write it in same()", group_.name, "size");
  }
  const auto number = Find(setting);
  if (number) return *number;
  throw library::SceneError(
      fmt::format("`{}.{}` is not a number for object {}", group_.name, name, count_),
      "remove it from the expressions of other settings", group_.name, std::string(name));
}

}  // namespace cdb::distributions
