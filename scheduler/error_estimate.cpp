#include "scheduler/error_estimate.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <limits>
#include <numeric>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/squared.h"
#include "scheduler/solution.h"
#include "scheduler/stored_patches.h"
#include "solver/sample_sequence.h"

namespace atrium {

namespace {

// Parts of a point's directions that tell its noise.
constexpr int kReplicates = 8;
// Groups of clusters hold no fewer points than this, or the smooth part would be noise itself.
constexpr std::size_t kGroupPoints = 48;
// Blocks of points that the jackknife leaves out in turn, and Student's 97.5% quantile for them.
constexpr std::size_t kBlocks = 32;
constexpr double kQuantile = 2.04;
// A point is covered, as floors are under furniture, if no less of its rays than this is lost: no
// light reaches it, and none sees it.
constexpr double kCovered = 1 - 1e-9;

// Where their noise hides what is asked, points get so many times as many directions, so often.
constexpr int kMoreDirections = 4, kMostMore = 2;
// An error is clear that is twice what noise would be taken for.
constexpr double kClear = 0.5;

// No single point counts for more than this share of the squares: a bright spot where shadow
// should be, met by chance, would decide the estimate alone. The interval's upper end counts it in
// full.
constexpr double kMostOfSquare = 0.3;

// Of what a bright group sends, no more than this comes back to it: from a ceiling to the lamp's back
// below and up again. Few points say more by chance, or so much that it would never die out.
constexpr double kMostReturned = 0.8;

// How the points are spread: even over the area, over the leaves, which are small where refinement
// met error, and over the light sent out, whose loss or gain all others inherit.
constexpr double kByArea = 0.4, kByLeaf = 0.3, kByLight = 0.3;
// A back is not asked for its own error, only for what it sends on.
constexpr double kBack = 0.25;

double light_of(const PatchHead& head, const Spectrum& e) {
  return std::max(0.0, luminance(head.exitance + head.reflectance * e));
}

// The solution's own sums over all patches that receive.
struct Flux {
  double area = 0;  // m²
  double leaves = 0;
  double light = 0;  // lm, luminance of what leaves send out
  std::vector<double> area_of_cluster;
  Spectrum emitted{0}, arriving{0}, reflected{0};  // ∫ M, ∫ E, ∫ ρE dA, lm

  void add(std::size_t cluster, const PatchView& patch) {
    const PatchHead& head = *patch.head;
    const Spectrum e = head.area * mean_irradiance(patch, 0);
    area += head.area;
    area_of_cluster[cluster] += head.area;
    emitted += head.area * head.exitance;
    arriving += e;
    reflected += head.reflectance * e;
    for (std::size_t i = 0; i < patch.elements.size(); ++i) {
      if (!patch.elements[i].leaf()) continue;
      leaves += 1;
      light += patch.elements[i].area * light_of(head, mean_irradiance(patch, i));
    }
  }
  // What the residual and the loss have for a mean, from the flux balance.
  Spectrum balance() const { return (emitted + reflected - arriving) / area; }
  // Points that a leaf is due, up to one factor for all.
  double due(const PatchHead& head, bool back, double leaf_area, const Spectrum& e) const {
    const double sent = light > 0 ? kByLight * leaf_area * light_of(head, e) / light : 0;
    return (back ? kBack : 1) * (kByArea * leaf_area / area + kByLeaf / leaves) + sent;
  }
};

// Clusters room by room, in the model's order: neighbours in space are neighbours here.
std::vector<ClusterId> room_by_room(const Model& model) {
  std::vector<ClusterId> order = all_clusters(model);
  std::stable_sort(order.begin(), order.end(), [&](ClusterId a, ClusterId b) {
    return model.clusters[a.value].room < model.clusters[b.value].room;
  });
  return order;
}

Result<Flux> measure_flux(const Model& model, ClusterStore& store) {
  Flux flux;
  flux.area_of_cluster.assign(model.clusters.size(), 0);
  const Status read = each_receiver(
      store, room_by_room(model),
      [&](ClusterId c, const PatchView& patch) { flux.add(c.value, patch); });
  if (!read.ok()) return read;
  return flux;
}

// A random point, what stands there and what a fresh gather says of it.
struct Sample {
  GatherPoint point;
  std::uint32_t group = 0;
  double weight = 0;  // m², up to one factor for all: the area that it stands for
  bool front = false, bright = false;
  Spectrum reflectance{0};
  Spectrum irradiance{0};  // lx, as solved
  Spectrum radiosity{0};   // lm/m², likewise
  double shown = 0;        // lx, luminance
  Spectrum residual{0};    // lx, fresh − as solved
  Spectrum balanced{0};    // residual + radiosity × share lost: of known mean
  double fresh = 0;        // lx, luminance
  double noise = 0;        // lx, fresh's standard error
  bool open = false;       // some of its rays meet what is lit, or it has light at least
  bool counts() const { return front && open; }
};

Sample sample_at(const PatchView& patch, std::size_t leaf, const Vec2& square) {
  Polygon outline;
  for (const Vec2& v : patch.polygon(patch.elements[leaf])) outline.push_back(patch.point(v));
  const PatchHead& head = *patch.head;
  Sample s;
  s.point.x = point_of(outline, square);
  s.point.normal = head.frame.n;
  const Vec2 p = head.frame.to_plane(s.point.x);
  const auto i = static_cast<std::int32_t>(leaf);
  s.reflectance = head.reflectance;
  s.irradiance = polynomial_at(patch, i, p);
  s.radiosity = head.exitance + head.reflectance * s.irradiance;
  s.shown = luminance(irradiance_at(patch, i, p));
  return s;
}

// One point in each of so many equal parts of what leaves are due, laid out room by room.
class Draw {
 public:
  Draw(const Model& model, const BrightSources& bright, const Flux& flux, double whole,
       const EstimateSettings& settings)
      : model_(model),
        bright_(bright),
        flux_(flux),
        settings_(settings),
        step_(whole / settings.points) {
    place_next();
  }

  void add(ClusterId cluster, const PatchView& patch) {
    const bool back = model_.patches[patch.head->patch].back;
    for (std::size_t i = 0; i < patch.elements.size(); ++i) {
      const Element& e = patch.elements[i];
      if (!e.leaf()) continue;
      const double due = flux_.due(*patch.head, back, e.area, mean_irradiance(patch, i));
      for (passed_ += due; at_ < passed_ && more(); place_next()) {
        const SampleSequence place(derived(settings_.seed, 2 * samples_.size()));
        Sample s = sample_at(patch, i, place.at(0));
        s.point.cluster = cluster;
        s.weight = e.area / due;
        s.front = !back;
        s.bright = bright_.reflects_brightly(patch, static_cast<std::int32_t>(i));
        samples_.push_back(s);
      }
    }
  }
  std::vector<Sample> take() { return std::move(samples_); }

 private:
  bool more() const { return samples_.size() < static_cast<std::size_t>(settings_.points); }
  void place_next() {
    const SampleSequence chance(derived(settings_.seed, 2 * samples_.size() + 1));
    at_ = (static_cast<double>(samples_.size()) + chance.at(0).x) * step_;
  }

  const Model& model_;
  const BrightSources& bright_;
  const Flux& flux_;
  const EstimateSettings& settings_;
  const double step_;
  double passed_ = 0, at_ = 0;
  std::vector<Sample> samples_;
};

Result<std::vector<Sample>> draw_points(const Model& model, ClusterStore& store,
                                        const BrightSources& bright, const Flux& flux,
                                        const EstimateSettings& settings) {
  double whole = 0;
  const auto weigh = [&](ClusterId, const PatchView& patch) {
    const bool back = model.patches[patch.head->patch].back;
    for (std::size_t i = 0; i < patch.elements.size(); ++i)
      if (const Element& e = patch.elements[i]; e.leaf())
        whole += flux.due(*patch.head, back, e.area, mean_irradiance(patch, i));
  };
  const std::vector<ClusterId> order = room_by_room(model);
  ATRIUM_RETURN_IF_ERROR(each_receiver(store, order, weigh));
  Draw draw(model, bright, flux, whole, settings);
  ATRIUM_RETURN_IF_ERROR(each_receiver(
      store, order, [&](ClusterId c, const PatchView& patch) { draw.add(c, patch); }));
  return draw.take();
}

// Runs of clusters with points enough. Each has a second group for its bright elements, since what
// a ceiling reflects onto the lamp below it is not what it reflects into the room.
struct Groups {
  std::vector<std::uint32_t> of_cluster;  // even numbers
  std::vector<double> area_share;  // of all; of a group and its second one in the first's place
};

Groups form_groups(const Model& model, const Flux& flux, std::span<Sample> samples) {
  std::vector<std::size_t> points(model.clusters.size(), 0);
  for (const Sample& s : samples) ++points[s.point.cluster.value];
  Groups groups{std::vector<std::uint32_t>(model.clusters.size(), 0), {0, 0}};
  std::size_t left = samples.size(), held = 0;
  for (const ClusterId c : room_by_room(model)) {
    groups.of_cluster[c.value] = static_cast<std::uint32_t>(groups.area_share.size() - 2);
    groups.area_share[groups.of_cluster[c.value]] += flux.area_of_cluster[c.value] / flux.area;
    held += points[c.value];
    left -= points[c.value];
    if (held < kGroupPoints || left < kGroupPoints) continue;
    held = 0;
    groups.area_share.insert(groups.area_share.end(), 2, 0.0);
  }
  for (Sample& s : samples) s.group = groups.of_cluster[s.point.cluster.value] + s.bright;
  return groups;
}

void compare(const FreshIrradiance& fresh, Sample& s) {
  s.residual = fresh.mean - s.irradiance;
  s.balanced = s.residual + (fresh.escaped + fresh.black) * s.radiosity;
  s.fresh = luminance(fresh.mean);
  s.noise = luminance(fresh.standard_error);
  s.open = s.fresh > 0 || fresh.escaped + fresh.black < kCovered;
}

// What a point's square may count for at the most, and the points' weight, which it is relative to.
struct Caps {
  double all = 0, local = 0;
  double weight = 0;  // m², up to one factor for all
};

// What the points, those of one block left out, say.
struct Answer {
  double square = 0;  // of the error
  double full = 0;    // the same with its worst points in full
  double local = 0;   // as the first, without the smooth part
  double closure = 1;
  Caps caps;
};

// The numbers of one group, means by weight.
struct Group {
  double weight = 0, open = 0;  // of all its points, and of those that are not covered
  double area_share = 0;        // of all
  Spectrum reflected{0};        // ρ r, of those not covered
  Spectrum balanced{0};         // residual and loss
  Spectrum covariance{0};       // of the two means
  Spectrum variance{0};         // of the latter's mean
  double unit = 0;              // of its unknown: bright groups' errors go with their brightness
};

// The most that a square may count for: its share of those that are above their noise, for what
// noise takes off the others may be as much as they are.
double most_of(std::span<const double> squares) {
  constexpr int kRounds = 8;  // each takes off what the last found too much
  double most = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRounds; ++i) {
    double above = 0;
    for (const double x : squares) above += std::clamp(x, 0.0, most);
    most = kMostOfSquare * above;
  }
  return most;
}

double tempered_sum(std::span<const double> squares, double most) {
  double sum = 0;
  for (const double x : squares) sum += std::min(x, most);
  return sum;
}

class Analysis {
 public:
  Analysis(const Flux& flux, const Groups& groups, std::span<const Sample> samples,
           const RayShares& shares)
      : flux_(flux), groups_(groups), samples_(samples), shares_(shares) {}

  // block: left out; kBlocks: none.
  // caps: those that all points together have; none: they are found.
  Answer without(std::size_t block, const Caps* caps = nullptr) const {
    const std::vector<Group> groups = summarise(block);
    const std::vector<Spectrum> spread_out = spread(groups, block);
    Answer answer;
    if (caps) answer.caps = *caps;
    add_squares(spread_out, block, answer);
    Spectrum missing{0};
    for (std::size_t g = 0; g < groups.size(); ++g)
      if (groups[g].weight > 0)
        missing += flux_.area * groups[g].area_share * groups[g].open / groups[g].weight *
                   groups[g].reflected;
    const double emitted = luminance(flux_.emitted);
    if (emitted > 0) answer.closure = 1 - luminance(missing) / emitted;
    return answer;
  }

 private:
  template <class Visit>
  void each(std::size_t block, const Visit& visit) const {
    for (std::size_t i = 0; i < samples_.size(); ++i)
      if (i % kBlocks != block) visit(i, samples_[i]);
  }

  // Means of what the residual adds to radiosity, as the samples have them.
  std::vector<Group> sample_means(std::size_t block) const {
    std::vector<Group> groups(shares_.groups);
    each(block, [&](std::size_t, const Sample& s) {
      Group& g = groups[s.group];
      g.weight += s.weight;
      g.balanced += s.weight * s.balanced;
      if (!s.open) return;
      g.open += s.weight;
      g.reflected += s.weight * s.reflectance * s.residual;
      g.unit += s.weight * (s.bright ? luminance(s.reflectance * s.irradiance) : 1);
    });
    for (std::size_t k = 0; k < groups.size(); ++k) {
      Group& g = groups[k];
      if (!(g.weight > 0)) continue;
      const std::size_t first = k & ~std::size_t{1};
      g.area_share =
          groups_.area_share[first] * g.weight / (groups[first].weight + groups[first + 1].weight);
      g.balanced /= g.weight;
      if (!(g.open > 0)) continue;
      g.reflected /= g.open;
      g.unit /= g.open;
    }
    each(block, [&](std::size_t, const Sample& s) {
      Group& g = groups[s.group];
      const Spectrum y = s.weight / g.weight * (s.balanced - g.balanced);
      g.variance += y * y;
      if (s.open)
        g.covariance += s.weight / g.open * (s.reflectance * s.residual - g.reflected) * y;
    });
    return groups;
  }

  // The same, corrected by what is known of the flux.
  std::vector<Group> summarise(std::size_t block) const {
    std::vector<Group> groups = sample_means(block);
    Spectrum off = -flux_.balance(), variance{0};
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const double a = groups[g].area_share;
      off += a * groups[g].balanced;
      variance += a * a * groups[g].variance;
    }
    for (std::size_t g = 0; g < groups.size(); ++g)
      for (int c = 0; c < kChannels; ++c)
        if (variance[c] > 0)
          groups[g].reflected[c] -=
              groups[g].area_share * groups[g].covariance[c] / variance[c] * off[c];
    return groups;
  }

  // b = u + T b: what each group's radiosity lacks, of bright ones in parts of that; T tells what
  // its points reflect of what comes to them from each group. By Gauss' elimination, without
  // pivots: light dies out from bounce to bounce, so that I − T is an M-matrix.
  std::vector<Spectrum> spread(std::span<const Group> groups, std::size_t block) const {
    const std::size_t n = groups.size();
    std::vector<Spectrum> matrix(n * n, Spectrum{0}), b(n, Spectrum{0});
    each(block, [&](std::size_t i, const Sample& s) {
      if (!s.open) return;
      const std::span<const double> row = shares_.row(i);
      const Group& g = groups[s.group];
      const double share = s.weight / (g.open * g.unit);
      for (std::size_t h = 0; h < n; ++h) matrix[s.group * n + h] -= share * row[h] * s.reflectance;
    });
    for (std::size_t g = 0; g < n; ++g) {
      Spectrum& own = matrix[g * n + g];
      own += Spectrum{1};
      if (g % 2 == 1) own = glm::max(own, Spectrum{1 - kMostReturned});
      if (groups[g].open > 0) b[g] = groups[g].reflected / groups[g].unit;
    }
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t g = k + 1; g < n; ++g) {
        const Spectrum f = matrix[g * n + k] / matrix[k * n + k];
        for (std::size_t h = k; h < n; ++h) matrix[g * n + h] -= f * matrix[k * n + h];
        b[g] -= f * b[k];
      }
    for (std::size_t k = n; k-- > 0;) {
      for (std::size_t h = k + 1; h < n; ++h) b[k] -= matrix[k * n + h] * b[h];
      b[k] /= matrix[k * n + k];
    }
    return b;
  }

  // Light at a point that its sources lack.
  double smooth_part(std::size_t i, std::span<const Spectrum> missing) const {
    const std::span<const double> row = shares_.row(i);
    Spectrum sum{0};
    for (std::size_t h = 0; h < missing.size(); ++h) sum += row[h] * missing[h];
    return luminance(sum);
  }

  void add_squares(std::span<const Spectrum> missing, std::size_t block, Answer& answer) const {
    double mean = 0, weight = 0;
    std::vector<double> smooth(samples_.size(), 0);
    each(block, [&](std::size_t i, const Sample& s) {
      if (!s.counts()) return;
      smooth[i] = smooth_part(i, missing);
      mean += s.weight * (s.fresh + smooth[i]);
      weight += s.weight;
    });
    if (!(mean > 0)) return;
    mean /= weight;
    std::vector<double> all, near;
    each(block, [&](std::size_t i, const Sample& s) {
      if (!s.counts()) return;
      const double scale = std::max(mean, s.fresh + smooth[i]);
      const double share = s.weight / (weight * scale * scale);
      const double off = s.fresh - s.shown, whole = off + smooth[i];
      all.push_back(share * (whole * whole - s.noise * s.noise));
      near.push_back(share * (off * off - s.noise * s.noise));
    });
    if (block == kBlocks) answer.caps = {most_of(all), most_of(near), weight};
    const double fewer = answer.caps.weight / weight;
    answer.square = tempered_sum(all, fewer * answer.caps.all);
    answer.full = std::accumulate(all.begin(), all.end(), 0.0);
    answer.local = tempered_sum(near, fewer * answer.caps.local);
  }

  const Flux& flux_;
  const Groups& groups_;
  std::span<const Sample> samples_;
  const RayShares& shares_;
};

// A figure without what chance adds in the mean, and its standard error. [Efron 82]
struct Jackknifed {
  double value = 0, standard_error = 0;
};

Jackknifed jackknife(double whole, std::span<const Answer> parts, double Answer::*figure) {
  const double n = static_cast<double>(parts.size());
  double mean = 0, squares = 0;
  for (const Answer& a : parts) mean += a.*figure / n;
  for (const Answer& a : parts) squares += (a.*figure - mean) * (a.*figure - mean);
  return {n * whole - (n - 1) * mean, std::sqrt((n - 1) / n * squares)};
}

double root(double square) { return std::sqrt(std::max(0.0, square)); }

// An end of the interval. Squares of heavy tails are skewed: their logarithm is less so, where they
// are more than noise.
double bound(const Jackknifed& square, int side) {
  const double spread = side * kQuantile * square.standard_error;
  if (square.value > square.standard_error)
    return root(square.value) * std::exp(0.5 * spread / square.value);
  return root(square.value + spread);
}

void conclude(const Analysis& analysis, ErrorEstimate& estimate) {
  const Answer whole = analysis.without(kBlocks);
  std::vector<Answer> parts;
  for (std::size_t k = 0; k < kBlocks; ++k) parts.push_back(analysis.without(k, &whole.caps));
  const Jackknifed square = jackknife(whole.square, parts, &Answer::square);
  const Jackknifed full = jackknife(whole.full, parts, &Answer::full);
  const Jackknifed local = jackknife(whole.local, parts, &Answer::local);
  const Jackknifed closure = jackknife(whole.closure, parts, &Answer::closure);
  estimate.error = root(square.value);
  estimate.local = root(local.value);
  estimate.low = bound(square, -1);
  estimate.high = std::max(bound(square, 1), bound(full, 1));
  estimate.closure = closure.value;
  estimate.closure_within = kQuantile * closure.standard_error;
}

// What noise alone would be taken for, root mean square: of normal noise σ, of which so many
// replicates tell, the square less what is taken off for it has the variance σ⁴ (2 + 2 / (n - 1)).
double error_of_noise(std::span<const Sample> samples) {
  double mean = 0, weight = 0, variance = 0;
  for (const Sample& s : samples) {
    if (!s.counts()) continue;
    mean += s.weight * s.fresh;
    weight += s.weight;
  }
  if (!(mean > 0)) return 0;
  mean /= weight;
  for (const Sample& s : samples)
    if (s.counts())
      variance += squared(s.weight / weight * squared(s.noise / std::max(mean, s.fresh)));
  return std::pow((2 + 2.0 / (kReplicates - 1)) * variance, 0.25);
}

}  // namespace

Result<ErrorEstimate> estimate_error(const Model& model, ClusterStore& store, FreshGather& fresh,
                                     const BrightSources& bright,
                                     const EstimateSettings& settings) {
  const std::clock_t start = std::clock();
  const Result<Flux> flux = measure_flux(model, store);
  if (!flux.ok()) return flux.status();
  Result<std::vector<Sample>> drawn = draw_points(model, store, bright, *flux, settings);
  if (!drawn.ok()) return drawn.status();
  std::vector<Sample>& samples = *drawn;
  const Groups groups = form_groups(model, *flux, samples);
  RayShares shares{groups.of_cluster, groups.area_share.size(), {}};
  std::vector<GatherPoint> points;
  for (const Sample& s : samples) points.push_back(s.point);
  ErrorEstimate estimate;
  FreshSettings gather{settings.directions, kReplicates, derived(settings.seed, 0)};
  for (int more = 0;; ++more, gather.directions *= kMoreDirections) {
    const auto fresh_values = fresh.gather(bright, points, gather, &shares);
    if (!fresh_values.ok()) return fresh_values.status();
    for (std::size_t i = 0; i < samples.size(); ++i) compare((*fresh_values)[i], samples[i]);
    if (samples.size() > kBlocks) conclude(Analysis(*flux, groups, samples, shares), estimate);
    estimate.rays += samples.size() * static_cast<std::uint64_t>(gather.directions);
    const double told = std::max(settings.asked, kClear * estimate.error);
    if (settings.asked == 0 || more == kMostMore || error_of_noise(samples) <= told) break;
  }
  estimate.points = samples.size();
  estimate.cpu_seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  return estimate;
}

}  // namespace atrium
