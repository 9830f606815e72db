#include "scheduler/fresh_gather.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "scheduler/solution.h"
#include "solver/sample_sequence.h"

namespace atrium {

namespace {

// So many directions a batch, or one point's where those are more.
constexpr std::size_t kDirectionsABatch = std::size_t{1} << 16;
// What the ends of their rays take, those of as many shadow rays and the list of all that are lit.
constexpr std::size_t kBatchBytes = std::size_t{11} << 20;
// Ends read off by one task: what it costs to start one is little beside them.
constexpr std::size_t kEndsATask = 512;
// A surface met from behind: its other side lies within so many tolerances.
constexpr double kOtherSide = 10;
// The two uses of a replicate's random numbers.
constexpr std::uint64_t kDirections = 0, kShadows = 1;

Box bounds_of(const Model& model) {
  Box box;
  for (const Vec3& v : model.vertices) box.extend(v);
  return box;
}

// A row a patch: the patches of the same surface's other side.
Rows<PatchId> find_other_sides(const Model& model) {
  std::vector<std::uint32_t> by_surface(model.patches.size());
  std::iota(by_surface.begin(), by_surface.end(), 0u);
  const auto surface = [&](std::uint32_t p) { return model.patches[p].surface; };
  std::stable_sort(by_surface.begin(), by_surface.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return surface(a) < surface(b); });
  std::vector<std::uint32_t> first(model.patches.size());  // of its surface, in by_surface
  for (std::uint32_t i = 0; i < by_surface.size(); ++i)
    first[by_surface[i]] = i > 0 && surface(by_surface[i]) == surface(by_surface[i - 1])
                               ? first[by_surface[i - 1]]
                               : i;
  Rows<PatchId> rows;
  std::vector<PatchId> row;
  for (std::uint32_t p = 0; p < model.patches.size(); ++p) {
    row.clear();
    for (std::uint32_t i = first[p]; i < by_surface.size() && surface(by_surface[i]) == surface(p);
         ++i)
      if (model.patches[by_surface[i]].back != model.patches[p].back)
        row.push_back(PatchId(by_surface[i]));
    rows.push_row(row);
  }
  return rows;
}

}  // namespace

// What a ray met, and what it brings.
struct FreshGather::RayEnd {
  enum : std::uint32_t { kEscaped = PatchId::kNone, kBlack = PatchId::kNone - 1 };
  static constexpr std::int32_t kNoSource = -1;
  std::uint32_t patch = kEscaped;
  std::uint32_t replicate = 0;
  std::int32_t source = kNoSource;  // of a shadow ray: the bright element that it goes to
  bool bright = false;              // on a bright element
  double weight = 0;                // of the radiosity
  Vec3 x{0};
  Spectrum arriving{0};  // lx
  bool lit() const { return patch < kBlack; }
  bool shadow() const { return source != kNoSource; }
};

// Points of consecutive numbers in the order of their rooms, and their rays.
struct FreshGather::Batch {
  static_assert(2 * kDirectionsABatch *
                    (sizeof(RayEnd) + sizeof(RayEnd*) + sizeof(std::uint64_t)) ==
                kBatchBytes);

  std::span<const GatherPoint> points;     // all of the caller's
  std::span<const std::uint32_t> numbers;  // of this batch's, room by room
  FreshSettings settings;
  const BrightSources* bright = nullptr;
  std::vector<RayEnd> ends;                 // points × directions
  std::vector<std::vector<RayEnd>> shadow;  // by point: those to bright elements
  std::vector<Spectrum> direct;             // points × replicates: of lamps, lx
  std::vector<RayEnd*> lit;                 // of the ends, those that bring light
  std::vector<std::uint64_t> by_patch;      // patch and place in `lit`, sorted

  std::size_t directions() const { return static_cast<std::size_t>(settings.directions); }
  std::size_t replicates() const { return static_cast<std::size_t>(settings.replicates); }
  // Directions of replicate r.
  std::size_t count(std::size_t r) const {
    return (r + 1) * directions() / replicates() - r * directions() / replicates();
  }
  const GatherPoint& point(std::size_t i) const { return points[numbers[i]]; }
  std::span<RayEnd> ends_of(std::size_t i) {
    return std::span(ends).subspan(i * directions(), directions());
  }
};

FreshGather::FreshGather(const Model& model, ClusterStore& store, RayWorlds& worlds)
    : model_(model),
      store_(store),
      worlds_(worlds),
      grid_(model, bounds_of(model), kOtherSide * model.tolerance),
      other_sides_(find_other_sides(model)),
      batch_(std::make_unique<Batch>()) {}
FreshGather::~FreshGather() = default;

const RayWorld& FreshGather::world_of(ClusterId cluster) {
  if (cluster.valid()) return worlds_.of(cluster);
  if (!everything_) {
    std::vector<ClusterId> all;
    for (std::size_t c = 0; c < model_.clusters.size(); ++c) all.push_back(ClusterId(c));
    everything_ = std::make_unique<RayWorld>(model_, all, RayUse::kAlways);
  }
  return *everything_;
}

// Light that meets a surface from behind meets its other side, or what else closes with it; the
// black back of one-sided surfaces where there is neither.
PatchId FreshGather::facing_side(const Hit& hit, const Vec3& direction) const {
  if (dot(hit.normal, direction) < 0) return PatchId(hit.id);
  const double tolerance = kOtherSide * model_.tolerance;
  for (const PatchId other : other_sides_[hit.id])
    if (contains(model_.polygon(model_.patches[other.value]), -hit.normal, hit.point, tolerance))
      return other;
  return grid_.find(hit.point, -hit.normal, tolerance).value_or(PatchId());
}

// What tracing a point works in, point after point.
struct FreshGather::Scratch {
  std::vector<Vec3> along;
  std::vector<Glance> glances;
  std::vector<Due> due;
  std::vector<ShadowRay> shadow;
};

// The replicates' cosine-weighted rays, packet by packet.
void FreshGather::send_out(const RayScene& scene, const GatherPoint& point,
                           std::span<const Vec3> along, std::span<RayEnd> ends) const {
  for (std::size_t first = 0; first < along.size(); first += kRayLanes) {
    RayPacket packet;
    const std::size_t lanes = std::min<std::size_t>(kRayLanes, along.size() - first);
    for (std::size_t k = 0; k < lanes; ++k)
      packet.set(static_cast<int>(k), point.x, along[first + k], model_.tolerance);
    HitPacket hits;
    scene.closest_hit16(packet, hits);
    for (std::size_t k = 0; k < lanes; ++k) {
      if (!(hits.found >> k & 1)) continue;
      const PatchId side = facing_side(hits.hit[k], along[first + k]);
      const bool lit = side.valid() && !model_.patches[side.value].inert;
      ends[first + k].patch = lit ? side.value : RayEnd::kBlack;
      ends[first + k].x = hits.hit[k].point;
    }
  }
}

void FreshGather::trace_point(const RayScene& scene, std::size_t i, Batch& batch,
                              Scratch& scratch) const {
  const GatherPoint& point = batch.point(i);
  const std::uint64_t key = derived(batch.settings.seed, batch.numbers[i]);
  const std::span<RayEnd> ends = batch.ends_of(i);
  const Frame frame = frame_about(point.normal);
  scratch.along.clear();
  scratch.due.clear();
  for (std::uint32_t r = 0; r < batch.replicates(); ++r) {
    const std::size_t count = batch.count(r);
    const SampleSequence sequence(derived(derived(key, r), kDirections));
    for (std::uint32_t k = 0; k < count; ++k) {
      RayEnd& end = ends[scratch.along.size()];
      end = {};
      end.replicate = r;
      end.weight = 1 / static_cast<double>(count);
      scratch.along.push_back(cosine_direction(frame, sequence.at(k)));
    }
    scratch.due.push_back({static_cast<int>(count), derived(derived(key, r), kShadows)});
  }
  send_out(scene, point, scratch.along, ends);

  batch.bright->look(point.x, point.normal, point.cluster, scratch.glances);
  deal_shadow_rays(point.x, point.normal, scratch.glances, scratch.due, scratch.shadow);
  keep_seen(point.x, scene, scratch.shadow);
  const std::span<Spectrum> direct =
      std::span(batch.direct).subspan(i * batch.replicates(), batch.replicates());
  std::fill(direct.begin(), direct.end(), Spectrum{0});
  batch.shadow[i].clear();
  for (const ShadowRay& s : scratch.shadow) {
    if (s.source->lamp())
      direct[s.replicate] += s.weight * s.source->radiosity;
    else
      batch.shadow[i].push_back({s.source->patch.value, s.replicate, s.source->element, true,
                                 s.weight, s.x, Spectrum{0}});
  }
}

void FreshGather::trace_room(const RayScene& scene, std::size_t first, std::size_t last,
                             Batch& batch) const {
  tbb::parallel_for(tbb::blocked_range(first, last), [&](const auto& range) {
    Scratch scratch;
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      trace_point(scene, i, batch, scratch);
  });
}

// Room by room, since each has a ray structure of its own.
void FreshGather::trace(Batch& batch) {
  const auto room = [&](std::size_t i) {
    const ClusterId c = batch.point(i).cluster;
    return c.valid() ? model_.clusters[c.value].room : model_.rooms;
  };
  for (std::size_t first = 0, last = 0; first < batch.numbers.size(); first = last) {
    while (last < batch.numbers.size() && room(last) == room(first)) ++last;
    const RayWorld& world = world_of(batch.point(first).cluster);
    if (const RayScene* rays = world.surroundings().rays) {
      trace_room(*rays, first, last, batch);
    } else {  // a convex empty room: few polygons
      trace_room(RayScene(world.outlines()), first, last, batch);
    }
  }
}

// What a ray brings of the patch that it met. What shadow rays bring is not brought again.
void FreshGather::arrive(RayEnd& end, const PatchView& patch, const BrightSources& bright) const {
  const Vec2 p = patch.head->frame.to_plane(end.x);
  const std::int32_t leaf = leaf_at(patch, p, std::max(0, end.source));
  if (!end.shadow()) end.bright = bright.reflects_brightly(patch, leaf);
  Spectrum b{0};
  if (end.shadow() == end.bright) b += patch.head->reflectance * polynomial_at(patch, leaf, p);
  if (!end.shadow() && !bright.is_lamp(PatchId(end.patch))) b += patch.head->exitance;
  end.arriving = end.weight * b;
}

// What each ray brings, source by source.
Status FreshGather::read_off(Batch& batch) {
  // By patch, those of a cluster being contiguous, then by the ray's number.
  constexpr int kNumberBits = 32;
  std::vector<std::uint64_t>& lit = batch.by_patch;
  lit.clear();
  batch.lit.clear();
  const auto list = [&](RayEnd& end) {
    if (!end.lit()) return;
    lit.push_back(std::uint64_t{end.patch} << kNumberBits | batch.lit.size());
    batch.lit.push_back(&end);
  };
  for (std::size_t i = 0; i < batch.numbers.size(); ++i) {
    for (RayEnd& end : batch.ends_of(i)) list(end);
    for (RayEnd& end : batch.shadow[i]) list(end);
  }
  std::sort(lit.begin(), lit.end());
  const auto patch_of = [&](std::size_t k) { return std::uint32_t(lit[k] >> kNumberBits); };
  const auto cluster_of = [&](std::size_t k) { return model_.patches[patch_of(k)].cluster; };
  for (std::size_t first = 0, last = 0; first < lit.size(); first = last) {
    const ClusterId cluster = cluster_of(first);
    while (last < lit.size() && cluster_of(last) == cluster) ++last;
    const Result<ClusterPin> pin = store_.read(record_id(RecordKind::kCluster, cluster.value));
    if (!pin.ok()) return pin.status();
    const Result<ClusterView> view = ClusterView::parse(pin->bytes());
    if (!view.ok()) return view.status();
    const std::uint32_t first_patch = model_.clusters[cluster.value].first_patch;
    const auto arrive_each = [&](const auto& range) {
      for (std::size_t k = range.begin(); k < range.end(); ++k)
        arrive(*batch.lit[std::uint32_t(lit[k])], view->patch(patch_of(k) - first_patch),
               *batch.bright);
    };
    tbb::parallel_for(tbb::blocked_range(first, last, kEndsATask), arrive_each,
                      tbb::simple_partitioner());
  }
  return {};
}

void FreshGather::conclude(Batch& batch, std::size_t i, FreshIrradiance& result,
                           RayShares* shares) const {
  const double share = 1 / static_cast<double>(batch.directions());
  const double n = static_cast<double>(batch.replicates());
  double* const row = shares ? &shares->of_point[batch.numbers[i] * shares->groups] : nullptr;
  std::vector<Spectrum> sums(batch.direct.begin() + std::ptrdiff_t(i * batch.replicates()),
                             batch.direct.begin() + std::ptrdiff_t((i + 1) * batch.replicates()));
  const auto group = [&](const RayEnd& end) {
    return row + shares->group_of_cluster[model_.patches[end.patch].cluster.value];
  };
  for (const RayEnd& end : batch.ends_of(i)) {
    sums[end.replicate] += end.arriving;
    result.escaped += end.patch == RayEnd::kEscaped ? share : 0;
    result.black += end.patch == RayEnd::kBlack ? share : 0;
    if (row && end.lit() && !end.bright) group(end)[0] += share;
  }
  for (const RayEnd& end : batch.shadow[i]) {
    sums[end.replicate] += end.arriving;
    if (row) group(end)[1] += luminance(end.arriving) / n;
  }
  Spectrum squares{0};
  for (const Spectrum& e : sums) result.mean += e / n;
  for (const Spectrum& e : sums) squares += (e - result.mean) * (e - result.mean);
  for (int c = 0; c < kChannels && batch.replicates() > 1; ++c)
    result.standard_error[c] = std::sqrt(squares[c] / (n * (n - 1)));
}

Result<std::vector<FreshIrradiance>> FreshGather::gather(const BrightSources& bright,
                                                         std::span<const GatherPoint> points,
                                                         const FreshSettings& settings,
                                                         RayShares* shares) {
  ATRIUM_CHECK(settings.replicates >= 1 && settings.directions >= settings.replicates);
  std::vector<FreshIrradiance> results(points.size());
  if (shares) shares->of_point.assign(points.size() * shares->groups, 0.0);
  std::vector<std::uint32_t> by_room(points.size());
  std::iota(by_room.begin(), by_room.end(), 0u);
  const auto room = [&](std::uint32_t i) {
    const ClusterId c = points[i].cluster;
    return c.valid() ? model_.clusters[c.value].room : model_.rooms;
  };
  std::stable_sort(by_room.begin(), by_room.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return room(a) < room(b); });
  Batch& batch = *batch_;
  batch.points = points;
  batch.bright = &bright;
  batch.settings = settings;
  const std::size_t most = std::max<std::size_t>(1, kDirectionsABatch / batch.directions());
  for (std::size_t first = 0; first < by_room.size(); first += most) {
    batch.numbers = std::span(by_room).subspan(first, std::min(most, by_room.size() - first));
    batch.ends.resize(batch.numbers.size() * batch.directions());
    batch.shadow.resize(std::max(batch.shadow.size(), batch.numbers.size()));
    batch.direct.resize(batch.numbers.size() * batch.replicates());
    trace(batch);
    ATRIUM_RETURN_IF_ERROR(read_off(batch));
    tbb::parallel_for(std::size_t(0), batch.numbers.size(), [&](std::size_t i) {
      conclude(batch, i, results[batch.numbers[i]], shares);
    });
  }
  return results;
}

}  // namespace atrium
