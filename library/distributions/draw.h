// Draws the values of a parameter: a constant gives itself, a distribution a new value each time
// from its random stream.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"
#include "compiler/schema/schema.h"
#include "library/distributions/stream.h"
#include "library/scene_error.h"

namespace cdb::distributions {

/// One parameter of a group or of the world. A number outside the domain of the parameter (a size
/// or a mass of 0 or less) or the limits of the distribution is drawn again, a vector component by
/// component. Not thread-safe; the scene must outlive it. Every call throws SceneError if
/// kMaxRedraws draws in a row are outside the domain. A schedule gives its values in order: each
/// Vector() of `every` is a new draw of its value; `rotating` gives the vector that it rotates.
/// `same` and `density` give a draw of their value.
class Draw {
 public:
  static constexpr int kMaxRedraws = 100000;

  /// Throws SceneError if the plan has no seed for a distribution.
  Draw(const plan::Scene& scene, schema::ParameterRef<false, schema::ValueKind::kDrawn> parameter)
      : Draw(scene, scene.world, {}, *parameter) {}
  Draw(const plan::Scene& scene, const plan::Group& group,
       schema::ParameterRef<true, schema::ValueKind::kDrawn> parameter)
      : Draw(scene, group.settings, group.name, *parameter) {}
  Draw(const plan::Scene& scene, const plan::Queries& queries,
       schema::ParameterRef<true, schema::ValueKind::kDrawn> parameter)
      : Draw(scene, queries.settings, queries.name, *parameter) {}
  /// For a parameter known only at run time; `group` is null for one of the world.
  Draw(const plan::Scene& scene, const plan::Group* group, const schema::Parameter& parameter)
      : Draw(scene,
             group != nullptr ? static_cast<const plan::Settings&>(group->settings) : scene.world,
             group != nullptr ? std::string_view(group->name) : std::string_view(), parameter) {}

  double Real();
  bool On();
  /// One of the choices as in the plan, a Word or a Call: `sphere`, `mesh("rock.obj", …)`.
  const schema::Value& Choice();
  /// A number if the parameter also takes words: empty if a word was drawn, which is stored in
  /// `word` (`mass fixed`).
  std::optional<double> RealOrWord(std::string_view* word);
  Eigen::Vector3d Vector();
  /// Empty if a word was drawn (`orientation random`).
  std::optional<Eigen::Vector3d> VectorOrWord(std::string_view* word);
  /// The stream of the draws, for values that a drawn word requires.
  Stream& stream() { return stream_; }

 private:
  /// `owner`: the name of the group or block, empty for the world.
  Draw(const plan::Scene& scene, const plan::Settings& settings, std::string_view owner,
       const schema::Parameter& parameter);
  const schema::Value& Choose();
  double RealFrom(const schema::Value& value, int component);
  /// True inside the domain of the parameter and the limits of the distribution.
  bool Accepts(const schema::Value& value, double real) const;
  double RealInDomain(const schema::Value& value, int component);
  [[noreturn]] void NeverInDomain() const;

  const schema::Parameter* parameter_;
  const schema::Value* value_;
  const schema::Distribution* distribution_;
  std::string name_;  ///< `pebbles.size`: name of the stream, and for messages
  Stream stream_;
};

/// The stream `group.parameter` of the scene, or `parameter` of the world if `group` is empty.
/// Throws SceneError if the plan has no seed for it.
Stream NamedStream(const plan::Scene& scene, std::string_view group, std::string_view parameter);

}  // namespace cdb::distributions
