#include "library/robots/xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "library/robots/outline.h"
#include "library/scene_error.h"

namespace cdb::robots {

bool HasXml() { return true; }

XmlFile::XmlFile(const std::string& text, const std::string& path) : path_(path) {
  ReadOutline(text, path);
  for (std::size_t at = text.find('\n'); at != text.npos; at = text.find('\n', at + 1))
    newlines_.push_back(at);
  const pugi::xml_parse_result result =
      document_.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (result && document_.document_element()) return;
  throw library::SceneError(
      fmt::format("{}:{}: {}", path,
                  std::ranges::lower_bound(newlines_, static_cast<std::size_t>(std::max(
                                                          std::ptrdiff_t{0}, result.offset))) -
                      newlines_.begin() + 1,
                  result ? "has no elements" : result.description()),
      "is it an XML file?");
}

std::size_t XmlFile::LineOf(const pugi::xml_node& node) const {
  const auto offset = static_cast<std::size_t>(std::max(std::ptrdiff_t{0}, node.offset_debug()));
  return static_cast<std::size_t>(std::ranges::lower_bound(newlines_, offset) - newlines_.begin()) +
         1;
}

void XmlFile::Fail(const pugi::xml_node& node, const std::string& cause,
                   const std::string& remedy) const {
  throw library::SceneError(fmt::format("{}:{}: {}", path_, LineOf(node), cause), remedy);
}

std::vector<double> XmlFile::Numbers(const pugi::xml_node& node, std::string_view text,
                                     const std::string& what, std::size_t least,
                                     std::size_t most) const {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<double> numbers;
  for (std::size_t at = text.find_first_not_of(kBlanks); at != text.npos;
       at = text.find_first_not_of(kBlanks, at)) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    std::string_view word = text.substr(at, end - at);
    if (word.size() > 1 && word[0] == '+') word.remove_prefix(1);
    double number = 0;
    const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || rest != word.data() + word.size() || std::isnan(number))
      Fail(node, fmt::format("{} is '{}', which is no number", what, word), "write numbers");
    numbers.push_back(number);
    at = end;
  }
  if (numbers.size() < least || numbers.size() > most)
    Fail(node, fmt::format("{} has {} numbers", what, numbers.size()),
         least == most ? fmt::format("it takes {}", least)
                       : fmt::format("it takes {} to {}", least, most));
  return numbers;
}

Eigen::Vector3d XmlFile::Vector(const pugi::xml_node& node, std::string_view text,
                                const std::string& what) const {
  const std::vector<double> numbers = Numbers(node, text, what, 3, 3);
  const Eigen::Vector3d vector(numbers[0], numbers[1], numbers[2]);
  if (!IsInRange(vector))
    Fail(node, fmt::format("{} has numbers above 1e9", what), "the units are SI");
  return vector;
}

bool XmlFile::Flag(const pugi::xml_node& node, std::string_view text,
                   const std::string& what) const {
  constexpr std::string_view kBlanks = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  text = text.substr(0, text.find_last_not_of(kBlanks) + 1);
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  Fail(node, fmt::format("{} is '{}'", what, text), "write true or false");
}

void LeaveOthers(const pugi::xml_node& node, const Taken& taken, RobotBuilder& builder) {
  const auto row = taken.find(node.name());
  if (row == taken.end()) return;
  for (const pugi::xml_node& child : node.children()) {
    if (child.type() != pugi::node_element) continue;
    if (row->second.contains(child.name()))
      LeaveOthers(child, taken, builder);
    else
      builder.Leave(child.name());
  }
}

}  // namespace cdb::robots
