// Makes solids from the words of a scenario: closed forms by name, compounds from models and files.
//
// Errors: SceneError if a model or a file is missing, is not a solid or differs from the file at
// planning. Threads: one at a time for each factory. A mesh takes seconds the first time on a
// machine.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "compiler/analysis/model.h"
#include "compiler/schema/value.h"
#include "library/content_cache.h"
#include "library/objects/compound.h"
#include "library/objects/solid.h"

namespace cdb::objects {

/// Equal compounds of one factory are shared.
class SolidFactory {
 public:
  /// `type`: a constant value of `objects.type`, a word or a call. `size`: drawn for each side, m;
  /// `aspect` as in the scenario. The sides of a solid are size times aspect. At 1 : 1 : 1 a mesh
  /// keeps its own proportions, with its longest side equal to the size. A size of 0 is native.
  /// `exponents`: e1 and e2, which only superellipsoids have.
  Solid Make(const schema::Value& type, const Eigen::Vector3d& size, const Eigen::Vector3d& aspect,
             const Eigen::Vector2d& exponents = Eigen::Vector2d::Ones());
  /// The forms of all compounds made, in the order of their names.
  std::vector<std::shared_ptr<const ConvexDecomposition>> Forms() const;

 private:
  using CompoundKey = std::tuple<const ConvexDecomposition*, double, double, double>;
  std::map<std::string, std::shared_ptr<const ConvexDecomposition>>
      forms_;  ///< by the type as text
  std::map<CompoundKey, std::shared_ptr<const Compound>> compounds_;
};

/// m: the unit of the coordinates in the file of a call with the argument `unit`.
double MetresOfFile(const schema::Call& type);

/// True for a constant type whose pieces are made of a mesh, which may take seconds; a surface is
/// only read.
bool IsDecomposed(const schema::Value& type);

/// What ReadModel may do.
struct Reading {
  bool decomposes = true;  ///< otherwise a mesh that is not in the cache is only read and checked
  /// Called before each cut of a decomposition.
  std::function<void(const std::string& name, std::size_t pieces)> progress = {};
};

/// The facts about a type, as analysis::ReadModel.
std::optional<analysis::ModelFacts> ReadModel(const schema::Value& type, const Reading& reading,
                                              analysis::ModelFault& why);

/// ReadModel, for the compiler.
inline analysis::ReadModel ModelReader(const Reading& reading) {
  return [reading](const schema::Value& type, analysis::ModelFault& why) {
    return ReadModel(type, reading, why);
  };
}

/// `bunny: 9 hulls, volume error 1.9 %, IoU 0.930`, or `surface("hill.obj"): 800 triangles`, one
/// line per form.
std::string ModelsText(const std::vector<std::shared_ptr<const ConvexDecomposition>>& forms);

// Caches convex decompositions by all of their inputs.
//
// A form takes up to seconds to compute and a few kilobytes to store; a cached form is identical to
// the last bit. One process computes it while others that need it wait. Errors: those of `make`; a
// form that cannot be stored is not an error. Threads: any.

/// The result of `make`, or of an earlier call stored in `folder`, always with this `name`.
/// `source`: the inputs of `make` besides the code, such as the hash of a file.
ConvexDecomposition DecomposeOnce(std::string name, std::string_view source,
                                  const std::function<ConvexDecomposition()>& make,
                                  const std::filesystem::path& folder = library::CacheFolder());

/// The result of an earlier call.
std::optional<ConvexDecomposition> FindDecomposition(
    const std::string& name, std::string_view source,
    const std::filesystem::path& folder = library::CacheFolder());

/// 64 hex digits, a hash of the source, of DecomposerVersion and of the version of the code here.
std::string DecompositionKey(std::string_view source);

}  // namespace cdb::objects
