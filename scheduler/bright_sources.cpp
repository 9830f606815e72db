#include "scheduler/bright_sources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scheduler/stored_patches.h"
#include "solver/coupling.h"
#include "solver/form_factor.h"
#include "solver/sample_sequence.h"

namespace atrium {

namespace {

// A patch is a lamp if it emits so many times the scene's mean; an element is bright if it reflects
// so many times the mean of what is lit.
constexpr double kLampOfMean = 1.5;
constexpr double kBrightOfMean = 4;
// Bright elements are taken coarse: what only their children tell is below this share of their
// mean.
constexpr double kEvenEnough = 0.5;
// A piece is cut while its radius is beyond this share of the distance to its nearest point, and at
// most so often: near sources become pieces no larger than they are far.
constexpr double kRadiusOfDistance = 0.25;
constexpr int kMostCuts = 7;
// Below this share the kernel at its centre stands for all of a source: it errs by the share's
// square. Of elements, which are many, the quadrature's nodes do up to the share that pieces are
// cut at: they err by its fourth power, 1e-4.
constexpr double kFar = 0.02;
// A piece that is due less than this share of a ray gets one by chance.
constexpr double kSureOfRay = 0.125;

double mean_luminance(const PatchView& patch, std::size_t element) {
  return luminance(patch.head->reflectance * mean_irradiance(patch, element));
}

// All but what it brings.
BrightSource source_of(const PatchView& patch, std::int32_t element, Polygon outline) {
  const Site site = make_site(patch, element == BrightSource::kLamp ? 0 : std::size_t(element));
  BrightSource s;
  s.patch = PatchId(patch.head->patch);
  s.element = element;
  s.normal = patch.head->frame.n;
  s.polygon = std::move(outline);
  s.center = centroid(s.polygon);
  s.area = area(s.polygon);
  for (const Vec3& v : s.polygon) s.radius = std::max(s.radius, length(v - s.center));
  s.node = site.x;
  s.node_weight = site.weight;
  s.nodes = site.nodes;
  return s;
}

BrightSource lamp_of(const Model& model, const PatchView& patch) {
  const PolygonView outline = model.polygon(model.patches[patch.head->patch]);
  BrightSource s =
      source_of(patch, BrightSource::kLamp, Polygon(outline.begin(), outline.end()));
  s.radiosity = patch.head->exitance;
  return s;
}

BrightSource element_of(const PatchView& patch, std::int32_t i) {
  Polygon outline;
  for (const Vec2& v : patch.polygon(patch.elements[i])) outline.push_back(patch.point(v));
  BrightSource s = source_of(patch, i, std::move(outline));
  s.radiosity = patch.head->reflectance * mean_irradiance(patch, static_cast<std::size_t>(i));
  return s;
}

// The elements from i down that are brighter than `bright`, as coarse as they are even.
void add_bright_elements(const PatchView& patch, std::int32_t i, double bright,
                         std::vector<BrightSource>& row) {
  const Element& e = patch.elements[i];
  const double mean = mean_luminance(patch, i);
  const double uneven = luminance(patch.head->reflectance) * e.detail;
  if (mean > bright && (e.leaf() || uneven < kEvenEnough * mean)) {
    row.push_back(element_of(patch, i));
  } else if (!e.leaf() && mean + uneven > 0) {
    add_bright_elements(patch, e.child, bright, row);
    add_bright_elements(patch, e.child + 1, bright, row);
  }
}

// What the thresholds are relative to.
struct Means {
  double area = 0, flux = 0;           // m², lm emitted
  double lit_area = 0, reflected = 0;  // where light arrives
  void add(const PatchView& patch) {
    const double b = mean_luminance(patch, 0);
    area += patch.head->area;
    flux += patch.head->area * luminance(patch.head->exitance);
    if (!(b > 0)) return;
    lit_area += patch.head->area;
    reflected += patch.head->area * b;
  }
  double exitance() const { return area > 0 ? flux / area : 0; }
  double radiosity() const { return lit_area > 0 ? reflected / lit_area : 0; }
};

// Through the centroid, across the longest way between two corners.
Split halves(PolygonView polygon, const Vec3& center) {
  Vec3 longest{0};
  for (const Vec3& a : polygon)
    for (const Vec3& b : polygon)
      if (length(b - a) > length(longest)) longest = b - a;
  const Vec3 along = normalize(longest);
  return split(polygon, {along, dot(along, center)}, 0);
}

// cosθ cosθ' / (π r²), 0 below either horizon.
double kernel(const Vec3& x, const Vec3& normal, const Vec3& y, const Vec3& normal_there) {
  const Vec3 d = y - x;
  const double r2 = dot(d, d);
  const double here = dot(normal, d), there = -dot(normal_there, d);
  return here > 0 && there > 0 ? here * there / (std::numbers::pi * r2 * r2) : 0;
}

class Look {
 public:
  Look(const Vec3& x, const Vec3& normal, std::vector<SourcePiece>& pieces)
      : x_(x), normal_(normal), pieces_(pieces) {}

  void at(const BrightSource& source, double tolerance) {
    const Vec3 d = source.center - x_;
    if (-dot(source.normal, d) <= tolerance || dot(normal_, d) <= -source.radius) return;
    if (dot(normal_, d) > source.radius) {
      const double distance = length(d);
      if (source.radius < kFar * distance)
        return add(source, {}, source.area * kernel(x_, normal_, source.center, source.normal));
      if (!source.lamp() && source.radius <= kRadiusOfDistance * (distance - source.radius))
        return add(source, {}, source.area * by_nodes(source));
    }
    at_part(source, source.polygon, source.center, source.radius, 0);
  }

 private:
  void at_part(const BrightSource& source, PolygonView part, const Vec3& center, double radius,
               int cuts) {
    if (dot(normal_, center - x_) <= -radius) return;
    const double nearest = length(center - x_) - radius;
    if (cuts < kMostCuts && radius > kRadiusOfDistance * nearest) {
      const Split parts = halves(part, center);
      if (!parts.front.empty() && !parts.back.empty()) {
        at_half(source, parts.front, cuts + 1);
        return at_half(source, parts.back, cuts + 1);
      }
    }
    add(source, cuts > 0 ? Polygon(part.begin(), part.end()) : Polygon(),
        point_to_polygon_in_sum(x_, normal_, part));
  }

  double by_nodes(const BrightSource& source) const {
    double sum = 0;
    for (int i = 0; i < source.nodes; ++i)
      sum += source.node_weight[i] * kernel(x_, normal_, source.node[i], source.normal);
    return sum;
  }

  void at_half(const BrightSource& source, PolygonView part, int cuts) {
    const Vec3 center = centroid(part);
    double radius = 0;
    for (const Vec3& v : part) radius = std::max(radius, length(v - center));
    at_part(source, part, center, radius, cuts);
  }

  void add(const BrightSource& source, Polygon part, double form_factor) {
    if (!(form_factor > 0)) return;
    const double weight = form_factor * luminance(source.radiosity);
    pieces_.push_back({&source, std::move(part), form_factor, weight});
  }

  const Vec3 x_, normal_;
  std::vector<SourcePiece>& pieces_;
};

// A piece's share of the shadow rays.
struct Share {
  int rays = 0;
  double scale = 1;  // what its light counts for, so that chance evens out
};

// Deals them out, piece by piece; those that are due little take their chance from one number, so
// that of many together as many are dealt as are due.
class Deal {
 public:
  explicit Deal(double chance) : next_(chance) {}
  Share to(double due) {
    if (due >= kSureOfRay) return {std::max(1, static_cast<int>(std::lround(due))), 1};
    const double p = due / kSureOfRay;
    passed_ += p;
    if (passed_ <= next_) return {};
    next_ += 1;
    return {1, 1 / p};
  }

 private:
  double passed_ = 0, next_;
};

struct ShadowRay {
  std::uint32_t piece = 0;
  Vec3 x{0};
  double weight = 0;  // once all of the piece's are known: of the radiosity
};

// The rays of one piece, weighted by the kernel; together they weigh its form factor.
void add_rays(const Vec3& x, const Vec3& normal, const SourcePiece& piece, std::uint32_t number,
              const Share& share, const SampleSequence& sequence, std::vector<ShadowRay>& rays) {
  const std::size_t first = rays.size();
  double sum = 0;
  for (int i = 0; i < share.rays; ++i) {
    const Vec3 y = point_of(piece.polygon(), sequence.at(static_cast<std::uint32_t>(i)));
    const double k = kernel(x, normal, y, piece.source->normal);
    if (!(k > 0)) continue;
    rays.push_back({number, y, k});
    sum += k;
  }
  for (std::size_t i = first; i < rays.size(); ++i)
    rays[i].weight *= share.scale * piece.form_factor / sum;
}

}  // namespace

Result<BrightSources> BrightSources::find(const Model& model, ClusterStore& store) {
  Means means;
  for (std::size_t c = 0; c < model.clusters.size(); ++c)
    ATRIUM_RETURN_IF_ERROR(
        each_receiver(store, ClusterId(c), [&](const PatchView& patch) { means.add(patch); }));
  BrightSources all(model);
  all.is_lamp_.assign(model.patches.size(), false);
  all.has_bright_elements_.assign(model.patches.size(), false);
  std::vector<BrightSource> row;
  const double lamp = kLampOfMean * means.exitance(), bright = kBrightOfMean * means.radiosity();
  const auto add = [&](const PatchView& patch) {
    const std::uint32_t id = patch.head->patch;
    if (luminance(patch.head->exitance) > lamp) {
      row.push_back(lamp_of(model, patch));
      all.is_lamp_[id] = true;
    }
    const std::size_t before = row.size();
    if (bright > 0) add_bright_elements(patch, 0, bright, row);
    all.has_bright_elements_[id] = row.size() > before;
  };
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    row.clear();
    ATRIUM_RETURN_IF_ERROR(each_receiver(store, ClusterId(c), add));
    std::sort(row.begin(), row.end(), [](const BrightSource& a, const BrightSource& b) {
      return std::pair(a.patch, a.element) < std::pair(b.patch, b.element);
    });
    all.sources_.push_row(row);
  }
  return all;
}

bool BrightSources::reflects_brightly(const PatchView& patch, std::int32_t leaf) const {
  const PatchId id(patch.head->patch);
  if (!has_bright_elements_[id.value]) return false;
  const std::span<const BrightSource> row = sources_[model_->patches[id.value].cluster.value];
  for (std::int32_t i = leaf; i >= 0; i = patch.elements[i].parent) {
    const auto less = [](const BrightSource& s, const std::pair<PatchId, std::int32_t>& key) {
      return std::pair(s.patch, s.element) < key;
    };
    const auto at = std::lower_bound(row.begin(), row.end(), std::pair(id, i), less);
    if (at != row.end() && at->patch == id && at->element == i) return true;
  }
  return false;
}

void BrightSources::look(const Vec3& x, const Vec3& normal, ClusterId cluster,
                         std::vector<SourcePiece>& pieces) const {
  pieces.clear();
  Look look(x, normal, pieces);
  if (!cluster.valid()) {
    for (const BrightSource& s : sources_.items) look.at(s, model_->tolerance);
    return;
  }
  for (const ClusterId seen : model_->visible[cluster.value])
    for (const BrightSource& s : sources_[seen.value]) look.at(s, model_->tolerance);
}

void cast_shadow_rays(const Vec3& x, const Vec3& normal, std::span<const SourcePiece> pieces,
                      const RayScene& scene, int rays, std::uint64_t key,
                      std::vector<SeenSource>& seen) {
  double whole = 0;
  for (const SourcePiece& piece : pieces) whole += piece.weight;
  std::vector<ShadowRay> shadow;
  Deal deal(SampleSequence(derived(key, pieces.size())).at(0).x);
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    const Share share = deal.to(rays * pieces[i].weight / whole);
    if (share.rays > 0)
      add_rays(x, normal, pieces[i], i, share, SampleSequence(derived(key, i)), shadow);
  }
  for (std::size_t first = 0; first < shadow.size(); first += kRayLanes) {
    const std::size_t lanes = std::min<std::size_t>(kRayLanes, shadow.size() - first);
    SegmentPacket packet;
    for (std::size_t k = 0; k < lanes; ++k) packet.set(static_cast<int>(k), x, shadow[first + k].x);
    std::uint16_t blocked = 0;
    scene.occluded16(packet, blocked);
    for (std::size_t k = 0; k < lanes; ++k)
      if (!(blocked >> k & 1))
        seen.push_back({pieces[shadow[first + k].piece].source, shadow[first + k].x,
                        shadow[first + k].weight});
  }
}

}  // namespace atrium
