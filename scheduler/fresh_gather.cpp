#include "scheduler/fresh_gather.h"

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
constexpr std::size_t kBatchBytes = std::size_t{10} << 20;
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
  std::uint32_t patch = kEscaped;
  std::uint32_t replicate = 0;
  bool shadow = false;  // to a bright element, for what that reflects
  bool bright = false;  // on a bright element
  double weight = 0;    // of the radiosity
  Vec3 x{0};
  Spectrum arriving{0};  // lx
  bool lit() const { return patch < kBlack; }
};

// Points of consecutive numbers in the order of their rooms, and their rays.
struct FreshGather::Batch {
  static_assert(2 * kDirectionsABatch * (sizeof(RayEnd) + sizeof(RayEnd*)) == kBatchBytes);

  std::span<const GatherPoint> points;     // all of the caller's
  std::span<const std::uint32_t> numbers;  // of this batch's, room by room
  FreshSettings settings;
  const BrightSources* bright = nullptr;
  std::vector<std::vector<RayEnd>> ends;  // by point: the directions', then shadow rays'
  std::vector<Spectrum> direct;           // points × replicates: of lamps, lx

  std::size_t directions() const { return static_cast<std::size_t>(settings.directions); }
  std::size_t replicates() const { return static_cast<std::size_t>(settings.replicates); }
  // Directions of replicate r.
  std::size_t count(std::size_t r) const {
    return (r + 1) * directions() / replicates() - r * directions() / replicates();
  }
  const GatherPoint& point(std::size_t i) const { return points[numbers[i]]; }
};

FreshGather::FreshGather(const Model& model, ClusterStore& store, RayWorlds& worlds)
    : model_(model),
      store_(store),
      worlds_(worlds),
      grid_(model, bounds_of(model), kOtherSide * model.tolerance),
      other_sides_(find_other_sides(model)) {}

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

// A replicate's cosine-weighted rays.
void FreshGather::send_out(const RayScene& scene, const GatherPoint& point, std::uint32_t replicate,
                           std::size_t count, std::uint64_t key, std::vector<RayEnd>& ends) const {
  const Frame frame = frame_about(point.normal);
  const SampleSequence sequence(key);
  for (std::size_t first = 0; first < count; first += kRayLanes) {
    RayPacket packet;
    std::array<Vec3, kRayLanes> along;
    const std::size_t lanes = std::min<std::size_t>(kRayLanes, count - first);
    for (std::size_t k = 0; k < lanes; ++k) {
      along[k] = cosine_direction(frame, sequence.at(static_cast<std::uint32_t>(first + k)));
      packet.set(static_cast<int>(k), point.x, along[k], model_.tolerance);
    }
    HitPacket hits;
    scene.closest_hit16(packet, hits);
    for (std::size_t k = 0; k < lanes; ++k) {
      RayEnd& end = ends.emplace_back();
      end.replicate = replicate;
      if (!(hits.found >> k & 1)) continue;
      const PatchId side = facing_side(hits.hit[k], along[k]);
      const bool lit = side.valid() && !model_.patches[side.value].inert;
      end.patch = lit ? side.value : RayEnd::kBlack;
      end.weight = 1 / static_cast<double>(count);
      end.x = hits.hit[k].point;
    }
  }
}

void FreshGather::trace_point(const RayScene& scene, std::size_t i, Batch& batch) const {
  const GatherPoint& point = batch.point(i);
  std::vector<RayEnd>& ends = batch.ends[i];
  ends.clear();
  const std::uint64_t key = derived(batch.settings.seed, batch.numbers[i]);
  for (std::uint32_t r = 0; r < batch.replicates(); ++r)
    send_out(scene, point, r, batch.count(r), derived(derived(key, r), kDirections), ends);
  std::vector<SourcePiece> pieces;
  batch.bright->look(point.x, point.normal, point.cluster, pieces);
  std::vector<SeenSource> seen;
  for (std::uint32_t r = 0; r < batch.replicates(); ++r) {
    seen.clear();
    cast_shadow_rays(point.x, point.normal, pieces, scene, static_cast<int>(batch.count(r)),
                     derived(derived(key, r), kShadows), seen);
    Spectrum& direct = batch.direct[i * batch.replicates() + r];
    direct = Spectrum{0};
    for (const SeenSource& s : seen)
      if (s.source->lamp())
        direct += s.weight * s.source->radiosity;
      else
        ends.push_back({s.source->patch.value, r, true, true, s.weight, s.x, Spectrum{0}});
  }
}

void FreshGather::trace_room(const RayScene& scene, std::size_t first, std::size_t last,
                             Batch& batch) const {
  tbb::parallel_for(first, last, [&](std::size_t i) { trace_point(scene, i, batch); });
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
  const std::int32_t leaf = leaf_at(patch, p);
  end.bright = bright.reflects_brightly(patch, leaf);
  Spectrum b{0};
  if (end.shadow == end.bright) b += patch.head->reflectance * polynomial_at(patch, leaf, p);
  if (!end.shadow && !bright.is_lamp(PatchId(end.patch))) b += patch.head->exitance;
  end.arriving = end.weight * b;
}

// What each ray brings, source by source.
Status FreshGather::read_off(Batch& batch) {
  std::vector<RayEnd*> lit;
  for (std::vector<RayEnd>& ends : batch.ends)
    for (RayEnd& end : ends)
      if (end.lit()) lit.push_back(&end);
  // Patches of a cluster are contiguous.
  std::sort(lit.begin(), lit.end(),
            [](const RayEnd* a, const RayEnd* b) { return a->patch < b->patch; });
  const auto cluster_of = [&](std::size_t k) { return model_.patches[lit[k]->patch].cluster; };
  for (std::size_t first = 0, last = 0; first < lit.size(); first = last) {
    const ClusterId cluster = cluster_of(first);
    while (last < lit.size() && cluster_of(last) == cluster) ++last;
    const Result<ClusterPin> pin = store_.read(record_id(RecordKind::kCluster, cluster.value));
    if (!pin.ok()) return pin.status();
    const Result<ClusterView> view = ClusterView::parse(pin->bytes());
    if (!view.ok()) return view.status();
    const std::uint32_t first_patch = model_.clusters[cluster.value].first_patch;
    tbb::parallel_for(first, last, [&](std::size_t k) {
      arrive(*lit[k], view->patch(lit[k]->patch - first_patch), *batch.bright);
    });
  }
  return {};
}

void FreshGather::conclude(const Batch& batch, std::size_t i, FreshIrradiance& result,
                           RayShares* shares) const {
  const double share = 1 / static_cast<double>(batch.directions());
  const double n = static_cast<double>(batch.replicates());
  double* const row = shares ? &shares->of_point[batch.numbers[i] * shares->groups] : nullptr;
  std::vector<Spectrum> sums(batch.direct.begin() + std::ptrdiff_t(i * batch.replicates()),
                             batch.direct.begin() + std::ptrdiff_t((i + 1) * batch.replicates()));
  for (const RayEnd& end : batch.ends[i]) {
    sums[end.replicate] += end.arriving;
    if (!end.shadow) {
      result.escaped += end.patch == RayEnd::kEscaped ? share : 0;
      result.black += end.patch == RayEnd::kBlack ? share : 0;
    }
    if (!row || !end.lit()) continue;
    double* const at = row + shares->group_of_cluster[model_.patches[end.patch].cluster.value];
    if (end.shadow)
      at[1] += luminance(end.arriving) / n;
    else if (!end.bright)
      at[0] += share;
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
  Batch batch;
  batch.points = points;
  batch.bright = &bright;
  batch.settings = settings;
  const std::size_t most = std::max<std::size_t>(1, kDirectionsABatch / batch.directions());
  for (std::size_t first = 0; first < by_room.size(); first += most) {
    batch.numbers = std::span(by_room).subspan(first, std::min(most, by_room.size() - first));
    batch.ends.resize(batch.numbers.size());
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
