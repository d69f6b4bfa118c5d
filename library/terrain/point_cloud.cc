// Point clouds, and the cells in which they lie.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "library/terrain/height_formats.h"
#include "library/terrain/voxel_formats.h"

namespace cdb::terrain {
namespace {

using Eigen::Vector3d;

constexpr const char* kSaveAgain = "save it again by pcl::io::savePCDFile, ascii or binary";

struct Field {
  std::string_view name;
  char type = '\0';  ///< 0: the header does not say
  std::uint64_t size = 0, count = 1;
};

struct PcdHeader {
  std::vector<Field> fields;
  std::optional<std::uint64_t> width, height, points;
  std::string_view data;
  std::size_t size = 0, lines = 0;  ///< bytes and lines of the header

  std::uint64_t BytesOfPoint() const {
    std::uint64_t bytes = 0;
    for (const Field& field : fields) bytes += field.size * field.count;
    return bytes;
  }
};

/// Takes the next word; empty at the end of the line.
std::string_view NextWord(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
  const std::string_view word = line.substr(0, std::min(line.find_first_of(" \t\r"), line.size()));
  line.remove_prefix(word.size());
  return word;
}

/// Takes the next line; false at the end.
bool NextLine(std::string_view& rest, std::string_view& line) {
  if (rest.empty()) return false;
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return true;
}

class PcdParser {
 public:
  PcdParser(std::string_view bytes, std::string_view name) : bytes_(bytes), name_(name) {}

  std::vector<Vector3d> Parse() {
    ReadHeader();
    for (int axis = 0; axis < 3; ++axis) FindAxis(axis);
    const std::uint64_t own = header_.width.value_or(0) * header_.height.value_or(1);
    count_ = header_.points.value_or(own);
    if (header_.points && header_.width && own != count_)
      RefuseFile(name_,
                 fmt::format("it has {} points, but {} by {} are {}", count_, *header_.width,
                             header_.height.value_or(1), own),
                 kSaveAgain);
    if (count_ == 0) RefuseFile(name_, "it has no points", "name another file");
    if (count_ > meshes::kMaxVertices)
      RefuseFile(name_,
                 fmt::format("it has {} points; the limit is {}", count_, meshes::kMaxVertices),
                 "take fewer, such as by pcl_voxel_grid");
    if (header_.data == "ascii")
      ReadText();
    else if (header_.data == "binary")
      ReadBinary();
    else
      RefuseLine(name_, header_.lines,
                 header_.data == "binary_compressed"
                     ? "binary_compressed data are not read"
                     : fmt::format("data are ascii or binary, not `{}`", header_.data),
                 "convert it: `pcl_convert_pcd_ascii_binary IN.pcd OUT.pcd 1`");
    RefuseBadPoints();
    return std::move(points_);
  }

 private:
  [[noreturn]] void RefuseHere(const std::string& cause) const {
    RefuseLine(name_, header_.lines, cause, kSaveAgain);
  }

  std::uint64_t CountIn(std::string_view word, std::uint64_t most) const {
    std::uint64_t count = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
    if (error != std::errc() || end != word.data() + word.size() || count > most)
      RefuseHere(fmt::format("`{}` is not a whole number up to {}", word, most));
    return count;
  }

  void ReadHeader() {
    constexpr std::uint64_t kMostBytes = 65536, kMostPoints = std::uint64_t{1} << 31;
    std::string_view rest = bytes_, line;
    while (header_.data.empty()) {
      if (!NextLine(rest, line)) RefuseFile(name_, "the header has no DATA", kSaveAgain);
      ++header_.lines;
      const std::string_view key = NextWord(line);
      if (key.empty() || key.starts_with('#')) continue;
      if (key == "FIELDS") {
        if (!header_.fields.empty()) RefuseHere("FIELDS has a line already");
        for (auto word = NextWord(line); !word.empty(); word = NextWord(line))
          header_.fields.push_back({word});
      } else if (key == "SIZE" || key == "TYPE" || key == "COUNT") {
        for (Field& field : header_.fields) {
          const std::string_view word = NextWord(line);
          if (key == "TYPE") {
            if (word != "F" && word != "I" && word != "U")
              RefuseHere(fmt::format("`{}` is not a type F, I or U", word));
            field.type = word[0];
          } else {
            (key == "SIZE" ? field.size : field.count) = CountIn(word, kMostBytes);
          }
        }
        if (!NextWord(line).empty()) RefuseHere(fmt::format("{} has more values than FIELDS", key));
      } else if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
        (key == "WIDTH"    ? header_.width
         : key == "HEIGHT" ? header_.height
                           : header_.points) = CountIn(NextWord(line), kMostPoints);
      } else if (key == "DATA") {
        header_.data = NextWord(line);
        if (header_.data.empty()) RefuseHere("DATA has no value");
      } else if (key != "VERSION" && key != "VIEWPOINT" && key != "COLUMNS") {
        RefuseHere(fmt::format("`{}` is not a key of a PCD header", key));
      }
    }
    header_.size = bytes_.size() - rest.size();
    for (const Field& field : header_.fields)
      if (field.type == '\0' || field.size == 0)
        RefuseFile(name_, fmt::format("its header has no TYPE and SIZE of `{}`", field.name),
                   kSaveAgain);
  }

  void FindAxis(int axis) {
    const char wanted = "xyz"[axis];
    std::size_t value = 0, byte = 0, found = 0;
    for (const Field& field : header_.fields) {
      if (field.name.size() == 1 && field.name[0] == wanted) {
        ++found;
        const bool is_float = field.type == 'F' && (field.size == 4 || field.size == 8);
        if (!is_float || field.count != 1)
          RefuseFile(name_,
                     fmt::format("its {} is not one number of type F and 4 or 8 bytes", wanted),
                     kSaveAgain);
        axes_[static_cast<std::size_t>(axis)] = {value, byte, field.size};
      }
      value += field.count;
      byte += field.size * field.count;
    }
    if (found != 1)
      RefuseFile(name_, fmt::format("FIELDS has `{}` {} times, not once", wanted, found),
                 kSaveAgain);
    values_ = value;
  }

  void ReadText() {
    std::string_view rest = bytes_.substr(header_.size), line;
    // A value takes two bytes, except the last one.
    if (count_ > (rest.size() + 1) / 2 / values_) RefuseCount((rest.size() + 1) / 2 / values_);
    points_.reserve(count_);
    std::size_t number = header_.lines;
    std::vector<double> values(values_);
    while (NextLine(rest, line)) {
      ++number;
      std::string_view word = NextWord(line);
      if (word.empty()) continue;
      if (points_.size() == count_)
        RefuseLine(name_, number, "more points than POINTS", kSaveAgain);
      for (double& value : values) {
        const std::optional<double> found = HeightIn(word);
        if (!found)
          RefuseLine(name_, number,
                     word.empty() ? fmt::format("fewer than {} values", values_)
                                  : fmt::format("`{}` is not a number", word),
                     kSaveAgain);
        value = *found;
        word = NextWord(line);
      }
      if (!word.empty())
        RefuseLine(name_, number, fmt::format("more than {} values", values_), kSaveAgain);
      points_.emplace_back(values[axes_[0].value], values[axes_[1].value], values[axes_[2].value]);
    }
    if (points_.size() != count_) RefuseCount(points_.size());
  }

  [[noreturn]] void RefuseCount(std::size_t found) const {
    RefuseFile(name_,
               fmt::format("its header says {} points, but there are {} at most", count_, found),
               "the file is truncated or damaged");
  }

  void ReadBinary() {
    const std::string_view data = bytes_.substr(header_.size);
    const std::uint64_t stride = header_.BytesOfPoint();
    if (stride > data.size() || data.size() != count_ * stride)
      RefuseFile(
          name_,
          fmt::format("it has {} bytes after its header, but {} points of {} bytes are {:.10g}",
                      data.size(), count_, stride,
                      static_cast<double>(count_) * static_cast<double>(stride)),
          "the file is truncated or damaged");
    points_.reserve(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      Vector3d point;
      for (std::size_t axis = 0; axis < 3; ++axis)
        point[static_cast<Eigen::Index>(axis)] =
            NumberAt(data, i * stride + axes_[axis].byte, axes_[axis].size);
      points_.push_back(point);
    }
  }

  /// Files are little-endian, as they come from such machines.
  static double NumberAt(std::string_view data, std::size_t at, std::size_t size) {
    std::uint64_t bits = 0;
    for (std::size_t i = size; i-- > 0;)
      bits = bits << 8 | static_cast<unsigned char>(data[at + i]);
    return size == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                     : std::bit_cast<double>(bits);
  }

  void RefuseBadPoints() const {
    const auto is_bad = [](const Vector3d& point) { return !point.allFinite(); };
    const auto bad = std::ranges::count_if(points_, is_bad);
    if (bad == 0) return;
    const auto first = std::ranges::find_if(points_, is_bad) - points_.begin();
    RefuseFile(name_,
               fmt::format("{} of {} points are not finite, the first is point {}", bad, count_,
                           first + 1),
               "remove them, such as by pcl::removeNaNFromPointCloud");
  }

  struct Axis {
    std::size_t value, byte, size;
  };

  std::string_view bytes_, name_;
  PcdHeader header_;
  std::array<Axis, 3> axes_ = {};
  std::size_t values_ = 0;  ///< of a point
  std::uint64_t count_ = 0;
  std::vector<Vector3d> points_;
};

}  // namespace

std::vector<Vector3d> PointsOfPcd(std::string_view bytes, std::string_view name) {
  return PcdParser(bytes, name).Parse();
}

VoxelGrid GridOf(const std::vector<Vector3d>& points, std::string_view name,
                 const VoxelOptions& options) {
  const double cell = GivenCell(name, options);
  Eigen::Array3d least = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d most = -least;
  for (const Vector3d& point : points) {
    const Eigen::Array3d at = (point.array() / cell).floor();
    least = least.min(at);
    most = most.max(at);
  }
  if (points.empty()) RefuseFile(name, "it has no points", "name another file");
  constexpr double kExact = 1e15;  // cells are whole numbers below it
  const Eigen::Array3d sides = most - least + 1;
  if (!(std::max(-least.minCoeff(), most.maxCoeff()) < kExact) ||
      sides.prod() > static_cast<double>(kMaxCells))
    RefuseFile(name,
               fmt::format("its points extend over {:.4g} x {:.4g} x {:.4g} m, which are {:.3g} "
                           "cells of {:g} m; the limit is {}",
                           sides.x() * cell, sides.y() * cell, sides.z() * cell, sides.prod(), cell,
                           kMaxCells),
               "make the cells larger, or remove points far from the others");
  std::array<std::uint64_t, 3> counts;
  for (std::size_t i = 0; i < 3; ++i)
    counts[i] = static_cast<std::uint64_t>(sides[static_cast<Eigen::Index>(i)]);
  VoxelGrid grid = EmptyGrid(counts, name);
  grid.cell = cell;
  grid.lower = (least * cell).matrix();
  std::vector<std::uint64_t> cells;
  cells.reserve(points.size());
  for (const Vector3d& point : points) {
    const Eigen::Array3d at = (point.array() / cell).floor() - least;
    cells.push_back(
        (static_cast<std::uint64_t>(at.z()) * counts[1] + static_cast<std::uint64_t>(at.y())) *
            counts[0] +
        static_cast<std::uint64_t>(at.x()));
  }
  std::ranges::sort(cells);
  std::uint64_t most_points = 0, solid = 0;
  for (auto first = cells.begin(); first != cells.end();) {
    const auto end = std::upper_bound(first, cells.end(), *first);
    const auto count = static_cast<std::uint64_t>(end - first);
    most_points = std::max(most_points, count);
    solid += count >= options.threshold;
    grid.solid[*first] = count >= options.threshold;
    first = end;
  }
  if (solid == 0)
    RefuseFile(name,
               fmt::format("no cell is solid: the most points in one are {}, the threshold {}",
                           most_points, options.threshold),
               fmt::format("for example `threshold: {}`, or larger cells", most_points));
  return grid;
}

VoxelGrid ReadPcd(std::string_view bytes, std::string_view name, const VoxelOptions& options) {
  return GridOf(PointsOfPcd(bytes, name), name, options);
}

VoxelGrid ReadPlyPoints(std::string_view bytes, std::string_view name,
                        const VoxelOptions& options) {
  return GridOf(meshes::ParseMesh(bytes, name).vertices, name, options);
}

}  // namespace cdb::terrain
