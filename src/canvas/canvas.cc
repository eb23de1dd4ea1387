#include "impedraw/canvas/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "impedraw/canvas/embree.h"
#include "impedraw/canvas/mesh_topology.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

enum Feature {
  kCorner0,
  kCorner1,
  kCorner2,
  kSide0,
  kSide1,
  kSide2,
  kInside
};  // side i runs from corner i to corner i + 1

struct OnTriangle {
  Vector3d p;
  Vector3d weight;  // barycentric
  Feature feature;
};

// The closest feature (corner, side or inside) follows from the region of the triangle's plane to
// which p projects.
OnTriangle closest_on_triangle(const std::array<Vector3d, 3>& corner, const Vector3d& p) {
  const Vector3d& a = corner[0];
  const Vector3d& b = corner[1];
  const Vector3d& c = corner[2];
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double ab_ap = ab.dot(ap), ac_ap = ac.dot(ap);
  if (ab_ap <= 0.0 && ac_ap <= 0.0) return {a, {1, 0, 0}, kCorner0};
  const Vector3d bp = p - b;
  const double ab_bp = ab.dot(bp), ac_bp = ac.dot(bp);
  if (ab_bp >= 0.0 && ac_bp <= ab_bp) return {b, {0, 1, 0}, kCorner1};
  const Vector3d cp = p - c;
  const double ab_cp = ab.dot(cp), ac_cp = ac.dot(cp);
  if (ac_cp >= 0.0 && ab_cp <= ac_cp) return {c, {0, 0, 1}, kCorner2};
  // the barycentric weights, times the squared area
  const double w_c = ab_ap * ac_bp - ab_bp * ac_ap;
  if (w_c <= 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0) {
    const double s = ab_ap / (ab_ap - ab_bp);
    return {a + s * ab, {1 - s, s, 0}, kSide0};
  }
  const double w_b = ab_cp * ac_ap - ab_ap * ac_cp;
  if (w_b <= 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0) {
    const double s = ac_ap / (ac_ap - ac_cp);
    return {a + s * ac, {1 - s, 0, s}, kSide2};
  }
  const double w_a = ab_bp * ac_cp - ab_cp * ac_bp;
  const double to_c = ac_bp - ab_bp, to_b = ab_cp - ac_cp;
  if (w_a <= 0.0 && to_c >= 0.0 && to_b >= 0.0) {
    const double s = to_c / (to_c + to_b);
    return {b + s * (c - b), {0, 1 - s, s}, kSide1};
  }
  const double sum = w_a + w_b + w_c;
  const double v = w_b / sum, w = w_c / sum;
  return {a + v * ab + w * ac, {1 - v - w, v, w}, kInside};
}

Vector3d smooth_normal(const MeshTopology& topology, const MeshTopology::Face& face,
                       const Vector3d& weight) {
  Vector3d n = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) n += weight[i] * topology.smooth_normal[face.smooth[i]];
  const double length = n.norm();
  return length > 1e-6
             ? Vector3d(n / length)
             : face.normal;  // opposite vertex normals: a fold, where only the face has a normal
}

// The normal that determines the side of a point whose closest point lies on the given feature.
Vector3d side_normal(const MeshTopology& topology, const MeshTopology::Face& face,
                     Feature feature) {
  if (feature == kInside) return face.normal;
  if (feature <= kCorner2) return topology.side_normal[face.vertex[feature]];
  const int neighbour = face.neighbour[feature - kSide0];
  return neighbour < 0 ? face.normal : Vector3d(face.normal + topology.faces[neighbour].normal);
}

bool on_boundary(const MeshTopology& topology, const MeshTopology::Face& face, Feature feature) {
  if (feature == kInside) return false;
  if (feature <= kCorner2) return topology.on_boundary[face.vertex[feature]];
  return face.neighbour[feature - kSide0] < 0;
}

bool on_crease(const MeshTopology& topology, const MeshTopology::Face& face, Feature feature) {
  if (feature == kInside) return false;
  if (feature <= kCorner2) return topology.on_crease[face.vertex[feature]];
  return face.crease[feature - kSide0];
}

constexpr double kOnEdge = 1e-7;  // nearer points are on the edge itself [m]

struct Place {
  double squared;  // of the distance [m²]
  int triangle = -1;
  OnTriangle at;
};

constexpr double kAlike = 1e-9;  // between the points of one place on two triangles [m]

bool alike(const Vector3d& a, const Vector3d& b) { return (a - b).squaredNorm() < kAlike * kAlike; }

// No triangle that shares the place with this one has a nearer point.
bool is_local_minimum(const MeshTopology& topology, const Vector3d& p, const Place& place) {
  const Feature feature = place.at.feature;
  if (feature == kInside) return true;
  const bool corner = feature <= kCorner2;
  const MeshTopology::Face& own = topology.faces[place.triangle];
  // Across the side, or round the corner either way: to the boundary, or once about.
  for (const int side : {corner ? int(feature) : feature - kSide0, (feature + 2) % 3}) {
    int from = place.triangle, next = own.neighbour[side];
    for (int i = 0; i < 100 && next >= 0 && next != place.triangle; ++i) {
      const MeshTopology::Face& face = topology.faces[next];
      const Vector3d q = closest_on_triangle(face.corner, p).p;
      const bool nearer = (q - p).squaredNorm() < place.squared && !alike(q, place.at.p);
      if (nearer && !face.normal.isZero(0.0)) return false;
      if (!corner) return true;
      int onwards = -1;
      for (int k = 0; k < 3; ++k)
        if (face.neighbour[k] != from && (face.vertex[k] == own.vertex[feature] ||
                                          face.vertex[(k + 1) % 3] == own.vertex[feature]))
          onwards = face.neighbour[k];
      from = next;
      next = onwards;
    }
    if (!corner) return true;
  }
  return true;
}

struct Nearest {
  const MeshTopology* topology;
  Vector3d p;
  double slack;  // largest error of a distance in single precision [m]
  Place best;
  double reach = 0.0;       // within which every local minimum is kept [m]
  std::span<Place> minima;  // nearest first
  int kept = 0;

  void keep(const Place& place) {
    const bool full = kept == static_cast<int>(minima.size());
    if (full && minima.back().squared <= place.squared) return;
    for (const Place& known : minima.first(kept))
      if (alike(known.at.p, place.at.p)) return;
    if (!is_local_minimum(*topology, p, place)) return;
    int i = full ? kept - 1 : kept++;
    for (; i > 0 && place.squared < minima[i - 1].squared; --i) minima[i] = minima[i - 1];
    minima[i] = place;
  }
};

bool visit_triangle(RTCPointQueryFunctionArguments* args) {
  Nearest& nearest = *static_cast<Nearest*>(args->userPtr);
  Place& best = nearest.best;
  const int triangle = static_cast<int>(args->primID);
  const auto& face = nearest.topology->faces[triangle];
  if (face.normal.isZero(0.0)) return false;
  const OnTriangle at = closest_on_triangle(face.corner, nearest.p);
  const double squared = (at.p - nearest.p).squaredNorm();
  if (squared < nearest.reach * nearest.reach) nearest.keep({squared, triangle, at});
  if (squared > best.squared ||
      (squared == best.squared && best.triangle >= 0 && triangle > best.triangle))
    return false;
  const bool nearer = squared < best.squared;
  best = {squared, triangle, at};
  if (nearer)
    args->query->radius =
        static_cast<float>(std::max(std::sqrt(squared), nearest.reach) + nearest.slack);
  return nearer;
}

}  // namespace

struct Canvas::Search {
  TriangleMesh mesh;
  MeshTopology topology;
  Eigen::AlignedBox3d bounds;
  // Embree's floats are relative to the middle of the canvas, where they are finest.
  Vector3d origin = Vector3d::Zero();
  double extent = 0.0;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Search() = default;
  // Delegates, so that what throws below is cleaned up after.
  explicit Search(TriangleMesh given) : Search() {
    mesh = std::move(given);
    require_valid(mesh);
    auto made = std::async(std::launch::async, [this] { return make_topology(mesh); });
    for (const auto& p : mesh.vertices) bounds.extend(p);
    origin = bounds.center();
    extent = bounds.diagonal().norm();
    device = rtcNewDevice("threads=1");  // one builder: the same tree every time
    if (!device)
      throw InputError(
          fmt::format("canvas: Embree does not start (error {})", int(rtcGetDeviceError(nullptr))));
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    auto* triangles = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      Eigen::Map<Eigen::Vector3f>(vertices + 3 * i) = (mesh.vertices[i] - origin).cast<float>();
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k)
        triangles[3 * i + k] = static_cast<unsigned>(mesh.triangles[i][k]);
    }
    rtcCommitGeometry(geometry);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips between neighbouring triangles
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    topology = made.get();
  }

  ~Search() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  bool search(const Vector3d& p, double max_distance, Nearest* nearest) const {
    if (!p.allFinite() || !(max_distance >= 0.0)) return false;
    const Vector3d p_O = p - origin;
    nearest->topology = &topology;
    nearest->p = p;
    nearest->slack = 1e-6 * (extent + p_O.norm());
    nearest->best.squared = max_distance * max_distance;
    const Eigen::Vector3f q = p_O.cast<float>();
    RTCPointQuery query{};
    query.x = q.x();
    query.y = q.y();
    query.z = q.z();
    query.radius = static_cast<float>(std::max(max_distance, nearest->reach) + nearest->slack);
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, visit_triangle, nearest);
    return nearest->best.triangle >= 0;
  }

  SurfacePoint surface_point(const Vector3d& p, const Place& place) const {
    const auto& face = topology.faces[place.triangle];
    const OnTriangle& at = place.at;
    SurfacePoint result;
    result.p_W = at.p;
    result.n_W = smooth_normal(topology, face, at.weight);
    result.distance = std::copysign(std::sqrt(place.squared),
                                    (p - at.p).dot(side_normal(topology, face, at.feature)));
    result.triangle = place.triangle;
    result.on_edge = on_boundary(topology, face, at.feature);
    // Over a sharp edge the surface's normal is any between those of its faces: that towards p.
    if (on_crease(topology, face, at.feature) && place.squared > kOnEdge * kOnEdge)
      result.n_W = (p - at.p) / result.distance;
    return result;
  }

  SurfacePoint closest(const Vector3d& p, double max_distance) const {
    Nearest nearest;
    if (search(p, max_distance, &nearest)) return surface_point(p, nearest.best);
    return {p, Vector3d::UnitZ(), std::numeric_limits<double>::quiet_NaN(), -1, false};
  }

  int closest_places(const Vector3d& p, double reach, double max_distance,
                     std::span<SurfacePoint> found) const {
    std::array<Place, 16> minima;
    Nearest nearest;
    nearest.reach = reach;
    nearest.minima = minima;
    if (found.empty() || !search(p, max_distance, &nearest)) return 0;
    found[0] = surface_point(p, nearest.best);
    std::size_t n = 1;
    for (const Place& place : std::span(minima).first(nearest.kept))
      if (n < found.size() && !alike(place.at.p, nearest.best.at.p))
        found[n++] = surface_point(p, place);
    return static_cast<int>(n);
  }

  // Intersects the plane of the hit triangle in double precision. A ray within that plane keeps
  // Embree's distance `found`.
  static double exact_t(const MeshTopology::Face& face, const Vector3d& origin_W,
                        const Vector3d& direction, double length, double found) {
    const double along = direction.dot(face.normal);
    if (std::abs(along) > 1e-9 * length)
      return std::max(0.0, (face.corner[0] - origin_W).dot(face.normal) / along);
    return found / length;
  }

  void rays(const Vector3d& origin_W, std::span<const Vector3d> directions,
            std::span<double> distances) const {
    constexpr std::size_t kPacket = 8;
    const Eigen::Vector3f o = (origin_W - origin).cast<float>();
    RTCRayHit8 packet;
    alignas(32) int valid[kPacket];
    for (std::size_t k = 0; k < kPacket; ++k) {
      packet.ray.org_x[k] = o.x();
      packet.ray.org_y[k] = o.y();
      packet.ray.org_z[k] = o.z();
      packet.ray.tnear[k] = packet.ray.time[k] = 0.0f;
      packet.ray.mask[k] = ~0u;
      packet.ray.id[k] = packet.ray.flags[k] = 0;
    }
    for (std::size_t first = 0; first < directions.size(); first += kPacket) {
      const std::size_t n = std::min(kPacket, directions.size() - first);
      for (std::size_t k = 0; k < kPacket; ++k) {
        const Vector3d& d = directions[first + std::min(k, n - 1)];
        valid[k] = k < n ? -1 : 0;
        packet.ray.dir_x[k] = static_cast<float>(d.x());
        packet.ray.dir_y[k] = static_cast<float>(d.y());
        packet.ray.dir_z[k] = static_cast<float>(d.z());
        packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
        packet.hit.geomID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
      }
      embree::intersect_coherent(valid, scene, &packet);
      for (std::size_t k = 0; k < n; ++k)
        distances[first + k] = packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID
                                   ? std::numeric_limits<double>::infinity()
                                   : exact_t(topology.faces[packet.hit.primID[k]], origin_W,
                                             directions[first + k], 1.0, packet.ray.tfar[k]);
    }
  }

  std::optional<RayHit> ray(const Vector3d& origin_W, const Vector3d& direction) const {
    const double length = direction.norm();
    if (!origin_W.allFinite() || !direction.allFinite() || length == 0.0) return std::nullopt;
    const Eigen::Vector3f o = (origin_W - origin).cast<float>();
    const Eigen::Vector3f d = (direction / length).cast<float>();
    RTCRayHit ray{};
    ray.ray.org_x = o.x();
    ray.ray.org_y = o.y();
    ray.ray.org_z = o.z();
    ray.ray.dir_x = d.x();
    ray.ray.dir_y = d.y();
    ray.ray.dir_z = d.z();
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    embree::intersect(scene, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const int triangle = static_cast<int>(ray.hit.primID);
    const auto& face = topology.faces[triangle];
    const double t = exact_t(face, origin_W, direction, length, ray.ray.tfar);
    const Vector3d p = origin_W + t * direction;
    return RayHit{t, p, smooth_normal(topology, face, closest_on_triangle(face.corner, p).weight),
                  triangle};
  }
};

Canvas::Canvas(TriangleMesh mesh) : search_(std::make_unique<Search>(std::move(mesh))) {}
Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

SurfacePoint Canvas::closest(const Vector3d& p_W) const noexcept {
  // Most places that are asked about lie near the canvas: a bounded search looks at few triangles.
  const auto near = closest(p_W, 0.01 * search_->extent);
  return near ? *near : search_->closest(p_W, std::numeric_limits<double>::infinity());
}

std::optional<SurfacePoint> Canvas::closest(const Vector3d& p_W,
                                            double max_distance) const noexcept {
  const SurfacePoint point = search_->closest(p_W, max_distance);
  if (point.triangle < 0) return std::nullopt;
  return point;
}

int Canvas::closest_places(const Vector3d& p_W, double reach, double max_distance,
                           std::span<SurfacePoint> found) const noexcept {
  return search_->closest_places(p_W, reach, max_distance, found);
}

std::optional<RayHit> Canvas::ray(const Vector3d& origin_W,
                                  const Vector3d& direction_W) const noexcept {
  return search_->ray(origin_W, direction_W);
}

void Canvas::rays(const Vector3d& origin_W, std::span<const Vector3d> directions_W,
                  std::span<double> distances) const noexcept {
  search_->rays(origin_W, directions_W, distances);
}

const TriangleMesh& Canvas::mesh() const noexcept { return search_->mesh; }
const Eigen::AlignedBox3d& Canvas::bounds() const noexcept { return search_->bounds; }

}  // namespace impedraw
