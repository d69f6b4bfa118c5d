// The topics of `cdb doc`: the pages of the manual, with their generated parts.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cdb::help {

/// The page that lists the topics.
inline constexpr std::string_view kListOfTopics = "README";

std::vector<std::string_view> TopicNames();

/// The page of a topic, fitted to the terminal; empty if there is none of this name.
std::string TopicText(std::string_view name);

/// What a page marks by `<!-- NAME -->`: a table, made from those of the schema. Empty if there is
/// none of this name.
std::string GeneratedPart(std::string_view name);

}  // namespace cdb::help
