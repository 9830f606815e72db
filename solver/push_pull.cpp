#include "solver/push_pull.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/squared.h"
#include "solver/basis.h"

namespace atrium {

namespace {

// Of a leaf's doubts, what the patch's mean counts for: the standard deviation squared of what is
// hardly in doubt.
constexpr double kOfPatch = 1e-8;

// H of functions up to linear ones in closed form: in the child's own x and y, which its functions
// are orthonormal combinations of, the parent's are linear too. The child must be no needle.
void two_scale_of_linear(std::span<const double> child, std::span<const double> parent,
                         const Vec2& shift, double scale, std::span<double> h) {
  // Triangles of 1; x; x and y. <φ1, x>, <φ1, y> and <φ2, y> of the child; <φ2, x> is 0.
  const double x1 = 1 / child[2], y2 = 1 / child[5], y1 = -child[4] * x1 * y2;
  const std::array<double, 9> linear{1, parent[2] * shift.x,
                                     parent[4] * shift.x + parent[5] * shift.y,
                                     0, scale * parent[2] * x1,
                                     scale * (parent[4] * x1 + parent[5] * y1),
                                     0, 0, scale * parent[5] * y2};
  std::ranges::copy(linear, h.begin());
}

// Sets H, K×K and zero: H[i][j] = <φi of the child, φj of its parent> over the child, mean.
void two_scale(const PatchView& v, std::size_t ci, std::span<double> h) {
  const Element& child = v.elements[ci];
  const std::size_t pi = child.parent;
  const Element& parent = v.elements[pi];
  const int k = v.k();
  const std::span<const double> own = v.basis_of(ci);
  if (v.order == 1) {
    h[0] = 1;
    return;
  }
  if (v.order == 2 && own[2] > 0 && own[5] > 0)
    return two_scale_of_linear(own, v.basis_of(pi),
                               (child.centroid - parent.centroid) / parent.radius,
                               child.radius / parent.radius, h);
  for_each_product_node(v.polygon(child), child, v.order, [&](const Node& node) {
    const BasisValues c = evaluate_basis(own, child, v.order, node.p);
    const BasisValues p = evaluate_basis(v.basis_of(pi), parent, v.order, node.p);
    for (int i = 0; i < k; ++i)
      for (int j = 0; j < k; ++j) h[i * k + j] += node.weight * c[i] * p[j];
  });
}

// More than there is cannot be taken off: a mean below 0 becomes 0. What varies about it fades out
// as far as it is below, and not at once: leaves that a sweep put a little below 0 and the next one
// a little above turned their surroundings back and forth for ever.
void keep_from_negative(std::span<double> g, int channel) {
  double& mean = g[std::size_t(channel)];
  if (!(mean < 0)) return;
  double varies2 = 0;
  for (std::size_t a = kGatherChannels; a < g.size(); a += kGatherChannels)
    varies2 += squared(g[a + std::size_t(channel)]);
  const double kept = varies2 > 0 ? std::max(0.0, 1 + mean / std::sqrt(varies2)) : 0;
  for (std::size_t a = kGatherChannels; a < g.size(); a += kGatherChannels)
    g[a + std::size_t(channel)] *= kept;
  mean = 0;
}

// lm/m², of what the leaf's row misses; the patch's mean as far as its doubts do not explain it.
Spectrum mean_radiosity(const DoubtSlot& leaf, double missing, const Closing& closing) {
  const double unexplained = std::max(kOfPatch, squared(missing) - leaf.weight);
  return (leaf.light + unexplained * closing.mean_radiosity) / (leaf.weight + unexplained);
}

void close_row(std::span<double> g, const DoubtSlot& doubts, const Closing& closing) {
  if (closing.how == Closing::How::kOpen) return;
  if (too_much(closing)) {
    const double scale = closing.whole / std::max(closing.whole, g[kRowSum]);
    for (double& x : g) x *= scale;
    if (closing.how == Closing::How::kNoMore) return;
  }
  const bool each = closing.how != Closing::How::kWholePatch;
  const Spectrum mean = mean_radiosity(doubts, each ? 1 - g[kRowSum] : closing.missing, closing);
  for (std::size_t a = 0; a < g.size(); a += kGatherChannels) {
    // The row is 1 everywhere: the basis' first function alone.
    const double whole = a == 0 ? 1 : 0;
    const double missing = each ? whole - g[a + kRowSum] : whole * closing.missing;
    for (int c = 0; c < kChannels; ++c) g[a + c] += missing * mean[c];
    g[a + kRowSum] += missing;
  }
  for (int c = 0; c < kChannels; ++c) keep_from_negative(g, c);
}

// e of a leaf, as gathered, becomes old + over (e - old), unless its mean would be negative.
void go_beyond(std::span<double> e, const double* old, double over) {
  if (over == 1) return;
  for (int c = 0; c < kChannels; ++c)
    if (old[c] + over * (e[c] - old[c]) < 0) return;
  for (std::size_t n = 0; n < e.size(); ++n) e[n] = old[n] + over * (e[n] - old[n]);
}

}  // namespace

void PushPullSums::add(const PushPullSums& s) {
  change2 += s.change2;
  change += s.change;
  flux_in += s.flux_in;
  gained += s.gained;
  beyond += s.beyond;
  area += s.area;
  absorbed += s.absorbed;
  reflected += s.reflected;
  emitted += s.emitted;
  escaped += s.escaped;
}

void add_everywhere(PatchTree& tree, const Spectrum& e) {
  const std::size_t stride = std::size_t(tree.view().k()) * kChannels;
  for (std::size_t at = 0; at < tree.e.size(); at += stride)
    for (int c = 0; c < kChannels; ++c) tree.e[at + c] += e[c];
}

void add_placed(PatchTree& tree, const PlacedLight& light, std::size_t patch) {
  const std::span<const Spectrum> by_place = light.by_place(patch);
  if (by_place.empty()) return add_everywhere(tree, light[patch]);
  const std::size_t stride = std::size_t(tree.view().k()) * kChannels;
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    const Spectrum& e = by_place[place_among(by_place.size(), tree.elements[i].place)];
    for (int c = 0; c < kChannels; ++c) tree.e[i * stride + std::size_t(c)] += e[c];
  }
}

void hand_down(PatchTree& tree, std::int32_t parent, std::int32_t child) {
  const PatchView v = tree.view();
  const int k = v.k();
  std::array<double, kMaxCoefficients * kMaxCoefficients> h{};
  two_scale(v, child, h);
  double* from = &tree.e[std::size_t(parent) * k * kChannels];
  double* to = &tree.e[std::size_t(child) * k * kChannels];
  for (int i = 0; i < k; ++i)
    for (int c = 0; c < kChannels; ++c) {
      double sum = 0;
      for (int j = 0; j < k; ++j) sum += h[i * k + j] * from[j * kChannels + c];
      to[i * kChannels + c] = sum;
    }
}

PushPullSums push_pull(PatchTree& tree, GatherSlots& slots, const Closing& closing, double over,
                       std::span<PlaceGain> gains) {
  const PatchView v = tree.view();
  const int k = v.k();
  const std::size_t stride = std::size_t(k) * kGatherChannels;
  std::vector<double>& g = slots.g;
  std::vector<double> scales(tree.elements.size() * k * k, 0.0);
  const auto scale_of = [&](std::size_t i) { return std::span(scales).subspan(i * k * k, k * k); };

  // Push: children stand behind their parent, so one sweep forward reaches every leaf.
  for (std::size_t i = 1; i < tree.elements.size(); ++i) {
    const std::size_t p = tree.elements[i].parent;
    slots.doubts[i].add(slots.doubts[p]);
    const std::span<double> scale = scale_of(i);
    two_scale(v, i, scale);
    for (int a = 0; a < k; ++a)
      for (int b = 0; b < k; ++b)
        for (int c = 0; c < kGatherChannels; ++c)
          g[i * stride + a * kGatherChannels + c] +=
              scale[a * k + b] * g[p * stride + b * kGatherChannels + c];
  }

  PushPullSums sums;
  for (std::size_t i = tree.elements.size(); i-- > 0;) {
    Element& x = tree.elements[i];
    double* e = &tree.e[i * k * kChannels];
    double old[kMaxCoefficients * kChannels];
    for (int n = 0; n < k * kChannels; ++n) old[n] = e[n];
    if (x.leaf()) {
      close_row(std::span(g).subspan(i * stride, stride), slots.doubts[i], closing);
      for (int a = 0; a < k; ++a)
        for (int c = 0; c < kChannels; ++c)
          e[a * kChannels + c] = g[i * stride + a * kGatherChannels + c];
      x.detail = 0;
    } else {
      // Pull: the L2 projection of the children's E, and the norm of what it leaves out.
      for (int n = 0; n < k * kChannels; ++n) e[n] = 0;
      double norm2 = 0;
      for (std::size_t ci = x.child; ci < std::size_t(x.child) + 2; ++ci) {
        const Element& child = tree.elements[ci];
        const double share = child.area / x.area;
        const std::span<const double> scale = scale_of(ci);
        const double* ce = &tree.e[ci * k * kChannels];
        norm2 += share * squared(child.detail);
        for (int b = 0; b < k; ++b) {
          norm2 += share * squared(luminance({ce[b * 3], ce[b * 3 + 1], ce[b * 3 + 2]}));
          for (int a = 0; a < k; ++a)
            for (int c = 0; c < kChannels; ++c)
              e[a * kChannels + c] += share * scale[b * k + a] * ce[b * kChannels + c];
        }
      }
      for (int a = 0; a < k; ++a)
        norm2 -= squared(luminance({e[a * 3], e[a * 3 + 1], e[a * 3 + 2]}));
      x.detail = std::sqrt(std::max(0.0, norm2));
      continue;
    }
    const Spectrum& rho = tree.head.reflectance;
    for (int a = 0; a < k; ++a) {
      const Spectrum now{e[a * 3], e[a * 3 + 1], e[a * 3 + 2]};
      const Spectrum was{old[a * 3], old[a * 3 + 1], old[a * 3 + 2]};
      sums.change2 += x.area * squared(luminance(rho * (now - was)));
      if (a == 0) sums.change += x.area * std::abs(luminance(rho * (now - was)));
    }
    const Spectrum gathered{e[0], e[1], e[2]};
    go_beyond(std::span(e, std::size_t(k) * kChannels), old, over);
    const Spectrum mean{e[0], e[1], e[2]};
    const PlaceGain gain{x.area, x.area * (mean - Spectrum{old[0], old[1], old[2]}),
                         x.area * (mean - gathered)};
    sums.beyond += gain.beyond;
    sums.gained += gain.gained;
    if (!gains.empty()) gains[place_among(gains.size(), x.place)].add(gain);
    sums.flux_in += x.area * luminance(mean);
    sums.area += x.area;
    sums.absorbed += x.area * (Spectrum{1} - rho) * mean;
    sums.reflected += x.area * rho * mean;
    sums.emitted += x.area * tree.head.exitance;
    const double leaving = std::clamp(1 - g[i * stride + kRowSum], 0.0, 1.0);
    if (tree.head.escape > 0) sums.escaped += x.area * leaving * (rho * mean + tree.head.exitance);
  }
  return sums;
}

}  // namespace atrium
