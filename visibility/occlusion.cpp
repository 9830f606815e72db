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
constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr float kBlocked = -kInfinity;  // what Embree sets tfar to

// Float is asked from this share of the shrunk end on: it may place a crossing a little off, and
// the decision is double's.
constexpr double kFloatMargin = 0.5;

// An end lies in a plane if nearer to it than this many roundings of the largest coordinate.
constexpr double kPlaneRoundings = 64;

using Lanes = RayPacket::Lanes;
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
  void set_segments(const SegmentPacket& packet, std::span<Segment> segments,
                    RTCRay16& rays) const;
  void set_rays(const RayPacket& packet, std::span<Segment> segments, RTCRay16& rays) const;
  void set_origins(const Lanes& x, const Lanes& y, const Lanes& z, RTCRay16& rays) const;
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
  return {from, direction / l, tnear, kForever};
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

// NaN or infinity in any of the six turns their sum into NaN; Embree would not notice.
void check_finite(const Vec3& from, const Vec3& along) {
  ATRIUM_CHECK(std::isfinite(from.x + from.y + from.z + along.x + along.y + along.z));
}

// A ray in Embree's frame.
RTCRay to_ray(const Vec3& from, const Vec3& along, double tnear, double tfar) {
  check_finite(from, along);
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

// The same of whole packets, lane beside lane.
void RayScene::Impl::set_segments(const SegmentPacket& packet, std::span<Segment> segments,
                                  RTCRay16& rays) const {
  Lanes x, y, z, near;  // along
  for (int i = 0; i < kRayLanes; ++i) {
    x[i] = packet.to_x[i] - packet.from_x[i];
    y[i] = packet.to_y[i] - packet.from_y[i];
    z[i] = packet.to_z[i] - packet.from_z[i];
  }
  for (int i = 0; i < kRayLanes; ++i) {
    const double l = std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
    near[i] = (end_shrink + kEndShrink * l) / l;
  }
  set_origins(packet.from_x, packet.from_y, packet.from_z, rays);
  for (int i = 0; i < kRayLanes; ++i) {
    rays.dir_x[i] = static_cast<float>(x[i] * scale);
    rays.dir_y[i] = static_cast<float>(y[i] * scale);
    rays.dir_z[i] = static_cast<float>(z[i] * scale);
    rays.tnear[i] = static_cast<float>(kFloatMargin * near[i]);
    rays.tfar[i] = static_cast<float>(1 - kFloatMargin * near[i]);
  }
  for (int i = 0; i < kRayLanes; ++i) {
    if (!(packet.valid >> i & 1)) continue;
    const Vec3 from{packet.from_x[i], packet.from_y[i], packet.from_z[i]};
    segments[i] = {from, {x[i], y[i], z[i]}, near[i], 1 - near[i]};
    check_finite(from, segments[i].along);
  }
}

void RayScene::Impl::set_rays(const RayPacket& packet, std::span<Segment> segments,
                              RTCRay16& rays) const {
  Lanes x, y, z;  // along
  for (int i = 0; i < kRayLanes; ++i) {
    const double l = std::sqrt(packet.dx[i] * packet.dx[i] + packet.dy[i] * packet.dy[i] +
                               packet.dz[i] * packet.dz[i]);
    x[i] = packet.dx[i] / l, y[i] = packet.dy[i] / l, z[i] = packet.dz[i] / l;
  }
  set_origins(packet.x, packet.y, packet.z, rays);
  for (int i = 0; i < kRayLanes; ++i) {
    rays.dir_x[i] = static_cast<float>(x[i]);
    rays.dir_y[i] = static_cast<float>(y[i]);
    rays.dir_z[i] = static_cast<float>(z[i]);
    rays.tnear[i] = static_cast<float>(kFloatMargin * packet.near[i] * scale);
    rays.tfar[i] = kInfinity;
  }
  for (int i = 0; i < kRayLanes; ++i) {
    if (!(packet.valid >> i & 1)) continue;
    const Vec3 from{packet.x[i], packet.y[i], packet.z[i]};
    segments[i] = {from, {x[i], y[i], z[i]}, packet.near[i], kForever};
    check_finite(from, segments[i].along);
  }
}

// And all that is no segment's own.
void RayScene::Impl::set_origins(const Lanes& x, const Lanes& y, const Lanes& z,
                                 RTCRay16& rays) const {
  for (int i = 0; i < kRayLanes; ++i) {
    rays.org_x[i] = static_cast<float>((x[i] - origin.x) * scale);
    rays.org_y[i] = static_cast<float>((y[i] - origin.y) * scale);
    rays.org_z[i] = static_cast<float>((z[i] - origin.z) * scale);
    rays.time[i] = 0;
    rays.mask[i] = ~0u;
    rays.flags[i] = 0;
    rays.id[i] = static_cast<unsigned>(i);
  }
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
  impl_->set_segments(packet, segments, rays);
  for (int i = 0; i < kRayLanes; ++i)
    valid[i] = (packet.valid >> i & 1) && segments[i].tnear < segments[i].tfar ? -1 : 0;
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

// Nearly all that float hits first is hit in double too: so Embree is asked for that alone, and
// where it is not, again, with each crossing held against its plane on the way.
void RayScene::closest_hit16(const RayPacket& packet, HitPacket& hits) const {
  alignas(64) RTCRayHit16 rays;
  alignas(64) int valid[kRayLanes];
  std::array<Segment, kRayLanes> segments;
  impl_->set_rays(packet, segments, rays.ray);
  for (int i = 0; i < kRayLanes; ++i) {
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    valid[i] = packet.valid >> i & 1 ? -1 : 0;
  }
  const RTCIntersectContextFlags flags = packet.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                         : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  const auto intersect = [&](RTCFilterFunctionN filter) {
    Query query = make_query(segments.data(), flags, filter);
    rtcIntersect16(valid, impl_->scene, &query.context, &rays);
  };
  intersect(nullptr);
  bool all_true = true;
  for (int i = 0; i < kRayLanes; ++i) {
    if (!valid[i] || rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ||
        impl_->crosses(segments[i], impl_->face(rays.hit.primID[i]).plane)) {
      valid[i] = 0;
      continue;
    }
    all_true = false;
    rays.ray.tfar[i] = kInfinity;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  if (!all_true) intersect(Impl::keep_true_crossings);
  hits.found = 0;
  for (int i = 0; i < kRayLanes; ++i) {
    if (!(packet.valid >> i & 1) || rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
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
