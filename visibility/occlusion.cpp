#include "visibility/occlusion.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "engine/check.h"
#include "engine/geometry.h"

namespace atrium {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kBlocked = -kInfinity;  // what Embree sets tfar to

// Float is asked from this share of the shrunk end on: it may place a crossing a little off, and
// the decision is double's.
constexpr double kFloatMargin = 0.5;

// An end lies in a plane if nearer to it than this many roundings of the largest coordinate.
constexpr double kPlaneRoundings = 64;

struct Segment {
  Vec3 from, along;  // m; the point at t is from + t * along
  double tnear, tfar;
};

// What a query's hits are held against, behind Embree's own context.
struct Query {
  RTCIntersectContext context;
  const Segment* segments;
};
static_assert(offsetof(Query, context) == 0);

bool monitor(void* bytes, const ssize_t change, bool) {
  static_cast<std::atomic<std::int64_t>*>(bytes)->fetch_add(change, std::memory_order_relaxed);
  return true;
}

// Embree's errors leave no other way out: memory that ran out, or a call that is wrong.
void on_error(void*, RTCError code, const char*) { ATRIUM_CHECK(code == RTC_ERROR_NONE); }

}  // namespace

struct RayScene::Impl {
  struct Face {
    Plane plane;
    std::uint32_t id;
  };

  std::atomic<std::int64_t> embree_bytes{0};
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  Vec3 origin{0};
  double scale = 1;       // a power of two
  double end_shrink = 0;  // m, of the scene's extent
  double in_plane = 0;    // m, that rounding alone may put a point off its plane
  std::vector<Face> faces;
  std::vector<std::uint32_t> face_of_triangle;

  explicit Impl(std::span<const BlockerPolygon> polygons);
  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const Face& face(std::uint32_t triangle) const { return faces[face_of_triangle[triangle]]; }
  Vec3 to_local(const Vec3& x) const { return (x - origin) * scale; }
  Segment segment(const Vec3& from, const Vec3& to) const;
  Segment ray(const Vec3& origin, const Vec3& direction, double tnear) const;
  RTCRay embree_segment(const Segment& segment) const;
  RTCRay embree_ray(const Segment& ray) const;
  Hit hit(const Segment& ray, std::uint32_t triangle) const;
  bool crosses(const Segment& segment, const Plane& plane) const;
  static void keep_true_crossings(const RTCFilterFunctionNArguments* arguments);
};

RayScene::Impl::Impl(std::span<const BlockerPolygon> polygons) {
  Box box;
  std::size_t vertices = 0, triangles = 0;
  for (const BlockerPolygon& b : polygons) {
    box.extend(bounds(b.polygon));
    vertices += b.polygon.size();
    triangles += b.polygon.size() < 3 ? 0 : b.polygon.size() - 2;
  }
  if (!box.empty()) {
    const Vec3 e = box.extent();
    const double extent = std::max({e.x, e.y, e.z});
    ATRIUM_CHECK(std::isfinite(extent));
    origin = box.center();
    if (extent > 0) scale = std::ldexp(1.0, -std::ilogb(extent));
    end_shrink = kEndShrink * extent;
    const Vec3 far = glm::max(glm::abs(box.lo), glm::abs(box.hi));
    in_plane =
        kPlaneRoundings * std::numeric_limits<double>::epsilon() * std::max({far.x, far.y, far.z});
  }

  // A device each: it counts this scene's memory. It must not be told its number of threads, for
  // that would bind TBB in the whole process.
  device = rtcNewDevice(nullptr);
  ATRIUM_CHECK(device != nullptr);
  rtcSetDeviceErrorFunction(device, on_error, nullptr);
  rtcSetDeviceMemoryMonitorFunction(device, monitor, &embree_bytes);
  scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  if (triangles > 0) {
    const RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* at = static_cast<float*>(rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
    auto* corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles));
    faces.reserve(polygons.size());
    face_of_triangle.reserve(triangles);
    std::uint32_t first = 0;
    for (const BlockerPolygon& b : polygons) {
      const auto face_index = static_cast<std::uint32_t>(faces.size());
      faces.push_back({plane_of(b.polygon), b.id});
      const auto count = static_cast<std::uint32_t>(b.polygon.size());
      for (std::uint32_t i = 2; i < count; ++i) {
        for (const std::uint32_t corner : {0u, i - 1, i}) *corners++ = first + corner;
        face_of_triangle.push_back(face_index);
      }
      for (const Vec3& x : b.polygon) {
        const Vec3 local = to_local(x);
        for (int k = 0; k < 3; ++k) *at++ = static_cast<float>(local[k]);
      }
      first += count;
    }
    rtcSetGeometryUserData(mesh, this);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
  }
  // An arena of one thread: the same tree every time, and while it waits the thread takes up none
  // of its caller's other tasks.
  tbb::task_arena alone(1);
  alone.execute([this] { rtcCommitScene(scene); });
}

// The segment with its ends cut off; empty (tnear >= tfar) if nothing is left of it.
Segment RayScene::Impl::segment(const Vec3& from, const Vec3& to) const {
  const Vec3 along = to - from;
  const double l = length(along);
  const double shrink = l > 0 ? (end_shrink + kEndShrink * l) / l : 1;
  return {from, along, shrink, 1 - shrink};
}

Segment RayScene::Impl::ray(const Vec3& from, const Vec3& direction, double tnear) const {
  const double l = length(direction);
  ATRIUM_CHECK(l > 0 && std::isfinite(l));
  return {from, direction / l, tnear, std::numeric_limits<double>::infinity()};
}

// Does it cross the plane between its near and far limits? Not if an end lies in the plane: where
// all of it does, rounding would put the crossing anywhere.
bool RayScene::Impl::crosses(const Segment& segment, const Plane& plane) const {
  const double start = plane.distance(segment.from), slope = dot(plane.normal, segment.along);
  if (std::abs(start) <= in_plane) return false;
  if (std::isfinite(segment.tfar) && std::abs(start + slope) <= in_plane) return false;
  const double t = -start / slope;
  return t >= segment.tnear && t <= segment.tfar;
}

Hit RayScene::Impl::hit(const Segment& ray, std::uint32_t triangle) const {
  const Face& f = face(triangle);
  const double t = -f.plane.distance(ray.from) / dot(f.plane.normal, ray.along);
  return {f.id, t, ray.from + t * ray.along, f.plane.normal};
}

void RayScene::Impl::keep_true_crossings(const RTCFilterFunctionNArguments* arguments) {
  const auto& self = *static_cast<const Impl*>(arguments->geometryUserPtr);
  const Segment* segments = reinterpret_cast<const Query*>(arguments->context)->segments;
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const Segment& s = segments[RTCRayN_id(arguments->ray, n, i)];
    if (!self.crosses(s, self.face(RTCHitN_primID(arguments->hit, n, i)).plane))
      arguments->valid[i] = 0;
  }
}

namespace {

// A ray in Embree's frame. NaN or infinity in any of the six turns their sum into NaN; Embree would
// not notice.
RTCRay to_ray(const Vec3& from, const Vec3& along, double tnear, double tfar) {
  ATRIUM_CHECK(std::isfinite(from.x + from.y + from.z + along.x + along.y + along.z));
  RTCRay ray;
  ray.org_x = static_cast<float>(from.x);
  ray.org_y = static_cast<float>(from.y);
  ray.org_z = static_cast<float>(from.z);
  ray.dir_x = static_cast<float>(along.x);
  ray.dir_y = static_cast<float>(along.y);
  ray.dir_z = static_cast<float>(along.z);
  ray.tnear = static_cast<float>(tnear);
  ray.tfar = static_cast<float>(tfar);
  ray.time = 0;
  ray.mask = ~0u;
  ray.id = 0;
  ray.flags = 0;
  return ray;
}

template <class Rays>
void set_lane(Rays& rays, int lane, const RTCRay& ray) {
  rays.org_x[lane] = ray.org_x, rays.org_y[lane] = ray.org_y, rays.org_z[lane] = ray.org_z;
  rays.dir_x[lane] = ray.dir_x, rays.dir_y[lane] = ray.dir_y, rays.dir_z[lane] = ray.dir_z;
  rays.tnear[lane] = ray.tnear, rays.tfar[lane] = ray.tfar;
  rays.time[lane] = ray.time, rays.mask[lane] = ray.mask, rays.flags[lane] = ray.flags;
  rays.id[lane] = static_cast<unsigned>(lane);
}

Query make_query(const Segment* segments, RTCIntersectContextFlags flags,
                 RTCFilterFunctionN filter) {
  Query query;
  rtcInitIntersectContext(&query.context);
  query.context.flags = flags;
  query.context.filter = filter;
  query.segments = segments;
  return query;
}

}  // namespace

// Embree's t counts in lengths of `along` here, ...
RTCRay RayScene::Impl::embree_segment(const Segment& segment) const {
  const double margin = kFloatMargin * segment.tnear;
  return to_ray(to_local(segment.from), segment.along * scale, margin, 1 - margin);
}

// ... and in local lengths, metres times the scale, here.
RTCRay RayScene::Impl::embree_ray(const Segment& ray) const {
  return to_ray(to_local(ray.from), ray.along, kFloatMargin * ray.tnear * scale, kInfinity);
}

RayScene::RayScene(std::span<const BlockerPolygon> polygons)
    : impl_(std::make_unique<Impl>(polygons)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

void RayScene::occluded16(const SegmentPacket& packet, std::uint16_t& blocked_mask) const {
  alignas(64) RTCRay16 rays;
  alignas(64) int valid[kRayLanes];
  std::array<Segment, kRayLanes> segments;
  for (int i = 0; i < kRayLanes; ++i) {
    valid[i] = 0;
    if (!(packet.valid >> i & 1)) continue;
    segments[i] = impl_->segment({packet.from_x[i], packet.from_y[i], packet.from_z[i]},
                                 {packet.to_x[i], packet.to_y[i], packet.to_z[i]});
    set_lane(rays, i, impl_->embree_segment(segments[i]));
    if (segments[i].tnear < segments[i].tfar) valid[i] = -1;
  }
  Query query =
      make_query(segments.data(), RTC_INTERSECT_CONTEXT_FLAG_COHERENT, Impl::keep_true_crossings);
  rtcOccluded16(valid, impl_->scene, &query.context, &rays);
  blocked_mask = 0;
  for (int i = 0; i < kRayLanes; ++i)
    if (valid[i] && rays.tfar[i] == kBlocked)
      blocked_mask = static_cast<std::uint16_t>(blocked_mask | 1u << i);
}

bool RayScene::occluded(const Vec3& from, const Vec3& to) const {
  const Segment segment = impl_->segment(from, to);
  RTCRay ray = impl_->embree_segment(segment);
  if (!(segment.tnear < segment.tfar)) return false;
  Query query =
      make_query(&segment, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, Impl::keep_true_crossings);
  rtcOccluded1(impl_->scene, &query.context, &ray);
  return ray.tfar == kBlocked;
}

void RayScene::closest_hit16(const RayPacket& packet, HitPacket& hits) const {
  alignas(64) RTCRayHit16 rays;
  alignas(64) int valid[kRayLanes];
  std::array<Segment, kRayLanes> segments;
  for (int i = 0; i < kRayLanes; ++i) {
    valid[i] = 0;
    if (!(packet.valid >> i & 1)) continue;
    segments[i] = impl_->ray({packet.x[i], packet.y[i], packet.z[i]},
                             {packet.dx[i], packet.dy[i], packet.dz[i]}, packet.near[i]);
    set_lane(rays.ray, i, impl_->embree_ray(segments[i]));
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    valid[i] = -1;
  }
  Query query =
      make_query(segments.data(), RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, Impl::keep_true_crossings);
  rtcIntersect16(valid, impl_->scene, &query.context, &rays);
  hits.found = 0;
  for (int i = 0; i < kRayLanes; ++i) {
    if (!valid[i] || rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    hits.found = static_cast<std::uint16_t>(hits.found | 1u << i);
    hits.hit[i] = impl_->hit(segments[i], rays.hit.primID[i]);
  }
}

std::optional<Hit> RayScene::closest_hit(const Vec3& origin, const Vec3& direction,
                                         double tnear) const {
  const Segment segment = impl_->ray(origin, direction, tnear);
  RTCRayHit ray;
  ray.ray = impl_->embree_ray(segment);
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  Query query =
      make_query(&segment, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, Impl::keep_true_crossings);
  rtcIntersect1(impl_->scene, &query.context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return impl_->hit(segment, ray.hit.primID);
}

std::size_t RayScene::bytes() const {
  return sizeof(Impl) + static_cast<std::size_t>(impl_->embree_bytes.load()) +
         impl_->faces.capacity() * sizeof(Impl::Face) +
         impl_->face_of_triangle.capacity() * sizeof(std::uint32_t);
}

}  // namespace atrium
