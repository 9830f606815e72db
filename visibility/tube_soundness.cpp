#include "visibility/tube_soundness.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "visibility/segment_words.h"
#include "visibility/shaft.h"

namespace atrium {

namespace {

// As deep as the solver's links mostly go below their patches, both ends together.
constexpr std::size_t kDeepest = 12;

// Ends are no narrower than so many times the nearest that faces are told apart.
constexpr double kFinestNears = 30;

}  // namespace

// One end of a tube: what is left of a patch around a point of it.
struct TubeJudge::End {
  PatchId patch;
  Plane plane;
  Vec3 kept{0};  // the point that halving keeps
  Polygon polygon;

  void halve() {
    const Frame frame = frame_of(polygon);
    Vec2 lo{0}, hi{0};
    for (const Vec3& x : polygon) {
      const Vec2 at = frame.to_plane(x);
      lo = glm::min(lo, at);
      hi = glm::max(hi, at);
    }
    const Vec3 across = hi.x - lo.x >= hi.y - lo.y ? frame.u : frame.v;
    Plane cut{across, dot(across, frame.origin)};
    if (cut.distance(kept) < 0) cut = cut.flipped();
    Polygon half = clip(polygon, cut, 0);
    if (half.size() >= 3) polygon = std::move(half);
  }
};

TubeJudge::TubeJudge(const Scene& scene, const Model& model, const PatchSampler& sampler,
                     const SecondLook& look, std::span<const BlockerPolygon> surfaces,
                     const RayScene& rays)
    : scene_(scene),
      model_(model),
      sampler_(sampler),
      look_(look),
      rays_(rays),
      index_(surfaces),
      finest_(kFinestNears * look.near()) {}

void TubeJudge::judge(RandomStream& random, TubeTally& tally) const {
  const auto& clusters = sampler_.lit_clusters();
  const ClusterId receiver = clusters[random.below(clusters.size())];
  const auto row = model_.visible[receiver.value];
  if (row.empty()) return;
  const ClusterId source = row[random.below(row.size())];
  if (!sampler_.lit(source)) return;
  const auto end = [&](ClusterId cluster) {
    const PatchPoint drawn = sampler_.of_cluster(cluster, random);
    const PolygonView polygon = model_.polygon(model_.patches[drawn.patch.value]);
    return End{drawn.patch, sampler_.plane(drawn.patch), drawn.at,
               Polygon(polygon.begin(), polygon.end())};
  };
  End p = end(receiver), q = end(source);
  if (p.plane.distance(q.kept) <= look_.width() || q.plane.distance(p.kept) <= look_.width())
    return;

  const auto pair = [&] {
    return PolygonPair{p.polygon, p.plane.normal, q.polygon, q.plane.normal};
  };
  Tube tube = make_tube(pair(), index_, model_.tolerance);
  Variety found = variety(tube, pair(), index_, model_.tolerance);
  for (std::size_t left = random.below(kDeepest + 1); left > 0; --left) {
    End& halved = random.below(2) == 0 ? p : q;
    if (area(halved.polygon) < finest_ * finest_) continue;
    halved.halve();
    tube = subdivide(Tube(tube), pair(), index_, model_.tolerance);
    found = variety(tube, pair(), index_, model_.tolerance);
  }
  shoot(p, q, found, random, tally);
}

void TubeJudge::shoot(const End& p, const End& q, Variety found, RandomStream& random,
                      TubeTally& tally) const {
  ++(found == Variety::INVISIBLE ? tally.counts.invisible
     : found == Variety::VISIBLE ? tally.counts.visible
                                 : tally.counts.partial);
  if (found == Variety::PARTIAL) return;
  std::array<Vec3, kRayLanes> from, to;
  SegmentPacket packet;
  for (int i = 0; i < kRayLanes; ++i) {
    from[i] = point_of(p.polygon, random.square());
    to[i] = point_of(q.polygon, random.square());
    if (p.plane.distance(to[i]) > look_.width() && q.plane.distance(from[i]) > look_.width())
      packet.set(i, from[i], to[i]);
  }
  std::uint16_t blocked = 0;
  rays_.occluded16(packet, blocked);
  const std::uint16_t accusing =
      static_cast<std::uint16_t>(packet.valid & (found == Variety::INVISIBLE ? ~blocked : blocked));
  for (int i = 0; i < kRayLanes; ++i) {
    if (!(accusing >> i & 1)) continue;
    const bool through = found == Variety::INVISIBLE;
    if (through ? !wrongly_invisible(from[i], to[i], p, q) : !wrongly_visible(from[i], to[i], p, q))
      continue;
    ++(through ? tally.counts.wrongly_invisible : tally.counts.wrongly_visible);
    note(tally.examples, [&] {
      return segment_words(scene_, model_, p.patch, from[i], q.patch, to[i]) +
             (through ? "gets through a tube called INVISIBLE"
                      : "is blocked in a tube called VISIBLE");
    });
  }
}

bool TubeJudge::wrongly_invisible(const Vec3& x, const Vec3& y, const End& p, const End& q) const {
  const FacePoint from{x, p.plane}, to{y, q.plane};
  return !look_.crowded(from) && !look_.crowded(to) && look_.surely_free(from, to);
}

// Only what reaches into the shaft deeper than the tolerance blocks, and it may stand behind what
// does not.
bool TubeJudge::wrongly_visible(const Vec3& x, const Vec3& y, const End& p, const End& q) const {
  const Shaft shaft =
      make_shaft(p.polygon, p.plane.normal, q.polygon, q.plane.normal, model_.tolerance);
  if (shaft.closed) return true;
  const auto deep = [&](const Vec3& z) {
    return std::ranges::all_of(shaft.sides(),
                               [&](const Plane& side) { return side.distance(z) > look_.width(); });
  };
  const double whole = length(y - x);
  for (double t = look_.near(); t < whole;) {
    const std::optional<Hit> hit = rays_.closest_hit(x, y - x, t);
    if (!hit || hit->t >= whole) return false;
    const std::optional<FacePoint> z = look_.sure_crossing(x, y, SurfaceId(hit->id));
    if (z && deep(z->at)) return true;
    t = std::nextafter(hit->t + look_.width(), whole);
  }
  return false;
}

}  // namespace atrium
