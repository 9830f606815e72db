#include "scheduler/bright_sources.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <numbers>

#include "engine/squared.h"
#include "scheduler/stored_patches.h"
#include "solver/form_factor.h"
#include "solver/sample_sequence.h"
#include "solver/triangle_cubature.h"

namespace atrium {

namespace {

// A patch is a lamp if it emits so many times the scene's mean; an element is bright if it reflects
// so many times the mean of what is lit.
constexpr double kLampOfMean = 1.5;
constexpr double kBrightOfMean = 4;
// Bright elements are taken coarse: what only their children tell is below this share of their
// mean, or they are no larger than this share of the mean leaf. Where a lamp stands before a wall
// leaves are as small as can be, and there are as many of them as of all others.
constexpr double kEvenEnough = 0.5;
constexpr double kSmallOfLeaf = 0.5;
// Below this share the kernel at its centre stands for all of a source: it errs by the share's
// square.
constexpr double kFar = 0.02;
// A source is near, and its parts are told apart, while its radius is beyond this share of the
// distance to its nearest point; it is halved at most so often.
constexpr double kRadiusOfDistance = 0.25;
constexpr int kMostCuts = 7;
// A source that is due less than this share of a ray gets one by chance.
constexpr double kSureOfRay = 0.125;

double mean_luminance(const PatchView& patch, std::size_t element) {
  return luminance(patch.head->reflectance * mean_irradiance(patch, element));
}

// All but what it brings.
BrightSource source_of(const PatchView& patch, std::int32_t element, Polygon outline) {
  BrightSource s;
  s.patch = PatchId(patch.head->patch);
  s.element = element;
  s.normal = patch.head->frame.n;
  s.polygon = std::move(outline);
  s.center = centroid(s.polygon);
  s.area = area(s.polygon);
  for (const Vec3& v : s.polygon) s.radius = std::max(s.radius, length(v - s.center));
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

// The elements from i down that are brighter than `bright`, as coarse as they are even or small.
void add_bright_elements(const PatchView& patch, std::int32_t i, double bright, double small,
                         std::vector<BrightSource>& row) {
  const Element& e = patch.elements[i];
  const double mean = mean_luminance(patch, i);
  const double uneven = luminance(patch.head->reflectance) * e.detail;
  if (mean > bright && (e.leaf() || e.area <= small || uneven < kEvenEnough * mean)) {
    row.push_back(element_of(patch, i));
  } else if (!e.leaf() && mean + uneven > 0) {
    add_bright_elements(patch, e.child, bright, small, row);
    add_bright_elements(patch, e.child + 1, bright, small, row);
  }
}

// What the thresholds are relative to.
struct Means {
  double area = 0, flux = 0;           // m², lm emitted
  double lit_area = 0, reflected = 0;  // where light arrives
  double leaves = 0;
  void add(const PatchView& patch) {
    const double b = mean_luminance(patch, 0);
    area += patch.head->area;
    flux += patch.head->area * luminance(patch.head->exitance);
    leaves += static_cast<double>(std::ranges::count_if(patch.elements, &Element::leaf));
    if (!(b > 0)) return;
    lit_area += patch.head->area;
    reflected += patch.head->area * b;
  }
  double exitance() const { return area > 0 ? flux / area : 0; }
  double leaf() const { return leaves > 0 ? area / leaves : 0; }
  double radiosity() const { return lit_area > 0 ? reflected / lit_area : 0; }
};

// cosθ cosθ' / (π r²), 0 below either horizon.
double kernel(const Vec3& x, const Vec3& normal, const Vec3& y, const Vec3& normal_there) {
  const Vec3 d = y - x;
  const double r2 = dot(d, d);
  const double here = dot(normal, d), there = -dot(normal_there, d);
  return here > 0 && there > 0 ? here * there / (std::numbers::pi * r2 * r2) : 0;
}

// How much of a ball of this radius stands above the horizon, were it spread evenly over its
// height: the mean height there, of its centre where it is all above.
double height_above(double center, double radius) {
  if (center >= radius) return center;
  return center > -radius ? squared(center + radius) / (4 * radius) : 0;
}

// Is a ball so large for its distance that its parts are to be told apart? By squares.
bool is_near(double radius2, double distance2) {
  return squared((1 + kRadiusOfDistance) / kRadiusOfDistance) * radius2 > distance2;
}

// What an outline would bring, roughly, lx: the kernel at its centre, kept finite where it is near.
double guess(const Vec3& x, const Vec3& normal, const SourceOutline& s, double tolerance) {
  const Vec3 d = s.center - x;
  const double there = -dot(s.normal, d);
  if (there <= tolerance) return 0;
  const double here = height_above(dot(normal, d), s.radius);
  const double r2 = dot(d, d) + squared(s.radius) / 2;
  return s.flux * here * there / (std::numbers::pi * squared(r2));
}

bool is_far(const Vec3& x, const Vec3& normal, const BrightSource& source) {
  const Vec3 d = source.center - x;
  return dot(normal, d) > source.radius && squared(source.radius) < squared(kFar) * dot(d, d);
}

double form_factor_of(const Vec3& x, const Vec3& normal, const BrightSource& source) {
  return is_far(x, normal, source)
             ? source.area * kernel(x, normal, source.center, source.normal)
             : point_to_polygon_in_sum(x, normal, source.polygon);
}

// A place on a source, and the density that it was drawn with, up to one factor for all.
struct Place {
  Vec3 y{0};
  double density = 1;
};

// Draws places on sources by what their parts would bring to x, where they are near; else evenly.
class Drawing {
 public:
  Drawing(const Vec3& x, const Vec3& normal) : x_(x), normal_(normal) {}

  // The source to draw from, up to the horizon. False: nothing is above that.
  bool aim_at(const BrightSource& source) {
    const Vec3 d = source.center - x_;
    Polygon above;  // what of the outline is, where the horizon cuts it
    PolygonView outline = source.polygon;
    if (dot(normal_, d) < source.radius) {
      above = clip(outline, {normal_, dot(normal_, x_)}, 0);
      outline = above;
    }
    const bool near = is_near(squared(source.radius), dot(d, d));
    parts_.clear();
    whole_ = 0;
    for (std::size_t i = 2; i < outline.size(); ++i) {
      const Triangle t{outline[0] - x_, outline[i - 1] - x_, outline[i] - x_};
      const double area = fan_area(outline, i);
      parts_.push_back(near ? part_of(t, area) : Part{.corners = t, .area = area, .brings = area});
      whole_ += parts_.back().brings;
    }
    fan_ = parts_.size();
    return whole_ > 0;
  }

  // The first number chooses a part, and what is left of it a half of that, and so on.
  Place at(const Vec2& square) {
    double left = square.x * whole_;
    std::size_t i = 0;
    for (; i + 1 < fan_ && left >= parts_[i].brings; ++i) left -= parts_[i].brings;
    for (int cuts = 0; cuts < kMostCuts && parts_[i].near; ++cuts) {
      i = half_of(i);
      if (left < parts_[i].brings || !(parts_[i + 1].brings > 0)) continue;
      left -= parts_[i].brings;
      ++i;
    }
    const Part& part = parts_[i];
    const Triangle& t = part.corners;
    const double along = part.brings > 0 ? std::min(1.0, left / part.brings) : 0;
    return {x_ + point_of(t[0], t[1], t[2], {along, square.y}), part.brings / (whole_ * part.area)};
  }

 private:
  // A triangle as x sees it: that is its origin.
  struct Part {
    Triangle corners;
    double area = 0;
    double brings = 0;        // roughly, up to one factor for all of a source
    bool near = false;
    std::uint32_t child = 0;  // the first of its halves; 0: not halved yet
  };

  Part part_of(const Triangle& t, double area) const {
    const Vec3 center = (t[0] + t[1] + t[2]) / 3.0;
    double radius2 = 0;
    for (const Vec3& v : t) radius2 = std::max(radius2, dot(v - center, v - center));
    const double distance2 = dot(center, center);
    const double brings =
        area * std::max(0.0, dot(normal_, center)) / squared(distance2 + radius2 / 2);
    return {t, area, brings, is_near(radius2, distance2)};
  }

  // The first of a part's halves, which share what it brings.
  std::size_t half_of(std::size_t i) {
    if (parts_[i].child == 0) {
      const auto [first, second] = bisect(parts_[i].corners);
      Part a = part_of(first, parts_[i].area / 2), b = part_of(second, parts_[i].area / 2);
      const double both = a.brings + b.brings;
      a.brings = parts_[i].brings * (both > 0 ? a.brings / both : 0.5);
      b.brings = parts_[i].brings - a.brings;
      parts_[i].child = static_cast<std::uint32_t>(parts_.size());
      parts_.push_back(a);
      parts_.push_back(b);
    }
    return parts_[i].child;
  }

  const Vec3 x_, normal_;
  std::vector<Part> parts_;  // a fan, then halves where it is near
  std::size_t fan_ = 0;      // how many are the fan's
  double whole_ = 0;         // what these bring
};

// A source's share of the shadow rays.
struct Share {
  int rays = 0;
  double scale = 1;  // what its light counts for, so that chance evens out
};

// Deals them out, source by source; those that are due little take their chance from one number, so
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

// The rays of one source, weighted by the kernel; together they weigh what is said.
void add_rays(const Vec3& x, const Vec3& normal, const BrightSource& source, Drawing& drawing,
              std::uint32_t replicate, int count, double weight, const SampleSequence& sequence,
              std::vector<ShadowRay>& shadow) {
  const std::size_t first = shadow.size();
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const Place place = drawing.at(sequence.at(static_cast<std::uint32_t>(i)));
    const double k = kernel(x, normal, place.y, source.normal) / place.density;
    if (!(k > 0)) continue;
    shadow.push_back({&source, replicate, place.y, k});
    sum += k;
  }
  for (std::size_t i = first; i < shadow.size(); ++i) shadow[i].weight *= weight / sum;
}

}  // namespace

Result<BrightSources> BrightSources::find(const Model& model, ClusterStore& store) {
  Means means;
  const std::vector<ClusterId> clusters = all_clusters(model);
  ATRIUM_RETURN_IF_ERROR(each_receiver(
      store, clusters, [&](ClusterId, const PatchView& patch) { means.add(patch); }));
  BrightSources all(model);
  all.is_lamp_.assign(model.patches.size(), false);
  all.has_bright_elements_.assign(model.patches.size(), false);
  std::vector<BrightSource> row;
  const double lamp = kLampOfMean * means.exitance(), bright = kBrightOfMean * means.radiosity();
  const double small = kSmallOfLeaf * means.leaf();
  const auto add = [&](const PatchView& patch) {
    const std::uint32_t id = patch.head->patch;
    if (luminance(patch.head->exitance) > lamp) {
      row.push_back(lamp_of(model, patch));
      all.is_lamp_[id] = true;
    }
    const std::size_t before = row.size();
    if (bright > 0) add_bright_elements(patch, 0, bright, small, row);
    all.has_bright_elements_[id] = row.size() > before;
  };
  foresee(store, clusters);
  for (const ClusterId c : clusters) {
    row.clear();
    ATRIUM_RETURN_IF_ERROR(each_receiver(store, c, add));
    std::sort(row.begin(), row.end(), [](const BrightSource& a, const BrightSource& b) {
      return std::pair(a.patch, a.element) < std::pair(b.patch, b.element);
    });
    for (const BrightSource& s : row)
      all.outlines_.push_back({s.center, s.radius, s.normal, s.area * luminance(s.radiosity)});
    all.sources_.push_row(row);
  }
  return all;
}

std::size_t BrightSources::bytes() const {
  constexpr std::size_t kHeapsOwn = 16;  // about an outline
  std::size_t polygons = 0;
  for (const BrightSource& s : sources_.items)
    polygons += s.polygon.capacity() * sizeof(Vec3) + kHeapsOwn;
  return polygons + sources_.items.capacity() * sizeof(BrightSource) +
         sources_.starts.capacity() * sizeof(std::uint32_t) +
         outlines_.capacity() * sizeof(SourceOutline) +
         (is_lamp_.capacity() + has_bright_elements_.capacity()) / CHAR_BIT;
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

void BrightSources::look(const Vec3& x, const Vec3& normal, std::size_t row,
                         std::vector<Glance>& glances) const {
  const std::span<const BrightSource> sources = sources_[row];
  const SourceOutline* outline = outlines_.data() + sources_.starts[row];
  for (const BrightSource& source : sources) {
    const SourceOutline& o = *outline++;
    Glance glance{&source, guess(x, normal, o, model_->tolerance)};
    if (!(glance.weight > 0)) continue;
    const Vec3 d = o.center - x;
    if (is_near(squared(o.radius), dot(d, d))) {
      glance.form_factor = point_to_polygon_in_sum(x, normal, source.polygon);
      glance.weight = glance.form_factor / source.area * o.flux;
      if (!(glance.weight > 0)) continue;
    }
    glances.push_back(glance);
  }
}

void BrightSources::look(const Vec3& x, const Vec3& normal, ClusterId cluster,
                         std::vector<Glance>& glances) const {
  glances.clear();
  if (!cluster.valid()) {
    for (std::size_t c = 0; c < model_->clusters.size(); ++c) look(x, normal, c, glances);
    return;
  }
  for (const ClusterId seen : model_->visible[cluster.value]) look(x, normal, seen.value, glances);
}

void deal_shadow_rays(const Vec3& x, const Vec3& normal, std::span<const Glance> glances,
                      std::span<const Due> due, std::vector<ShadowRay>& shadow) {
  shadow.clear();
  double whole = 0;
  for (const Glance& glance : glances) whole += glance.weight;
  std::vector<Deal> deals;
  for (const Due& d : due)
    deals.emplace_back(SampleSequence(derived(d.key, glances.size())).at(0).x);
  Drawing drawing(x, normal);
  for (std::size_t i = 0; i < glances.size(); ++i) {
    const BrightSource& source = *glances[i].source;
    const double part = glances[i].weight / whole;
    double form_factor = glances[i].form_factor;
    bool aimed = false;
    for (std::uint32_t r = 0; r < due.size(); ++r) {
      const Share share = deals[r].to(due[r].rays * part);
      if (share.rays == 0) continue;
      if (!aimed) {
        aimed = true;
        if (!drawing.aim_at(source)) form_factor = 0;
        if (form_factor < 0) form_factor = form_factor_of(x, normal, source);
      }
      if (form_factor > 0)
        add_rays(x, normal, source, drawing, r, share.rays, share.scale * form_factor,
                 SampleSequence(derived(due[r].key, i)), shadow);
    }
  }
}

void keep_seen(const Vec3& x, const RayScene& scene, std::vector<ShadowRay>& shadow) {
  std::size_t kept = 0;
  for (std::size_t first = 0; first < shadow.size(); first += kRayLanes) {
    const std::size_t lanes = std::min<std::size_t>(kRayLanes, shadow.size() - first);
    SegmentPacket packet;
    for (std::size_t k = 0; k < lanes; ++k) packet.set(static_cast<int>(k), x, shadow[first + k].x);
    std::uint16_t blocked = 0;
    scene.occluded16(packet, blocked);
    for (std::size_t k = 0; k < lanes; ++k)
      if (!(blocked >> k & 1)) shadow[kept++] = shadow[first + k];
  }
  shadow.resize(kept);
}

}  // namespace atrium
