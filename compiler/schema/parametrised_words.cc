#include "compiler/schema/parametrised_words.h"

#include <algorithm>

#include "compiler/schema/parameter_table.h"
#include "dsl/text/check.h"

namespace cdb::schema {
namespace {

using enum ParameterType;

constexpr Domain kAny = ParameterTable::kAny;
constexpr Domain kPositive = ParameterTable::kPositive;
constexpr Domain kNotNegative = ParameterTable::kNotNegative;
constexpr Domain kNotZero = {.not_zero = true};
constexpr Domain kCountFromZero = ParameterTable::kCountFromZero;
constexpr Domain kCountFromOne = ParameterTable::kCountFromOne;
/// Ropes and cloths take about 300 bytes for each node.
constexpr Domain kCells = {.min = 1, .max = 10000};
constexpr Domain kBlockCells = {.min = 1, .max = 1000};
constexpr Domain kSoftCells = {.min = 2, .max = 200};
constexpr Domain kHulls = {.min = 1, .max = 1024};
constexpr Domain kFraction = {.min = 0, .max = 1};

struct ArgumentOptions {
  std::string_view first_default = {};
  std::string_view words = {};
  bool distribution = false;
  WordSource word_source = WordSource::kOwn;
  bool omitted_at_default = false;
  std::string_view calls = {};
  bool is_formula = false;
};

constexpr Parameter Argument(std::string_view name, ParameterType type, Domain domain,
                             std::string_view unit, std::string_view doc,
                             ArgumentOptions options = {}) {
  Parameter parameter;
  parameter.name = name;
  parameter.type = type;
  parameter.domain = domain;
  parameter.distribution = options.distribution;
  parameter.unit = unit;
  parameter.first_default = options.first_default;
  parameter.words = options.words;
  parameter.word_source = options.word_source;
  parameter.doc = doc;
  parameter.omitted_at_default = options.omitted_at_default;
  parameter.calls = options.calls;
  parameter.is_formula = options.is_formula;
  return parameter;
}

constexpr ArgumentOptions kAGroup = {.word_source = WordSource::kGroups};
constexpr ArgumentOptions kFit = {.first_default = "fit", .words = "fit"};

// clang-format off
constexpr Parameter kGrid[] = {
    Argument("spacing", kReal, kPositive, "m", "between centres; fit distributes them over the cube", kFit)};
constexpr Parameter kStack[] = {
    Argument("height", kCount, kCountFromOne, "", "objects in a column; all puts them into one column", {.first_default = "all", .words = "all"}),
    Argument("gap", kReal, kNotNegative, "m", "between surfaces; 0 lets them touch; fit is a thousandth of the larger object's height", kFit),
    Argument("spacing", kReal, kPositive, "m", "between the columns' centres; fit is 1.5 times the widest object", kFit)};
constexpr Parameter kPyramid[] = {
    Argument("gap", kReal, kNotNegative, "m", "between surfaces; 0 lets them touch; fit is a thousandth of the largest extent", kFit)};
constexpr Parameter kPile[] = {
    Argument("width", kReal, kPositive, "m", "of the square above which they are dropped; fit drops them from a lattice about as wide as tall, and they spread where no walls hold them", kFit)};
constexpr Parameter kRing[] = {
    Argument("radius", kReal, kPositive, "m", "of the centres; fit leaves a tenth of the largest extent between neighbours", kFit)};
constexpr Parameter kLine[] = {
    Argument("gap", kReal, kAny, "m", "between surfaces along the line; fit is a tenth of the largest extent", kFit),
    Argument("along", kVector, kNotZero, "", "direction from the first to the last; down is (0, -1, 0)", {.first_default = "down", .words = "down"})};
constexpr Parameter kAt[] = {
    Argument("x", kReal, kAny, "m", "of the centre of mass"),
    Argument("y", kReal, kAny, "m", "of the centre of mass"),
    Argument("z", kReal, kAny, "m", "of the centre of mass")};
constexpr Parameter kPair[] = {
    Argument("distance", kReal, kNotNegative, "m", "between the surfaces; 0 lets them touch")};
constexpr Parameter kColumns = Argument("columns", kText, kAny, "", "which columns to read, such as \"x=pos.x [mm], y=#3\"; others are ignored; own: x, y, z and so on, with no others", {.first_default = "own", .words = "own", .omitted_at_default = true});
constexpr Parameter kRotation = Argument("rotation", kWord, kAny, "", "the meaning of columns rx, ry, rz (or roll, pitch, yaw): angles about the axes in this order, each about the turned (intrinsic) or the fixed (extrinsic) axes, or an axis times an angle (vector)", {.first_default = "none", .words = "none intrinsic_xyz intrinsic_xzy intrinsic_yxz intrinsic_yzx intrinsic_zxy intrinsic_zyx extrinsic_xyz extrinsic_xzy extrinsic_yxz extrinsic_yzx extrinsic_zxy extrinsic_zyx vector", .omitted_at_default = true});
constexpr Parameter kUp = Argument("up", kWord, kAny, "", "the vertical axis of the file; z turns its coordinates (x, y, z) to (x, z, -y)", {.first_default = "y", .words = "y z", .omitted_at_default = true});
constexpr Parameter kSeparator = Argument("separator", kWord, kAny, "", "between the columns of a text file", {.first_default = "auto", .words = "auto comma semicolon tab spaces", .omitted_at_default = true});
constexpr Parameter kDecimal = Argument("decimal", kWord, kAny, "", "the decimal sign in a text file", {.first_default = "auto", .words = "auto point comma", .omitted_at_default = true});
constexpr Parameter kHeader = Argument("header", kCount, kCountFromOne, "", "the line of the headings in a text file; the lines before it are ignored", {.first_default = "auto", .words = "auto none", .omitted_at_default = true});
constexpr Parameter kPoses[] = {
    Argument("file", kText, kAny, "", "CSV or other text, or HDF5, relative to the .cdb file"),
    Argument("sha256", kText, kAny, "", "of the file, or of the values of an HDF5 file; a different file is refused", {.first_default = "any", .words = "any"}),
    Argument("cycle", kCount, kCountFromZero, "", "for a results file: the cycle after which the poses are taken", {.first_default = "last", .words = "last"}),
    Argument("run", kText, kAny, "", "for a results file: the run, such as \"detector=dbvt, quantity=100\"; only requires that the file has a single run", {.first_default = "only", .words = "only"}),
    Argument("group", kText, kAny, "", "for a results file: the group of the objects", {.first_default = "all", .words = "all"}),
    kColumns, kRotation, kUp, kSeparator, kDecimal, kHeader};
constexpr Parameter kPath[] = {
    Argument("file", kText, kAny, "", "CSV or other text, or HDF5, relative to the .cdb file"),
    Argument("sha256", kText, kAny, "", "of the file, or of the values of an HDF5 file; a different file is refused", {.first_default = "any", .words = "any"}),
    Argument("then", kWord, kAny, "", "after the last line: stay there, or repeat from the first", {.first_default = "stay", .words = "stay repeat"}),
    Argument("start", kWord, kAny, "", "the time that is 0 s in the run: that of the file, or that of its first line", {.first_default = "zero", .words = "zero first", .omitted_at_default = true}),
    kColumns, kRotation, kUp, kSeparator, kDecimal, kHeader};
constexpr Parameter kList[] = {
    Argument("file", kText, kAny, "", "CSV or other text, relative to the .cdb file: a line for each configuration, a column for each joint, in rad and m"),
    Argument("sha256", kText, kAny, "", "of the file; a different file is refused", {.first_default = "any", .words = "any"}),
    kSeparator, kDecimal, kHeader};
constexpr Parameter kEmpirical[] = {
    Argument("file", kText, kAny, "", "CSV or other text, relative to the .cdb file"),
    Argument("column", kText, kAny, "", "the column of the values: its heading, or its number such as \"#2\"; a unit may follow: \"size [mm]\"", {.first_default = "first", .words = "first"}),
    Argument("weight", kText, kAny, "", "the column of the weights", {.first_default = "none", .words = "none"}),
    kSeparator, kDecimal, kHeader};
constexpr ParametrisedWord kEmpiricalWord = {"empirical", "one of the measured values of a file", kEmpirical};
constexpr Parameter kBox[] = {
    Argument("lower", kVector, kAny, "m", "the corner with the least coordinates"),
    Argument("upper", kVector, kAny, "m", "the corner with the largest coordinates")};
constexpr Parameter kAbove[] = {
    Argument("group", kWord, kAny, "", "a group written before this one, with objects", kAGroup),
    Argument("height", kReal, kPositive, "m", "of the box; fit reaches up to the ceiling", kFit)};
constexpr Parameter kBeside[] = {
    Argument("group", kWord, kAny, "", "a group written before this one, with objects", kAGroup),
    Argument("towards", kVector, kNotZero, "", "along one axis: the side of the group; right is (1, 0, 0)", {.first_default = "right", .words = "right"}),
    Argument("width", kReal, kPositive, "m", "of the box; fit reaches up to the wall", kFit)};
constexpr Parameter kOnTop[] = {
    Argument("group", kWord, kAny, "", "a group written before this one, with objects", kAGroup)};
constexpr Parameter kRelative[] = {
    Argument("group", kWord, kAny, "", "a group written before this one, with as many objects or a single one", kAGroup),
    Argument("offset", kVector, kAny, "m", "from its object to that of this group, in the frame of its object")};
constexpr Parameter kModelFile = Argument("file", kText, kAny, "", "OBJ, PLY, STL, OFF or a format of other programs, relative to the .cdb file");
constexpr Parameter kModelHash = Argument("sha256", kText, kAny, "", "of the file; a different file is refused", {.first_default = "any", .words = "any"});
constexpr Parameter kModelUnit = Argument("unit", kWord, kAny, "", "of the coordinates in the file, for `size native`", {.first_default = "m", .words = "m cm mm in", .omitted_at_default = true});
constexpr Parameter kModelOrigin = Argument("origin", kWord, kAny, "", "the point that at( ), poses( ) and path( ) place: the centre of mass, the origin of the file or the middle of the box", {.first_default = "mass", .words = "mass file box", .omitted_at_default = true});
constexpr Parameter kMesh[] = {
    kModelFile, kModelHash, kModelUnit, kModelOrigin,
    Argument("hulls", kCount, kHulls, "", "the largest number of convex hulls; fit is 40, or fewer if the error allows", {.first_default = "fit", .words = "fit", .omitted_at_default = true}),
    Argument("error", kReal, kPositive, "", "admissible volume of the hulls outside the mesh, relative to that of the mesh; fit is 0.04", {.first_default = "fit", .words = "fit", .omitted_at_default = true}),
    Argument("parts", kWord, kAny, "", "cut decomposes the mesh; given takes the parts of the file, which must be convex, as the hulls", {.first_default = "cut", .words = "cut given", .omitted_at_default = true}),
    Argument("iou", kReal, kFraction, "", "the least admissible IoU of hulls and mesh: their common volume divided by the volume of their union; fit is 0.5", {.first_default = "fit", .words = "fit", .omitted_at_default = true})};
constexpr Parameter kModel[] = {kModelFile, kModelHash, kModelUnit, kModelOrigin};
constexpr Parameter kSurface[] = {
    kModelFile, kModelHash, kModelUnit,
    Argument("origin", kWord, kAny, "", "the point that at( ), poses( ) and path( ) place: the middle of the box or the origin of the file", {.first_default = "box", .words = "box file", .omitted_at_default = true})};
constexpr Parameter kHeights[] = {
    Argument("file", kText, kAny, "", "CSV, ESRI grid (.asc), grey PNG, GeoTIFF (.tif) or SRTM (.hgt), relative to the .cdb file: rows of heights along x, which follow each other along z"),
    Argument("sha256", kText, kAny, "", "of the file; a different file is refused", {.first_default = "any", .words = "any"}),
    Argument("cell", kReal, kPositive, "", "distance between neighbouring heights, in the unit of the heights; unit is that of the file, or 1", {.first_default = "unit", .words = "unit"}),
    Argument("scale", kVector, kNotZero, "m", "of a cell along x, of one unit of height, and of a cell along z; instead of cell", {.first_default = "file", .words = "file", .omitted_at_default = true}),
    Argument("no_data", kReal, kAny, "", "the height where the file has none, in its unit; lowest is that of the file, refuse is an error", {.first_default = "refuse", .words = "refuse lowest", .omitted_at_default = true})};
constexpr Parameter kCellOfGround = Argument("cell", kReal, kPositive, "m", "the largest distance between points at which the formula is evaluated, along each axis");
constexpr Parameter kHeight[] = {
    Argument("formula", kReal, kAny, "", "the height in m over the place x, z in m: 0.2 * sin(3 * x) * cos(2 * z)", {.words = "x z", .is_formula = true}),
    Argument("width", kReal, kPositive, "m", "along x, with the origin of the formula in the middle"),
    kCellOfGround,
    Argument("depth", kReal, kPositive, "m", "along z; the default is the width", {.first_default = "width", .words = "width", .omitted_at_default = true})};
constexpr Parameter kImplicit[] = {
    Argument("formula", kReal, kAny, "", "negative inside, of the place x, y, z in m: sqrt(x^2 + y^2) - 1", {.words = "x y z", .is_formula = true}),
    Argument("lower", kVector, kAny, "m", "the corner of the box with the least coordinates"),
    Argument("upper", kVector, kAny, "m", "the corner of the box with the largest coordinates"),
    kCellOfGround};
constexpr Parameter kVoxels[] = {
    Argument("file", kText, kAny, "", "raw bytes (.raw), .binvox, NumPy (.npy), or a point cloud (.ply, .pcd), relative to the .cdb file"),
    Argument("sha256", kText, kAny, "", "of the file; a different file is refused", {.first_default = "any", .words = "any"}),
    Argument("up", kWord, kAny, "", "the vertical axis of the file, which must be stated; z turns its coordinates (x, y, z) to (x, z, -y)", {.first_default = "unstated", .words = "unstated y z"}),
    Argument("cell", kReal, kPositive, "m", "the side of a cell; file is that of a .binvox file", {.first_default = "file", .words = "file"}),
    Argument("columns", kCount, kCountFromOne, "", "of a .raw file: cells along its x, whose bytes follow each other", {.first_default = "file", .words = "file", .omitted_at_default = true}),
    Argument("rows", kCount, kCountFromOne, "", "of a .raw file: cells along its y", {.first_default = "file", .words = "file", .omitted_at_default = true}),
    Argument("layers", kCount, kCountFromOne, "", "of a .raw file: cells along its z", {.first_default = "file", .words = "file", .omitted_at_default = true}),
    Argument("threshold", kCount, kCountFromOne, "", "a cell is solid from this value, or this number of points, on", {.first_default = "one", .words = "one", .omitted_at_default = true}),
    Argument("origin", kWord, kAny, "", "the point that at( ) and poses( ) place: the middle of the box of the solid cells or the origin of the file", {.first_default = "box", .words = "box file", .omitted_at_default = true})};
constexpr Parameter kPart[] = {
    Argument("type", kWord, kAny, "", "a closed form, or a mesh or its hull", {.words = "sphere cuboid cylinder cone capsule tetrahedron", .calls = "mesh hull"}),
    Argument("sides", kVector, kPositive, "m", "full extents along its own x, y and z; native are those of the mesh", {.first_default = "native", .words = "native", .omitted_at_default = true}),
    Argument("at", kVector, kAny, "m", "its centre of mass, or the origin of its mesh, in the frame of the compound", {.first_default = "origin", .words = "origin", .omitted_at_default = true}),
    Argument("turn", kVector, kAny, "rad", "of its axes: an axis times an angle", {.first_default = "none", .words = "none", .omitted_at_default = true}),
    Argument("scale", kVector, kNotZero, "", "factors of its x, y and z, before it is turned; negative ones mirror it", {.first_default = "none", .words = "none", .omitted_at_default = true})};
constexpr Parameter kCompound[] = {
    Argument("centre", kVector, kAny, "m", "of mass, in the frame of the compound; fit is that of the parts with equal density", {.first_default = "fit", .words = "fit", .omitted_at_default = true}),
    Argument("inertia", kVector, kPositive, "m^2", "moments of inertia ixx, iyy, izz about the centre of mass, along the axes of the compound, for a mass of 1 kg; fit is that of the parts with equal density", {.first_default = "fit", .words = "fit", .omitted_at_default = true}),
    Argument("products", kVector, kAny, "m^2", "ixy, ixz, iyz of the same tensor", {.first_default = "none", .words = "none", .omitted_at_default = true})};
constexpr Parameter kRope[] = {
    Argument("segments", kCount, kCells, "", "links between its nodes, which are one more")};
constexpr Parameter kCloth[] = {
    Argument("columns", kCount, kCells, "", "rectangles along x, each of two triangles"),
    Argument("rows", kCount, kCells, "", "rectangles along z")};
constexpr Parameter kBlock[] = {
    Argument("columns", kCount, kBlockCells, "", "cells along x, each of five tetrahedra"),
    Argument("rows", kCount, kBlockCells, "", "cells along z"),
    Argument("layers", kCount, kBlockCells, "", "cells along y")};
constexpr Parameter kSoft[] = {
    kModelFile, kModelHash,
    Argument("cells", kCount, kSoftCells, "", "of the lattice, along the longest side of the mesh"),
    kModelUnit,
    Argument("error", kReal, kPositive, "", "admissible volume of the tetrahedra outside the mesh, and of the mesh outside of them, relative to that of the mesh; fit is 0.1", {.first_default = "fit", .words = "fit", .omitted_at_default = true}),
    Argument("nodes", kCount, kCountFromOne, "", "of its tetrahedra, which a plan states; another number is refused", {.first_default = "any", .words = "any"})};
constexpr Parameter kPartOfList = Argument("part", kWord, kAny, "", "a part( )", {.calls = "part"});
constexpr Parameter kTraceFile[] = {
    Argument("file", kText, kAny, "", "written by `cdb trace`, relative to the .cdb file"),
    Argument("sha256", kText, kAny, "", "of its boxes; a different trace is refused", {.first_default = "any", .words = "any"})};
constexpr Parameter kEvery[] = {
    Argument("cycles", kCount, kCountFromOne, "", "cycles between draws"),
    Argument("value", kVector, kAny, kParametersUnit, "a vector, or a distribution, drawn each time", {.distribution = true})};
constexpr Parameter kRotating[] = {
    Argument("vector", kVector, kAny, kParametersUnit, "at the start"),
    Argument("about", kVector, kNotZero, "", "the axis, right-handed"),
    Argument("period", kReal, kPositive, "s", "of a full turn")};

constexpr Parameter kTimeTable[] = {
    Argument("file", kText, kAny, "", "CSV or other text, relative to the .cdb file: a line for each time, with the columns t and value, or t, x, y, z of a vector"),
    Argument("sha256", kText, kAny, "", "of the file; a different file is refused", {.first_default = "any", .words = "any"}),
    Argument("between", kWord, kAny, "", "between two lines: a straight line from one to the other, or hold the value of the first", {.first_default = "line", .words = "line hold"}),
    Argument("then", kWord, kAny, "", "after the last line: its value stays, or repeat from the first, or zero", {.first_default = "stay", .words = "stay repeat zero"}),
    kSeparator, kDecimal, kHeader};

constexpr Parameter kSame[] = {
    Argument("value", kReal, kPositive, kParametersUnit, "a number, or a distribution, drawn once for each object", {.distribution = true})};
constexpr Parameter kDensity[] = {
    Argument("value", kReal, kPositive, "kg/m^3", "a number, or a distribution, drawn for each object", {.distribution = true})};

constexpr ParametrisedWord kCalls[] = {
    {"grid", "a cubic lattice about the centre", kGrid},
    {"stack", "columns of objects on the floor", kStack},
    {"pyramid", "square layers on the floor, each one object shorter along both sides", kPyramid},
    {"pile", "dropped from above and settled before the first cycle", kPile},
    {"ring", "evenly spaced on a horizontal circle about the centre", kRing},
    {"line", "in a straight line through the centre, in order", kLine},
    {"at", "one object at this point, or at((0, 0, 0), (1, 2, 3)): one at each of several", kAt, true},
    {"pair", "two objects about the centre with this distance between their surfaces, in a random direction", kPair},
    {"relative_to", "each at an offset from the object of another group with the same number, and turned with it", kRelative},
    {"poses", "positions from a file, with orientations and velocities if it has them", kPoses},
    {"path", "one kinematic object, moved along the poses of a file: columns t, x, y, z, and qw, qx, qy, qz if it turns", kPath},
    {"list", "positions of joints from a file, a line for each configuration", kList},
    {"box", "the box between two corners", kBox},
    {"above", "the box over the bounding box of a group, from its top up", kAbove},
    {"beside", "the box at one side of the bounding box of a group, as large along the other axes", kBeside},
    {"on_top", "above a group, with the objects standing on the top of its bounding box", kOnTop},
    {"mesh", "your own solid, as a compound of convex hulls; the mesh must be watertight", kMesh},
    {"hull", "the convex hull of your own mesh", kModel},
    {"surface", "the triangles of your own mesh, open or closed, as ground for fixed objects", kSurface},
    {"heights", "a height field, as ground for fixed objects", kHeights},
    {kHeightCall, "the heights that a formula gives, as ground for fixed objects", kHeight},
    {kImplicitCall, "the surface where a formula changes its sign, as ground for fixed objects", kImplicit},
    {kVoxelsCall, "the solid cells of a grid, or those in which points of a cloud lie, as ground for fixed objects", kVoxels},
    {"compound", "one body of several parts, compound(part(…), part(…)), each at its own place; the origin of its frame is the point that layouts place", kCompound, false, true},
    {"rope", "a soft body: a chain of nodes along x, as long as its size, and as thick as two margins", kRope},
    {"cloth", "a soft body: a sheet of triangles over x and z, as thick as two margins", kCloth},
    {"block", "a soft body: a solid of tetrahedra, with the sides of a cuboid and a margin around it", kBlock},
    {"soft", "a soft body: your own closed mesh, as a solid of tetrahedra of about the same size, and a margin around it", kSoft},
    {"part", "of a compound: a closed form, or the hulls of a mesh", kPart},
    {"file", "a recorded run; equivalent to its name in quotes", kTraceFile},
    {"same", "one value for all sides of an object", kSame},
    {"density", "the density of an object, from which its mass is computed", kDensity},
    {"every", "a vector that is drawn again after this number of cycles", kEvery},
    {"rotating", "a vector that rotates at a constant rate", kRotating},
    {"table", "values over time from a file, a line for each time", kTimeTable},
};
// clang-format on

}  // namespace

std::span<const ParametrisedWord> ParametrisedWords() { return kCalls; }

const ParametrisedWord& EmpiricalTable() { return kEmpiricalWord; }

const ParametrisedWord* FindParametrisedWord(std::string_view name) {
  const auto* row = std::ranges::find(kCalls, name, &ParametrisedWord::name);
  return row == std::end(kCalls) ? nullptr : row;
}

std::vector<std::string_view> RequiredArguments(const ParametrisedWord& info) {
  std::vector<std::string_view> names;
  for (const Parameter& argument : info.arguments)
    if (argument.first_default.empty()) names.push_back(argument.name);
  if (info.takes_parts) names.push_back(kPartOfList.name);
  return names;
}

Value DefaultOf(const Parameter& argument) {
  CDB_CHECK(argument.HasWord(argument.first_default));
  return Word{std::string(argument.first_default)};
}

std::optional<Call> WithDefaults(const ParametrisedWord& info) {
  if (!RequiredArguments(info).empty()) return std::nullopt;
  Call call{std::string(info.name), {}};
  for (const Parameter& argument : info.arguments) call.arguments.push_back(DefaultOf(argument));
  return call;
}

const Parameter& PartParameter() { return kPartOfList; }

std::span<const Value> PartsOf(const Call& call) {
  const ParametrisedWord* info = FindParametrisedWord(call.name);
  if (info == nullptr || !info->takes_parts) return {};
  return std::span(call.arguments).subspan(info->arguments.size());
}

std::vector<std::string_view> FilesOf(const Call& call) {
  const ParametrisedWord* info = FindParametrisedWord(call.name);
  std::vector<std::string_view> files;
  if (info != nullptr && NamesFile(*info)) files.push_back(std::get<Text>(call.arguments[0]).text);
  for (const Value& part : PartsOf(call))
    if (const Call* type = AsCall(ArgumentOf(*AsCall(part), "type")))
      files.push_back(std::get<Text>(ArgumentOf(*type, "file")).text);
  return files;
}

bool ListsPoints(const Call& call) {
  return !call.arguments.empty() && AsVector(call.arguments[0]) != nullptr &&
         FindParametrisedWord(call.name)->takes_points;
}

const Value& ArgumentOf(const Call& call, std::string_view argument) {
  const ParametrisedWord* info =
      call.name == kEmpiricalWord.name ? &kEmpiricalWord : FindParametrisedWord(call.name);
  CDB_CHECK(info != nullptr &&
            (info->arguments.size() == call.arguments.size() ||
             (info->takes_parts && info->arguments.size() < call.arguments.size())));
  const auto row = std::ranges::find(info->arguments, argument, &Parameter::name);
  CDB_CHECK(row != info->arguments.end());
  return call.arguments[static_cast<std::size_t>(row - info->arguments.begin())];
}

}  // namespace cdb::schema
