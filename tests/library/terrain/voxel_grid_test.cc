#include "library/terrain/voxel_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include "library/meshes/mass_properties.h"
#include "library/scene_error.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using terrain::ParseVoxels;
using terrain::VoxelGrid;
using terrain::VoxelOptions;

/// The files that the fuzz target starts from: 4 x 3 x 2 cells.
std::string BytesOf(const std::string& file) {
  std::ifstream in(std::filesystem::path(CDB_VOXELS_CORPUS) / file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
std::int64_t ValueAt(std::int64_t x, std::int64_t y, std::int64_t z) {
  return (x * 7 + y * 5 + z * 3 + x * y * z) % 3;
}

std::string Refused(const std::string& bytes, const std::string& name, VoxelOptions options = {}) {
  if (!options.cell) options.cell = 1;
  return Refusal([&] { ParseVoxels(bytes, name, options); });
}
/// With the part from `from` on replaced.
std::string With(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

constexpr std::array<std::optional<std::uint64_t>, 3> kCounts = {4, 3, 2};

TEST(Voxels, OfEveryFormatAreTheSame) {
  for (const std::string file : {"cells.raw", "cells.binvox", "c_order.npy", "fortran.npy",
                                 "bool.npy", "ascii.pcd", "binary.pcd", "ascii.ply", "faces.ply"})
    for (const std::uint64_t threshold : {1u, 2u}) {
      if (file == "bool.npy" && threshold == 2) continue;
      SCOPED_TRACE(file);
      VoxelOptions options{.cell = 1, .threshold = threshold};
      if (file == "cells.raw") options.counts = kCounts;
      const VoxelGrid grid = ParseVoxels(BytesOf(file), file, options);
      EXPECT_EQ(grid.counts, (terrain::Cell{4, 3, 2}));
      EXPECT_EQ(grid.cell, 1);
      // The scale of the binvox file is 2, and its longest side has 4 cells of 0.5.
      EXPECT_EQ(grid.lower, file == "cells.binvox" ? Vector3d(2, 4, 6) : Vector3d(0, 0, 0));
      for (std::int64_t x = 0; x < 4; ++x)
        for (std::int64_t y = 0; y < 3; ++y)
          for (std::int64_t z = 0; z < 2; ++z)
            EXPECT_EQ(grid.IsSolid({x, y, z}),
                      ValueAt(x, y, z) >= static_cast<std::int64_t>(threshold))
                << x << " " << y << " " << z;
    }
  const VoxelGrid own = ParseVoxels(BytesOf("cells.binvox"), "a.BINVOX");
  EXPECT_EQ(own.cell, 0.5);
  EXPECT_EQ(own.lower, Vector3d(1, 2, 3));
}

TEST(Voxels, AreTurnedIfTheirZIsUp) {
  const VoxelGrid grid = ParseVoxels(BytesOf("cells.binvox"), "a.binvox", {.is_z_up = true});
  EXPECT_EQ(grid.counts, (terrain::Cell{4, 2, 3}));
  for (std::int64_t x = 0; x < 4; ++x)
    for (std::int64_t y = 0; y < 3; ++y)
      for (std::int64_t z = 0; z < 2; ++z) {
        const Vector3d middle =
            Vector3d(1.25, 2.25, 3.25) +
            0.5 * Vector3d(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
        EXPECT_EQ(grid.Contains({middle.x(), middle.z(), -middle.y()}), ValueAt(x, y, z) > 0);
      }
  EXPECT_FALSE(grid.Contains({0, 0, 0}));
  EXPECT_FALSE(grid.Contains(Vector3d::Constant(NAN)));
}

TEST(Voxels, OfPointsLieAtMultiplesOfTheCell) {
  const std::string file =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
      "float y\nproperty float z\nend_header\n-0.1 0.3 7\n-0.2 0.35 7.1\n0.6 "
      "0.3 7\n";
  const VoxelGrid grid = ParseVoxels(file, "a.ply", {.cell = 0.5});
  EXPECT_EQ(grid.counts, (terrain::Cell{3, 1, 1}));
  EXPECT_EQ(grid.lower, Vector3d(-0.5, 0, 7));
  EXPECT_EQ(grid.SolidCount(), 2u);
  EXPECT_EQ(ParseVoxels(file, "a.ply", {.cell = 0.5, .threshold = 2}).SolidCount(), 1u);
  EXPECT_EQ(Refused(file, "a.ply", {.cell = 0.5, .threshold = 3}),
            "a.ply: no cell is solid: the most points in one are 2, the threshold 3; for example "
            "`threshold: 2`, or larger cells");
  EXPECT_EQ(Refused(file, "a.ply", {.cell = 1e-9}),
            "a.ply: its points extend over 0.8 x 0.05 x 0.1 m, which are 4e+24 cells of 1e-09 m; "
            "the limit is 268435456; make the cells larger, or remove points far from the others");
}

TEST(Voxels, WithoutTheirSizeAreRefused) {
  const std::string raw = BytesOf("cells.raw");
  EXPECT_EQ(Refusal([&] { ParseVoxels(raw, "a.raw", {.counts = kCounts}); }),
            "a.raw: it does not say how large a cell is; give it in m, such as `cell: 0.1`");
  EXPECT_EQ(Refused(raw, "a.raw"),
            "a.raw: raw bytes do not say how many columns they have; for example `columns: 64, "
            "rows: 64, layers: 32`: along x, y and z of the file");
  EXPECT_EQ(Refused(raw, "a.raw", {.counts = {4, 3, 3}}),
            "a.raw: it has 24 bytes, but 4 x 3 x 3 cells are 36; correct columns, rows and layers; "
            "a cell is one byte");
  constexpr std::uint64_t kHuge = std::uint64_t{1} << 63;
  EXPECT_EQ(Refused(raw, "a.raw", {.counts = {kHuge, kHuge, 4}}),
            "a.raw: it has 9223372036854775808 x 9223372036854775808 x 4 cells; the limit is "
            "268435456; take a part of it, or larger cells");
  EXPECT_EQ(Refused(raw, "a.raw", {.counts = kCounts, .threshold = 3}),
            "a.raw: no cell is solid: the largest value is 2, the threshold 3; for example "
            "`threshold: 2`");
  EXPECT_EQ(Refused(std::string(24, '\0'), "a.raw", {.counts = kCounts}),
            "a.raw: no cell is solid: the largest value is 0, the threshold 1; name another file");
  EXPECT_EQ(Refused(BytesOf("bool.npy"), "a.npy", {.counts = {4, {}, {}}}),
            "a.npy: columns, rows and layers are for .raw files; this one states its own; remove "
            "them");
}

TEST(Voxels, ThatAreDamagedAreRefused) {
  const std::string binvox = BytesOf("cells.binvox"), npy = BytesOf("c_order.npy"),
                    pcd = BytesOf("ascii.pcd"), binary = BytesOf("binary.pcd");
  EXPECT_EQ(Refused(binvox.substr(0, binvox.size() - 2), "a.binvox"),
            "a.binvox: its runs have 23 cells, its header 24; the file is truncated or damaged");
  EXPECT_EQ(Refused(With(binvox, "dim 4", "dim 3"), "a.binvox"),
            "a.binvox: byte 79: its runs have more than 18 cells; the file is damaged, or `dim` is "
            "wrong");
  EXPECT_EQ(Refused(With(binvox, "dim 4", "dim 99999999999"), "a.binvox"),
            "a.binvox: it has 99999999999 x 3 x 2 cells; the limit is 268435456; take a part of "
            "it, or larger cells");
  EXPECT_EQ(Refused(With(binvox, "scale 2", "scale nan"), "a.binvox"),
            "a.binvox:4: `nan` is not a number; write the file again");
  EXPECT_EQ(Refused(npy.substr(0, npy.size() - 1), "a.npy"),
            "a.npy: it has 23 bytes after its header, but 4 x 3 x 2 cells are 24; the file is "
            "truncated or damaged");
  EXPECT_EQ(Refused(With(npy, "|u1", "<f4"), "a.npy"),
            "a.npy: its values are of type '<f4', not uint8 or bool; write `(array > "
            "0.5).astype(\"uint8\")` by numpy.save");
  EXPECT_EQ(Refused(With(npy, "(4, 3, 2)", "(4, 6)   "), "a.npy"),
            "a.npy: its shape is (4, 6), which is not of three dimensions; write an array of cells "
            "along x, "
            "y and z");
  EXPECT_EQ(Refused(npy.substr(0, 40), "a.npy"),
            "a.npy: the file ends in its header; the file is truncated");
  EXPECT_EQ(Refused(BytesOf("compressed.pcd"), "a.pcd"),
            "a.pcd:11: binary_compressed data are not read; convert it: "
            "`pcl_convert_pcd_ascii_binary IN.pcd OUT.pcd 1`");
  EXPECT_EQ(Refused(binary.substr(0, binary.size() - 3), "a.pcd"),
            "a.pcd: it has 381 bytes after its header, but 24 points of 16 bytes are 384; the file "
            "is truncated or damaged");
  EXPECT_EQ(Refused(With(pcd, "0.4 0.5\n", "0.4 nan\n"), "a.pcd"),
            "a.pcd: 1 of 24 points are not finite, the first is point 1; remove them, such as by "
            "pcl::removeNaNFromPointCloud");
  EXPECT_EQ(Refused(With(pcd, "POINTS 24", "POINTS 2147483648"), "a.pcd"),
            "a.pcd: it has 2147483648 points, but 24 by 1 are 24; save it again by "
            "pcl::io::savePCDFile, ascii or binary");
  EXPECT_EQ(Refused(With(pcd, "FIELDS x y z", "FIELDS x y w"), "a.pcd"),
            "a.pcd: FIELDS has `z` 0 times, not once; save it again by pcl::io::savePCDFile, ascii "
            "or binary");
}

TEST(Voxels, OfOtherFormatsAreNamed) {
  EXPECT_EQ(Refused("BDV\0\0", "a.vdb"),
            "a.vdb: is a sparse grid (OpenVDB); write its dense grid of uint8 by "
            "`numpy.save(\"a.npy\", grid)`");
  EXPECT_EQ(Refused("# Octomap OcTree binary file\n", "a.bt"),
            "a.bt: is a tree of OctoMap; convert it: `octree2pointcloud a.bt a.pcd`, and let cell "
            "be its resolution");
  EXPECT_EQ(Refused("LASF", "scan.las"),
            "scan.las: is a point cloud (LAS); convert it: `pdal translate scan.las scan.ply`");
  EXPECT_EQ(Refused("NRRD0004\n", "a.raw"),
            "a.raw: is a grid of NRRD; write its dense grid of uint8 by `numpy.save(\"a.npy\", "
            "grid)`");
  EXPECT_EQ(Refused("", "a.dat"),
            "a.dat: unknown format; its name ends in .raw, .binvox, .npy, .ply or .pcd");
}

/// Each edge of a closed surface is passed as often in one direction as in the other.
void ExpectClosed(const meshes::Mesh& mesh) {
  using Point = std::array<double, 3>;
  std::map<std::pair<Point, Point>, int> edges;
  for (const meshes::Triangle& triangle : mesh.triangles) {
    const auto corners = meshes::CornersOf(mesh, triangle);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = [&](std::size_t k) -> Point {
        return {corners[k].x(), corners[k].y(), corners[k].z()};
      };
      const Point from = at(i), to = at((i + 1) % 3);
      ++edges[{from, to}];
      --edges[{to, from}];
    }
  }
  for (const auto& [edge, sum] : edges) EXPECT_EQ(sum, 0);
}

TEST(Voxels, HaveAClosedSurfaceOfTheirVolume) {
  std::mt19937_64 random(3);
  for (const unsigned of : {1u, 2u, 4u, 9u}) {
    VoxelGrid grid{{6, 5, 7}, std::vector<bool>(210), {0.1, -7, 3.3}, 0.3};
    for (std::size_t i = 0; i < 210; ++i) grid.solid[i] = random() % of == 0;
    grid.solid[17] = true;
    const meshes::Mesh mesh = terrain::SurfaceOf(grid, "a.raw", 10'000);
    ExpectClosed(mesh);
    EXPECT_NEAR(meshes::MassPropertiesOf(mesh).volume,
                0.027 * static_cast<double>(grid.SolidCount()), 1e-10);
    if (of == 1) {
      EXPECT_EQ(mesh.triangles.size(), 2u * 2 * (6 * 5 + 6 * 7 + 5 * 7)) << "only exposed faces";
    }
    EXPECT_EQ(terrain::SurfaceOf(grid, "a.raw", mesh.triangles.size()), mesh);
    const std::string refusal =
        Refusal([&] { terrain::SurfaceOf(grid, "a.raw", mesh.triangles.size() - 1); });
    EXPECT_NE(refusal.find("solid cells has more than"), refusal.npos) << refusal;
  }
}

}  // namespace
}  // namespace cdb::tests
