// The scenarios that `cdb new` writes: what falls, how many, and what is compared.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cdb::help {

/// A word that answers a question, with its meaning.
struct SceneWord {
  std::string_view word, doc;
};
/// What is compared: the templates. The first is the default, here and below.
std::span<const SceneWord> SceneTemplates();
/// What falls.
std::span<const SceneWord> SceneObjects();
/// The most objects of a first scene.
inline constexpr std::uint64_t kMostSceneObjects = 10'000;

struct SceneChoice {
  std::string compared, objects;  ///< words of the tables above
  std::uint64_t quantity = 0;     ///< 0: a default, with which all runs take seconds
};

/// The scenario, formatted, with one benchmark called `name`. `file`: its own name, as a word of a
/// command.
std::string SceneText(const SceneChoice& choice, const std::string& name, const std::string& file);

/// Asks three questions, each again until `read` returns an answer that can be used; an empty one
/// is the default. `read` prints a question and returns the answer, or nullopt at the end of the
/// input, and then the choice is nullopt.
std::optional<SceneChoice> AskForScene(
    const std::function<std::optional<std::string>(const std::string& question)>& read);

}  // namespace cdb::help
