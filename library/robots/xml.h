// An XML file as a tree of elements with their lines, by pugixml.
//
// Only text that is well-formed (outline.h) is parsed. Errors: SceneError with the file, the line,
// the cause and the remedy. Threads: any.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "library/robots/builder.h"

namespace cdb::robots {

class XmlFile {
 public:
  XmlFile(const std::string& text, const std::string& path);

  pugi::xml_node root() const { return document_.document_element(); }
  std::size_t LineOf(const pugi::xml_node& node) const;
  [[noreturn]] void Fail(const pugi::xml_node& node, const std::string& cause,
                         const std::string& remedy) const;

  /// The numbers of `text`, which is of `node`: `least` to `most` of them, none of them NaN, and
  /// `what` for messages.
  std::vector<double> Numbers(const pugi::xml_node& node, std::string_view text,
                              const std::string& what, std::size_t least, std::size_t most) const;
  double Number(const pugi::xml_node& node, std::string_view text, const std::string& what) const {
    return Numbers(node, text, what, 1, 1)[0];
  }
  Eigen::Vector3d Vector(const pugi::xml_node& node, std::string_view text,
                         const std::string& what) const;
  /// `true`, `false`, 1 or 0.
  bool Flag(const pugi::xml_node& node, std::string_view text, const std::string& what) const;

 private:
  const std::string& path_;
  pugi::xml_document document_;
  std::vector<std::size_t> newlines_;
};

/// The elements of each parent that a reader takes.
using Taken = std::map<std::string_view, std::set<std::string_view>>;
/// Lists the others. What has parents that are not in the table is taken.
void LeaveOthers(const pugi::xml_node& node, const Taken& taken, RobotBuilder& builder);

}  // namespace cdb::robots
