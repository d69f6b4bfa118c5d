#include "library/detectors/narrow/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace cdb::narrow {
namespace {

/// Vertices this close to the plane of a face are in it, in sizes of the piece.
constexpr double kFlat = 1e-9;
constexpr std::uint32_t kPad = 4;  // numbers that a register may hold

bool IsSame(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool IsSame(const Shape& a, const Shape& b) {
  return a.kind == b.kind && IsSame(a.half, b.half) && IsSame(a.centre, b.centre) &&
         IsSame(a.normal, b.normal) && a.hulls.data() == b.hulls.data() &&
         a.hulls.size() == b.hulls.size();
}

/// The vectors as columns. Returns their length.
std::uint32_t SetColumns(std::span<const Vec3> vectors, std::vector<double>& columns) {
  const auto count = static_cast<std::uint32_t>(vectors.size());
  const std::uint32_t padded = (count + kPad - 1) / kPad * kPad;
  columns.resize(std::size_t{3} * padded);
  for (std::uint32_t i = 0; i < padded; ++i) {
    const Vec3& vector = vectors[i < count ? i : 0];
    columns[i] = vector.x;
    columns[padded + i] = vector.y;
    columns[2 * padded + i] = vector.z;
  }
  return padded;
}

void SetVertices(std::span<const Vec3> vertices, Piece& piece) {
  piece.count = static_cast<std::uint32_t>(vertices.size());
  piece.padded = SetColumns(vertices, piece.columns);
}

/// The middle of the vertices' box, and the ball about it.
void SetBound(Piece& piece) {
  Vec3 lower = piece.Vertex(0), upper = lower;
  for (std::uint32_t i = 1; i < piece.count; ++i) {
    const Vec3 v = piece.Vertex(i);
    lower = {std::min(lower.x, v.x), std::min(lower.y, v.y), std::min(lower.z, v.z)};
    upper = {std::max(upper.x, v.x), std::max(upper.y, v.y), std::max(upper.z, v.z)};
  }
  piece.centre = 0.5 * (lower + upper);
  for (std::uint32_t i = 0; i < piece.count; ++i)
    piece.bound = std::max(piece.bound, Norm(piece.Vertex(i) - piece.centre));
  piece.bound += piece.radius;
  piece.reach = Norm(piece.centre) + piece.bound;
}

Piece MakeBall(double radius) {
  Piece piece{.kind = Kind::kBall, .radius = radius};
  SetVertices(std::vector<Vec3>{{0, 0, 0}}, piece);
  SetBound(piece);
  return piece;
}

Piece MakeCapsule(double radius, double straight) {
  Piece piece{.kind = Kind::kCapsule, .radius = radius, .half = {0, straight, 0}};
  SetVertices(std::vector<Vec3>{{0, -straight, 0}, {0, straight, 0}}, piece);
  SetBound(piece);
  return piece;
}

Piece MakePlane(const Vec3& normal) {
  return {.kind = Kind::kPlane, .normal = normal, .bound = std::numeric_limits<double>::infinity()};
}

Piece MakeBox(const Vec3& half) {
  Piece piece{.kind = Kind::kBox, .half = half};
  std::vector<Vec3> vertices;
  for (unsigned i = 0; i < 8; ++i)
    vertices.push_back({(i & 1) != 0 ? half.x : -half.x, (i & 2) != 0 ? half.y : -half.y,
                        (i & 4) != 0 ? half.z : -half.z});
  SetVertices(vertices, piece);
  SetBound(piece);
  // Face 2 i is the lower one along axis i, and 2 i + 1 the upper one.
  piece.corners = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
  const double sides[] = {half.x, half.y, half.z};
  for (std::uint32_t face = 0; face < 6; ++face) {
    const double sign = face % 2 == 0 ? -1 : 1;
    const Vec3 normal = {face / 2 == 0 ? sign : 0, face / 2 == 1 ? sign : 0,
                         face / 2 == 2 ? sign : 0};
    piece.faces.push_back({normal, sides[face / 2], 4 * face, 4});
  }
  return piece;
}

/// Corners of the rim of a cylinder or cone. They are fixed to the body, so that the contacts of a
/// base that rests are the same in each cycle.
constexpr std::uint32_t kRimCorners = 8;

/// Adds a base at `height`, of which the vertices follow those of the last one.
void AddBase(double height, Piece& piece) {
  const auto first = static_cast<std::uint32_t>(piece.corners.size());
  const double sign = piece.faces.empty() ? -1 : 1;
  for (std::uint32_t i = 0; i < kRimCorners; ++i)
    piece.corners.push_back(first + (sign < 0 ? i : kRimCorners - 1 - i));
  piece.faces.push_back({{0, sign, 0}, sign * height, first, kRimCorners});
}

std::vector<Vec3> RimAt(double height, const Vec3& half) {
  constexpr double kEighth = 0.70710678118654752440;
  constexpr double kPlaces[kRimCorners][2] = {
      {1, 0},  {kEighth, kEighth},   {0, 1},  {-kEighth, kEighth},
      {-1, 0}, {-kEighth, -kEighth}, {0, -1}, {kEighth, -kEighth}};
  std::vector<Vec3> rim;
  for (const auto& [x, z] : kPlaces) rim.push_back({x * half.x, height, z * half.z});
  return rim;
}

Piece MakeCylinder(const Vec3& half) {
  Piece piece{.kind = Kind::kCylinder, .half = half};
  std::vector<Vec3> vertices = RimAt(-half.y, half);
  for (const Vec3& vertex : RimAt(half.y, half)) vertices.push_back(vertex);
  SetVertices(vertices, piece);
  SetBound(piece);
  AddBase(-half.y, piece);
  AddBase(half.y, piece);
  return piece;
}

Piece MakeCone(const Vec3& half, double middle) {
  Piece piece{.kind = Kind::kCone, .half = half};
  std::vector<Vec3> vertices = RimAt(middle - half.y, half);
  vertices.push_back({0, middle + half.y, 0});
  SetVertices(vertices, piece);
  SetBound(piece);
  AddBase(middle - half.y, piece);
  return piece;
}

/// `half`: of the ellipsoid.
Piece MakeRound(const Vec3& half, double straight) {
  Piece piece{.kind = Kind::kRound, .half = half, .straight = straight};
  piece.bound = piece.reach = std::max({half.x, half.y, half.z}) + straight;
  return piece;
}

Piece PieceOfCapsule(const Vec3& half) {
  if (half.x == half.z && half.y > half.x) return MakeCapsule(half.x, half.y - half.x);
  if (half.x == half.z && half.y == half.x) return MakeBall(half.x);
  const double cap = std::min(half.y, std::sqrt(half.x * half.z));
  return MakeRound({half.x, cap, half.z}, half.y - cap);
}

/// The corners of the face in order: the vertices in its plane that are corners of their convex
/// hull (Andrew's monotone chain).
std::vector<std::uint32_t> CornersInOrder(const Piece& piece, const Vec3& normal,
                                          std::span<const std::uint32_t> vertices) {
  const Vec3 u = UnitAcross(normal), v = Cross(normal, u);
  struct Place {
    double x, y;
    std::uint32_t vertex;
  };
  std::vector<Place> places, chain;
  for (const std::uint32_t i : vertices)
    places.push_back({Dot(u, piece.Vertex(i)), Dot(v, piece.Vertex(i)), i});
  std::ranges::sort(places, [](const Place& a, const Place& b) {
    return a.x != b.x ? a.x < b.x : (a.y != b.y ? a.y < b.y : a.vertex < b.vertex);
  });
  const double least = 1e-12 * piece.bound * piece.bound;  // twice an area
  const auto add = [&](std::size_t fixed, const Place& place) {
    while (chain.size() > fixed + 1) {
      const Place &a = chain[chain.size() - 2], &b = chain.back();
      if ((b.x - a.x) * (place.y - a.y) - (b.y - a.y) * (place.x - a.x) > least) break;
      chain.pop_back();
    }
    chain.push_back(place);
  };
  for (const Place& place : places) add(0, place);
  const std::size_t fixed = chain.size() - 1;
  for (std::size_t i = places.size() - 1; i-- > 0;) add(fixed, places[i]);
  chain.pop_back();
  std::vector<std::uint32_t> corners;
  for (const Place& place : chain) corners.push_back(place.vertex);
  return corners;
}

/// Adds the face in the plane of the triangle, with all its corners.
void AddFace(const Vec3& normal, Piece& piece) {
  FlatFace face{normal, -std::numeric_limits<double>::infinity(), 0, 0};
  for (std::uint32_t i = 0; i < piece.count; ++i)
    face.offset = std::max(face.offset, Dot(normal, piece.Vertex(i)));
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t i = 0; i < piece.count; ++i)
    if (Dot(normal, piece.Vertex(i)) >= face.offset - kFlat * piece.bound) vertices.push_back(i);
  if (vertices.size() < 3) return;
  const auto corners = CornersInOrder(piece, normal, vertices);
  if (corners.size() < 3) return;
  face.first = static_cast<std::uint32_t>(piece.corners.size());
  face.count = static_cast<std::uint32_t>(corners.size());
  piece.corners.insert(piece.corners.end(), corners.begin(), corners.end());
  piece.faces.push_back(face);
}

/// Triangles of a plane are one face: the largest ones come first, as they know it best.
Piece MakeHull(const Hull& hull) {
  Piece piece{.kind = Kind::kHull};
  SetVertices(hull.vertices, piece);
  SetBound(piece);
  struct Plane {
    Vec3 across;  ///< twice the area, along the normal
    Face triangle;
  };
  std::vector<Plane> planes;
  for (const Face& face : hull.faces) {
    const Vec3 &a = hull.vertices[face.a], &b = hull.vertices[face.b], &c = hull.vertices[face.c];
    planes.push_back({Cross(b - a, c - a), face});
  }
  std::ranges::stable_sort(planes, std::greater<>(),
                           [](const Plane& plane) { return SquaredNorm(plane.across); });
  for (const auto& [across, triangle] : planes) {
    if (!(Norm(across) > 1e-10 * piece.bound * piece.bound)) break;  // without an area
    const auto is_in = [&](const FlatFace& face) {
      const auto holds = [&](std::uint32_t i) {
        return Dot(face.normal, piece.Vertex(i)) >= face.offset - kFlat * piece.bound;
      };
      return Dot(face.normal, across) > 0 && holds(triangle.a) && holds(triangle.b) &&
             holds(triangle.c);
    };
    if (std::ranges::none_of(piece.faces, is_in)) AddFace(Normalized(across), piece);
  }
  std::vector<Vec3> normals;
  for (const FlatFace& face : piece.faces) normals.push_back(face.normal);
  piece.padded_faces = SetColumns(normals, piece.face_columns);
  return piece;
}

std::vector<Piece> PiecesOf(const Shape& shape) {
  const auto& [x, y, z] = shape.half;
  std::vector<Piece> pieces;
  switch (shape.kind) {
    case ShapeKind::kEllipsoid:
      pieces.push_back(x == y && y == z ? MakeBall(x) : MakeRound(shape.half, 0));
      break;
    case ShapeKind::kCapsule:
      pieces.push_back(PieceOfCapsule(shape.half));
      break;
    case ShapeKind::kBox:
      pieces.push_back(MakeBox(shape.half));
      break;
    case ShapeKind::kHull:
    case ShapeKind::kCompound:
      for (const Hull& hull : shape.hulls) {
        if (hull.vertices.size() >= 4) pieces.push_back(MakeHull(hull));
        // Without a flat hull, a part of the shape would be missed.
        if (pieces.empty() || pieces.back().faces.size() < 4) return {};
      }
      break;
    case ShapeKind::kPlane:
      pieces.push_back(MakePlane(shape.normal));
      break;
    case ShapeKind::kCylinder:
      pieces.push_back(MakeCylinder(shape.half));
      break;
    case ShapeKind::kCone:
      pieces.push_back(MakeCone(shape.half, shape.centre.y));
      break;
    case ShapeKind::kSurface:
    case ShapeKind::kSuperellipsoid:  // its nearly flat sides would need features to clip
      break;
  }
  return pieces;
}

}  // namespace

void Pieces::Prepare(const Scene& scene) {
  forms_.clear();
  of_body_.clear();
  for (const Shape& shape : scene.shapes) {
    // Scenes have few shapes, or only different ones, so the most recent ones are tried first.
    constexpr std::ptrdiff_t kTried = 64;
    const auto last =
        std::find_if(forms_.rbegin(), forms_.rbegin() + std::min(kTried, std::ssize(forms_)),
                     [&](const Form& form) { return IsSame(form.shape, shape); });
    const bool is_new = last == forms_.rbegin() + std::min(kTried, std::ssize(forms_));
    if (is_new)
      forms_.push_back({shape, std::make_unique<const std::vector<Piece>>(PiecesOf(shape))});
    const Form& form = is_new ? forms_.back() : *last;
    const std::vector<Piece>& pieces = *form.pieces;
    BodyPieces& body = of_body_.emplace_back();
    if (pieces.empty()) continue;
    body = {pieces.data(), static_cast<std::uint32_t>(pieces.size()), pieces.front().kind, 0};
    for (const Piece& piece : pieces) body.reach = std::max(body.reach, piece.reach);
  }
}

}  // namespace cdb::narrow
