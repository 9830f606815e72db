#include "visibility/soundness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>

#include "visibility/box_tree.h"
#include "visibility/occlusion.h"
#include "visibility/patch_sampler.h"
#include "visibility/second_look.h"
#include "visibility/segment_words.h"
#include "visibility/tube_soundness.h"

namespace atrium {

namespace {

// What one stream of random numbers serves: the same streams for any number of threads.
constexpr std::uint64_t kSegmentsAChunk = 1 << 14, kTubesAChunk = 1 << 8;

// Streams of tubes are numbered from here, those of segments from 0.
constexpr std::uint64_t kFirstTubeStream = std::uint64_t{1} << 63;

// Ends are drawn so often at most before a segment is given up.
constexpr int kDraws = 64;

// An end is in front of the other's plane by at least so many times the near distance: then the
// segment is longer than what is left out of it at its ends.
constexpr double kLeastNearsInFront = 3;

struct Segment {
  PatchPoint from, to;
};

struct SegmentTally {
  std::uint64_t joined = 0, blocked = 0, missed_sources = 0, missed_blockers = 0;
  std::uint64_t exempt = 0;
  std::vector<std::string> sources, blockers;  // examples
};

BoxTree patch_tree(const Model& model) {
  std::vector<Box> boxes;
  boxes.reserve(model.patches.size());
  for (const Patch& p : model.patches) boxes.push_back(bounds(model.polygon(p)));
  return BoxTree(std::move(boxes));
}

Rows<std::uint32_t> patches_by_surface(const Scene& scene, const Model& model) {
  std::vector<std::vector<std::uint32_t>> rows(scene.surfaces.size());
  for (std::uint32_t p = 0; p < model.patches.size(); ++p)
    rows[model.patches[p].surface.value].push_back(p);
  Rows<std::uint32_t> out;
  for (const auto& row : rows) out.push_row(row);
  return out;
}

class SegmentJudge {
 public:
  SegmentJudge(const Scene& scene, const Model& model, const PatchSampler& sampler,
               const SecondLook& look, const RayScene& rays)
      : scene_(scene),
        model_(model),
        sampler_(sampler),
        look_(look),
        rays_(rays),
        tree_(patch_tree(model)),
        patches_of_(patches_by_surface(scene, model)),
        witnessed_(model.visible.items.size()) {}

  void judge(RandomStream& random, std::uint64_t segments, SegmentTally& tally) {
    std::array<Segment, kRayLanes> packet;
    int lanes = 0;
    for (std::uint64_t i = 0; i < segments; ++i) {
      const std::optional<Segment> segment = draw(random, i % 2 == 0);
      if (!segment) continue;
      packet[lanes++] = *segment;
      if (lanes < kRayLanes) continue;
      shoot(packet, tally);
      lanes = 0;
    }
    shoot(std::span(packet).first(lanes), tally);
  }

  // Was the pair at this place in the rows, the lower cluster's, joined?
  bool witnessed(std::size_t item) const { return witnessed_[item]; }

 private:
  std::optional<Segment> draw(RandomStream& random, bool by_area) const {
    const auto point = [&] {
      return by_area ? sampler_.by_area(random) : sampler_.by_cluster(random);
    };
    const double least = kLeastNearsInFront * look_.near();
    for (int i = 0; i < kDraws; ++i) {
      const PatchPoint p = point(), q = point();
      if (sampler_.plane(p.patch).distance(q.at) > least &&
          sampler_.plane(q.patch).distance(p.at) > least)
        return Segment{p, q};
    }
    return {};
  }

  void shoot(std::span<const Segment> segments, SegmentTally& tally) {
    RayPacket packet;
    for (std::size_t i = 0; i < segments.size(); ++i)
      packet.set(static_cast<int>(i), segments[i].from.at, segments[i].to.at - segments[i].from.at,
                 look_.near());
    HitPacket hits;
    rays_.closest_hit16(packet, hits);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Segment& s = segments[i];
      if ((hits.found >> i & 1) && hits.hit[i].t < length(s.to.at - s.from.at) - look_.near())
        meet(s, hits.hit[i], tally);
      else
        join(s, tally);
    }
  }

  ClusterId cluster(PatchId patch) const { return model_.patches[patch.value].cluster; }

  FacePoint face_point(const PatchPoint& p) const { return {p.at, sampler_.plane(p.patch)}; }
  std::string words(const Segment& s) const {
    return segment_words(scene_, model_, s.from.patch, s.from.at, s.to.patch, s.to.at);
  }

  // Where the rows' items hold the pair.
  std::optional<std::size_t> entry(ClusterId receiver, ClusterId source) const {
    const auto row = model_.visible[receiver.value];
    const auto at = std::lower_bound(row.begin(), row.end(), source);
    if (at == row.end() || *at != source) return {};
    return model_.visible.starts[receiver.value] + static_cast<std::size_t>(at - row.begin());
  }

  void join(const Segment& s, SegmentTally& tally) {
    ++tally.joined;
    const auto [low, high] = std::minmax({cluster(s.from.patch), cluster(s.to.patch)});
    const std::optional<std::size_t> kept = entry(low, high);
    const bool listed = kept && entry(high, low);
    if (listed && witnessed_[*kept].load(std::memory_order_relaxed)) return;
    const FacePoint x = face_point(s.from), y = face_point(s.to);
    if (look_.crowded(x) || look_.crowded(y) || !look_.surely_free(x, y)) return;
    if (kept) witnessed_[*kept].store(true, std::memory_order_relaxed);
    if (listed) return;
    if (through_closed_gap(s.from.at, s.to.at)) {
      ++tally.exempt;
      return;
    }
    ++tally.missed_sources;
    note(tally.sources,
         [&] { return words(s) + "nothing is in the way, and a row lacks the other cluster"; });
  }

  // What is met first is seen: it is a blocker, and if it is a lit patch's front a source too.
  void meet(const Segment& s, const Hit& hit, SegmentTally& tally) {
    ++tally.blocked;
    const ClusterId receiver = cluster(s.from.patch);
    const bool listed = lists_any_at(receiver, hit);
    const std::optional<std::size_t> seen = lit_pair_at(s, hit);
    const bool news = seen && !witnessed_[*seen].load(std::memory_order_relaxed);
    if ((listed && !news) || !surely_first(s, hit)) return;
    if (news) witnessed_[*seen].store(true, std::memory_order_relaxed);
    if (listed) return;
    if (through_closed_gap(s.from.at, hit.point)) {
      ++tally.exempt;
      return;
    }
    ++tally.missed_blockers;
    note(tally.blockers, [&] {
      const Surface& met = scene_.surfaces[hit.id];
      return words(s) + "first meets '" + scene_.objects[met.object.value].name + "' at " +
             place_words(scene_, hit.point) + ", which the first one's row lacks";
    });
  }

  // Where the rows hold the start's cluster and that of the lit patch whose front the ray hit.
  std::optional<std::size_t> lit_pair_at(const Segment& s, const Hit& hit) const {
    for (const std::uint32_t i : patches_of_[hit.id]) {
      const Patch& patch = model_.patches[i];
      const Plane& plane = sampler_.plane(PatchId(i));
      if (patch.inert || dot(plane.normal, s.to.at - s.from.at) >= 0) continue;
      if (!contains(model_.polygon(patch), plane.normal, hit.point, look_.near())) continue;
      const auto [low, high] = std::minmax({cluster(s.from.patch), patch.cluster});
      return entry(low, high);
    }
    return {};
  }

  // Does the cluster's row list any patch where the ray hit? From either side patches block. Mostly
  // it is one of the surface that was hit.
  bool lists_any_at(ClusterId receiver, const Hit& hit) const {
    const auto listed = [&](std::uint32_t i) {
      const Patch& patch = model_.patches[i];
      const Plane& plane = sampler_.plane(PatchId(i));
      return std::abs(plane.distance(hit.point)) <= look_.near() &&
             contains(model_.polygon(patch), plane.normal, hit.point, look_.near()) &&
             entry(receiver, patch.cluster);
    };
    if (std::ranges::any_of(patches_of_[hit.id], listed)) return true;
    const Box box{hit.point - Vec3{look_.near()}, hit.point + Vec3{look_.near()}};
    bool found = false;
    tree_.visit(box, [&](std::uint32_t i) { found = found || listed(i); });
    return found;
  }

  bool surely_first(const Segment& s, const Hit& hit) const {
    const FacePoint x = face_point(s.from);
    if (look_.crowded(x)) return false;
    const std::optional<FacePoint> z = look_.sure_crossing(s.from.at, s.to.at, SurfaceId(hit.id));
    return z && x.plane.distance(z->at) > look_.width() && look_.surely_free(x, *z);
  }

  bool through_closed_gap(const Vec3& x, const Vec3& y) const {
    return std::ranges::any_of(model_.closed_gaps, [&](const ClosedGap& gap) {
      return std::ranges::any_of(
          gap.polygons, [&](const Polygon& polygon) { return look_.passes(polygon, x, y); });
    });
  }

  const Scene& scene_;
  const Model& model_;
  const PatchSampler& sampler_;
  const SecondLook& look_;
  const RayScene& rays_;
  BoxTree tree_;                              // of patches
  Rows<std::uint32_t> patches_of_;            // a row a surface
  std::vector<std::atomic<bool>> witnessed_;  // by place in the rows' items
};

// judge(stream's number, how many of the total, tally) for each chunk; the tallies in order.
template <class Tally, class Judge>
std::vector<Tally> in_chunks(std::uint64_t total, std::uint64_t a_chunk, Judge&& judge) {
  std::vector<Tally> tallies((total + a_chunk - 1) / a_chunk);
  tbb::parallel_for(std::size_t{0}, tallies.size(), [&](std::size_t chunk) {
    judge(chunk, std::min(a_chunk, total - chunk * a_chunk), tallies[chunk]);
  });
  return tallies;
}

void append(std::vector<std::string>& examples, const std::vector<std::string>& more) {
  for (const std::string& words : more) note(examples, [&] { return words; });
}

void append_all(std::vector<std::string>& examples, const std::vector<std::string>& more) {
  examples.insert(examples.end(), more.begin(), more.end());
}

void count_pairs(const Model& model, const PatchSampler& sampler, const SegmentJudge& judge,
                 SoundnessReport& report) {
  for (const ClusterId receiver : sampler.lit_clusters()) {
    const auto row = model.visible[receiver.value];
    const double share = double(row.size()) / double(model.clusters.size());
    report.mean_share += share / double(sampler.lit_clusters().size());
    report.largest_share = std::max(report.largest_share, share);
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (row[i] < receiver || !sampler.lit(row[i])) continue;
      PairCounts& pairs = row[i] == receiver ? report.selves : report.others;
      ++pairs.kept;
      pairs.witnessed += judge.witnessed(model.visible.starts[receiver.value] + i);
    }
  }
}

void judge_segments(const Model& model, const PatchSampler& sampler, SegmentJudge& judge,
                    const SoundnessOptions& options, SoundnessReport& report) {
  const auto tallies = in_chunks<SegmentTally>(
      options.segments, kSegmentsAChunk,
      [&](std::uint64_t chunk, std::uint64_t segments, SegmentTally& tally) {
        RandomStream random(options.seed, chunk);
        judge.judge(random, segments, tally);
      });
  std::vector<std::string> sources, blockers;
  for (const SegmentTally& t : tallies) {
    report.joined += t.joined;
    report.blocked += t.blocked;
    report.missed_sources += t.missed_sources;
    report.missed_blockers += t.missed_blockers;
    report.exempt += t.exempt;
    append(sources, t.sources);
    append(blockers, t.blockers);
  }
  append_all(report.examples, sources);
  append_all(report.examples, blockers);
  count_pairs(model, sampler, judge, report);
}

void judge_tubes(const TubeJudge& judge, const SoundnessOptions& options, SoundnessReport& report) {
  const auto tallies = in_chunks<TubeTally>(
      options.tubes, kTubesAChunk, [&](std::uint64_t chunk, std::uint64_t tubes, TubeTally& tally) {
        RandomStream random(options.seed, kFirstTubeStream + chunk);
        while (tubes-- > 0) judge.judge(random, tally);
      });
  std::vector<std::string> examples;
  for (const TubeTally& t : tallies) {
    report.tubes.invisible += t.counts.invisible;
    report.tubes.visible += t.counts.visible;
    report.tubes.partial += t.counts.partial;
    report.tubes.wrongly_invisible += t.counts.wrongly_invisible;
    report.tubes.wrongly_visible += t.counts.wrongly_visible;
    append(examples, t.examples);
  }
  append_all(report.examples, examples);
}

}  // namespace

SoundnessReport judge_visibility(const Scene& scene, const Model& model,
                                 const SoundnessOptions& options) {
  SoundnessReport report;
  const PatchSampler sampler(model);
  if (sampler.lit_clusters().empty()) return report;
  std::vector<BlockerPolygon> surfaces;
  surfaces.reserve(scene.surfaces.size());
  for (std::uint32_t i = 0; i < scene.surfaces.size(); ++i)
    surfaces.push_back({scene.polygon(scene.surfaces[i]), i});
  const RayScene rays(surfaces);
  const SecondLook look(scene);
  SegmentJudge segments(scene, model, sampler, look, rays);
  judge_segments(model, sampler, segments, options, report);
  judge_tubes(TubeJudge(scene, model, sampler, look, surfaces, rays), options, report);
  return report;
}

}  // namespace atrium
