#include "scheduler/fresh_gather.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "scheduler/leaves.h"
#include "scheduler/solution.h"
#include "scheduler/stored_patches.h"
#include "solver/sample_sequence.h"

namespace atrium {

namespace {

// So many directions a batch, or one point's where those are more.
constexpr std::size_t kDirectionsABatch = std::size_t{1} << 16;
// What the ends of their rays take, those of as many shadow rays and the list of all that are lit.
constexpr std::size_t kBatchBytes = std::size_t{12} << 20;
// So many go out together, or one point's: packets of them are narrow, and their origins near.
constexpr std::size_t kDirectionsTogether = 512;
// How finely they are sorted for that, along each side of the square that they are drawn from.
constexpr int kCells = 16;
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

// Neighbours in this order are neighbours in the square: up one column and down the next.
std::uint32_t cell_of(const Vec2& square) {
  const int column = static_cast<int>(kCells * square.y), row = static_cast<int>(kCells * square.x);
  return static_cast<std::uint32_t>(column * kCells + (column % 2 ? kCells - 1 - row : row));
}

// Numbers 0 to n - 1 in the order of their keys, those of equal keys in their own.
void sort_by_cell(std::span<const std::uint32_t> cells, std::vector<std::uint32_t>& order) {
  std::array<std::uint32_t, kCells * kCells + 1> next{};
  for (const std::uint32_t cell : cells) ++next[cell + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  order.resize(cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) order[next[cells[i]]++] = i;
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
  bool bright = false;  // on a bright element
  Vec3 x{0};
  Spectrum radiosity{0};  // that counts, lm/m²
  bool lit() const { return patch < kBlack; }
};

// The same of a ray to a bright element.
struct FreshGather::ShadowEnd {
  RayEnd end;
  std::int32_t source = 0;
  std::uint32_t replicate = 0;
  double weight = 0;
};

// Of either.
struct FreshGather::LitEnd {
  static constexpr std::int32_t kNoSource = -1;
  RayEnd* end = nullptr;
  std::uint32_t patch = 0;
  std::int32_t source = kNoSource;
  bool shadow() const { return source != kNoSource; }
};

// Points of consecutive numbers in the order of their rooms, and their rays.
struct FreshGather::Batch {
  static_assert(kDirectionsABatch * (sizeof(RayEnd) + sizeof(ShadowEnd) + 4 * sizeof(LitEnd)) <=
                kBatchBytes);

  std::span<const GatherPoint> points;     // all of the caller's
  std::span<const std::uint32_t> numbers;  // of this batch's, room by room
  FreshSettings settings;
  const BrightSources* bright = nullptr;
  std::vector<RayEnd> ends;                    // points × directions
  std::vector<std::vector<ShadowEnd>> shadow;  // by point: those to bright elements
  std::vector<Spectrum> direct;                // points × replicates: of lamps, lx
  std::vector<LitEnd> lit, spare;              // by patch

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
  std::span<Spectrum> direct_of(std::size_t i) {
    return std::span(direct).subspan(i * replicates(), replicates());
  }
  // Of the random numbers of point i's replicate r.
  std::uint64_t key(std::size_t i, std::size_t r) const {
    return derived(derived(settings.seed, numbers[i]), r);
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
    everything_ = std::make_unique<RayWorld>(model_, all_clusters(model_), RayUse::kAlways);
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

// What tracing points works in, one after the other.
struct FreshGather::Scratch {
  std::vector<Vec3> along;
  std::vector<std::uint32_t> cells, order;
  std::vector<Glance> glances;
  std::vector<Due> due;
  std::vector<ShadowRay> shadow;
};

// The cosine-weighted rays of a few points, packet by packet.
void FreshGather::send_out(const RayScene& scene, std::size_t first, std::size_t last,
                           Batch& batch, Scratch& scratch) const {
  const Frame frame = frame_about(batch.point(first).normal);
  scratch.along.clear();
  scratch.cells.clear();
  for (std::size_t i = first; i < last; ++i)
    for (std::size_t r = 0; r < batch.replicates(); ++r) {
      const SampleSequence sequence(derived(batch.key(i, r), kDirections));
      for (std::uint32_t k = 0; k < batch.count(r); ++k) {
        const Vec2 square = sequence.at(k);
        scratch.along.push_back(cosine_direction(frame, square));
        scratch.cells.push_back(cell_of(square));
      }
    }
  sort_by_cell(scratch.cells, scratch.order);

  const std::span<RayEnd> ends =
      std::span(batch.ends).subspan(first * batch.directions(), scratch.along.size());
  const std::size_t a_point = batch.directions();
  for (std::size_t next = 0; next < ends.size(); next += kRayLanes) {
    const std::size_t lanes = std::min<std::size_t>(kRayLanes, ends.size() - next);
    const std::span<const std::uint32_t> order = std::span(scratch.order).subspan(next, lanes);
    RayPacket packet;
    packet.coherent = true;
    for (std::size_t k = 0; k < lanes; ++k)
      packet.set(static_cast<int>(k), batch.point(first + order[k] / a_point).x,
                 scratch.along[order[k]], model_.tolerance);
    HitPacket hits;
    scene.closest_hit16(packet, hits);
    for (std::size_t k = 0; k < lanes; ++k) {
      RayEnd& end = ends[order[k]];
      end = {};
      if (!(hits.found >> k & 1)) continue;
      const PatchId side = facing_side(hits.hit[k], scratch.along[order[k]]);
      const bool lit = side.valid() && !model_.patches[side.value].inert;
      end.patch = lit ? side.value : RayEnd::kBlack;
      end.x = hits.hit[k].point;
    }
  }
}

void FreshGather::send_shadow_rays(const RayScene& scene, std::size_t i, Batch& batch,
                                   Scratch& scratch) const {
  const GatherPoint& point = batch.point(i);
  scratch.due.clear();
  for (std::size_t r = 0; r < batch.replicates(); ++r)
    scratch.due.push_back(
        {static_cast<int>(batch.count(r)), derived(batch.key(i, r), kShadows)});
  batch.bright->look(point.x, point.normal, point.cluster, scratch.glances);
  deal_shadow_rays(point.x, point.normal, scratch.glances, scratch.due, scratch.shadow);
  keep_seen(point.x, scene, scratch.shadow);
  const std::span<Spectrum> direct = batch.direct_of(i);
  std::fill(direct.begin(), direct.end(), Spectrum{0});
  batch.shadow[i].clear();
  for (const ShadowRay& s : scratch.shadow) {
    if (s.source->lamp())
      direct[s.replicate] += s.weight * s.source->radiosity;
    else
      batch.shadow[i].push_back({{s.source->patch.value, true, s.x, Spectrum{0}},
                                 s.source->element, s.replicate, s.weight});
  }
}

void FreshGather::trace_room(const RayScene& scene, std::size_t first, std::size_t last,
                             Batch& batch) const {
  // What goes out together: points of one plane.
  const std::size_t most = std::max<std::size_t>(1, kDirectionsTogether / batch.directions());
  std::vector<std::size_t> starts;
  for (std::size_t i = first; i < last; ++i)
    if (starts.empty() || i - starts.back() == most ||
        batch.point(i).normal != batch.point(starts.back()).normal)
      starts.push_back(i);
  starts.push_back(last);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(1, starts.size()), [&](const auto& range) {
    Scratch scratch;
    for (std::size_t k = range.begin(); k < range.end(); ++k) {
      send_out(scene, starts[k - 1], starts[k], batch, scratch);
      for (std::size_t i = starts[k - 1]; i < starts[k]; ++i)
        send_shadow_rays(scene, i, batch, scratch);
    }
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

namespace {

// Sorts by patch, those of the same patch as they stand: by the patches' digits, the last first.
template <class End>
void sort_by_patch(std::vector<End>& ends, std::vector<End>& spare) {
  constexpr int kDigit = 11;  // bits: counts that fit beside all else in the nearest cache
  constexpr std::uint32_t kDigits = 1u << kDigit;
  std::uint32_t largest = 0;
  for (const End& e : ends) largest = std::max(largest, e.patch);
  spare.resize(ends.size());
  for (int shift = 0; shift < 32 && largest >> shift != 0; shift += kDigit) {
    std::array<std::uint32_t, kDigits + 1> next{};
    for (const End& e : ends) ++next[(e.patch >> shift) % kDigits + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (const End& e : ends) spare[next[(e.patch >> shift) % kDigits]++] = e;
    ends.swap(spare);
  }
}

// What rays bring of the cluster that they met, patch after patch. What shadow rays bring is not
// brought again.
template <class End>
void arrive(std::span<const End> ends, const ClusterView& cluster, std::uint32_t first_patch,
            const BrightSources& bright) {
  std::vector<Landing> landings;
  for (std::size_t first = 0, last = 0; first < ends.size(); first = last) {
    const PatchView patch = cluster.patch(ends[first].patch - first_patch);
    const PatchHead& head = *patch.head;
    landings.clear();
    for (; last < ends.size() && ends[last].patch == ends[first].patch; ++last) {
      const Vec2 p = head.frame.to_plane(ends[last].end->x);
      if (ends[last].shadow())
        ends[last].end->radiosity =
            head.reflectance * polynomial_at(patch, leaf_at(patch, p, ends[last].source), p);
      else
        landings.push_back({p, static_cast<std::uint32_t>(last)});
    }
    const Spectrum sent = bright.is_lamp(PatchId(head.patch)) ? Spectrum{0} : head.exitance;
    each_leaf(patch, landings, [&](std::int32_t leaf, std::span<const Landing> here) {
      const bool on_bright = bright.reflects_brightly(patch, leaf);
      for (const Landing& at : here) {
        auto& end = *ends[at.number].end;
        end.bright = on_bright;
        end.radiosity = sent;
        if (!on_bright) end.radiosity += head.reflectance * polynomial_at(patch, leaf, at.p);
      }
    });
  }
}

}  // namespace

// What each ray brings, source by source.
Status FreshGather::read_off(Batch& batch) {
  std::vector<LitEnd>& lit = batch.lit;
  lit.clear();
  for (std::size_t i = 0; i < batch.numbers.size(); ++i) {
    for (RayEnd& end : batch.ends_of(i))
      if (end.lit()) lit.push_back({&end, end.patch, LitEnd::kNoSource});
    for (ShadowEnd& s : batch.shadow[i]) lit.push_back({&s.end, s.end.patch, s.source});
  }
  sort_by_patch(lit, batch.spare);  // those of a cluster are contiguous
  const auto cluster_of = [&](std::size_t k) { return model_.patches[lit[k].patch].cluster; };
  std::vector<ClusterId> clusters;
  for (std::size_t k = 0; k < lit.size(); ++k)
    if (clusters.empty() || clusters.back() != cluster_of(k)) clusters.push_back(cluster_of(k));
  foresee(store_, clusters);
  for (std::size_t first = 0, last = 0; first < lit.size(); first = last) {
    const ClusterId cluster = cluster_of(first);
    while (last < lit.size() && cluster_of(last) == cluster) ++last;
    const Result<ClusterPin> pin = store_.read(record_id(RecordKind::kCluster, cluster.value));
    if (!pin.ok()) return pin.status();
    const Result<ClusterView> view = ClusterView::parse(pin->bytes());
    if (!view.ok()) return view.status();
    const auto arrive_some = [&](const auto& range) {
      arrive(std::span<const LitEnd>(lit).subspan(range.begin(), range.size()), *view,
             model_.clusters[cluster.value].first_patch, *batch.bright);
    };
    tbb::parallel_for(tbb::blocked_range(first, last, kEndsATask), arrive_some,
                      tbb::simple_partitioner());
  }
  return {};
}

void FreshGather::conclude(Batch& batch, std::size_t i, FreshIrradiance& result,
                           RayShares* shares) const {
  const double share = 1 / static_cast<double>(batch.directions());
  const double n = static_cast<double>(batch.replicates());
  double* const row = shares ? &shares->of_point[batch.numbers[i] * shares->groups] : nullptr;
  const std::span<Spectrum> sums = batch.direct_of(i);
  const auto group = [&](const RayEnd& end) {
    return row + shares->group_of_cluster[model_.patches[end.patch].cluster.value];
  };
  const RayEnd* end = batch.ends_of(i).data();
  for (std::size_t r = 0; r < batch.replicates(); ++r) {
    const double weight = 1 / static_cast<double>(batch.count(r));
    for (std::size_t k = 0; k < batch.count(r); ++k, ++end) {
      sums[r] += weight * end->radiosity;
      result.escaped += end->patch == RayEnd::kEscaped ? share : 0;
      result.black += end->patch == RayEnd::kBlack ? share : 0;
      if (row && end->lit() && !end->bright) group(*end)[0] += share;
    }
  }
  for (const ShadowEnd& s : batch.shadow[i]) {
    const Spectrum arriving = s.weight * s.end.radiosity;
    sums[s.replicate] += arriving;
    if (row) group(s.end)[1] += luminance(arriving) / n;
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
