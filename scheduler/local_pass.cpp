#include "scheduler/local_pass.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/squared.h"
#include "scheduler/leaves.h"
#include "scheduler/relight.h"
#include "scheduler/solution.h"
#include "scheduler/stored_patches.h"
#include "solver/coupling.h"
#include "solver/sample_sequence.h"

namespace atrium {

namespace {

// Of a difference d whose noise has the variance v, 1 - kDoubted v / d² is believed: at 1 the risk
// is least for a difference known to be there, most are none.
constexpr double kDoubted = 3;
// Of a piece's mean, what its light may vary by. Beyond, it lies across an edge of a shadow or a rim
// that light leaks to, and its leaves are wrong by different amounts.
constexpr double kEvenEnough = 0.5;
// Independent parts of a node's rays.
constexpr int kReplicates = 2;

RecordId mend_of(ClusterId id) { return record_id(RecordKind::kMend, id.value); }

double believed(double difference, double variance) {
  const double d2 = squared(difference);
  return d2 > kDoubted * variance ? 1 - kDoubted * variance / d2 : 0;
}

// Nothing that the leaves of an element tell apart is worth a measurement of each.
bool is_even(const PatchView& patch, std::size_t element) {
  const std::span<const double> e = patch.e_of(std::int32_t(element));
  return patch.elements[element].detail <= kEvenEnough * luminance(Spectrum{e[0], e[1], e[2]});
}

// By element, which piece it is or is within; -1: it is above pieces.
std::vector<std::int32_t> find_pieces(const PatchView& patch, double area) {
  const std::span<const Element> elements = patch.elements;
  std::vector<std::int32_t> piece_of(elements.size(), -1);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Element& x = elements[i];
    if (x.parent >= 0) piece_of[i] = piece_of[std::size_t(x.parent)];
    if (piece_of[i] < 0 && (x.leaf() || (x.area <= area && is_even(patch, i))))
      piece_of[i] = std::int32_t(i);
  }
  return piece_of;
}

// Whose a point is.
struct PieceNode {
  std::uint32_t patch = 0, element = 0;
};

// The nodes of each piece.
void add_points(const ClusterView& view, ClusterId id, double area,
                std::vector<PieceNode>& owners, std::vector<GatherPoint>& points) {
  for (std::uint32_t p = 0; p < view.size(); ++p) {
    const PatchView patch = view.patch(p);
    if (patch.head->inert) continue;
    const std::vector<std::int32_t> piece_of = find_pieces(patch, area);
    for (std::uint32_t e = 0; e < patch.elements.size(); ++e) {
      if (piece_of[e] != std::int32_t(e)) continue;
      const Site site = make_site(patch, e);
      for (int k = 0; k < site.nodes; ++k) {
        owners.push_back({p, e});
        points.push_back({site.x[k], site.normal, id});
      }
    }
  }
}

// What a patch's fresh gathers say: of each element the mean residual and the variance of its
// luminance, of each piece the basis' coefficients.
class PatchResidual {
 public:
  PatchResidual(const PatchView& patch, double piece_area)
      : patch_(patch),
        k_(std::size_t(patch.k())),
        piece_of_(find_pieces(patch, piece_area)),
        mean_(patch.elements.size(), Spectrum{0}),
        variance_(patch.elements.size(), 0.0),
        slopes_(patch.elements.size() * k_, Spectrum{0}),
        slope_variance_(patch.elements.size() * k_, 0.0) {}

  // One piece by its nodes.
  void add_piece(std::size_t element, std::span<const GatherPoint> points,
                 std::span<const FreshIrradiance> fresh, double pooled) {
    const Site site = make_site(patch_, element);
    for (std::size_t n = 0; n < points.size(); ++n) {
      const Vec2 at = patch_.head->frame.to_plane(points[n].x);
      const std::int32_t leaf = leaf_at(patch_, at, std::int32_t(element));
      const Spectrum r = fresh[n].mean - polynomial_at(patch_, leaf, at);
      // Two replicates tell little by themselves.
      const double variance = std::max(squared(luminance(fresh[n].standard_error)), pooled);
      for (std::size_t a = 0; a < k_; ++a) {
        const double w = site.weight[n] * site.test(int(n))[a];
        slopes_[element * k_ + a] += w * r;
        slope_variance_[element * k_ + a] += squared(w) * variance;
      }
    }
    mean_[element] = slopes_[element * k_];
    variance_[element] = slope_variance_[element * k_];
  }

  // By leaf, in the elements' order: K coefficients to add.
  void mend(std::vector<Spectrum>& out) {
    sum_up();
    const std::vector<Spectrum> told = tell();
    for (std::size_t i = 0; i < told.size(); ++i)
      if (patch_.elements[i].leaf()) mend_leaf(i, told[std::size_t(piece_of_[i])], out);
  }

 private:
  bool above_pieces(std::size_t i) const { return piece_of_[i] < 0; }

  void sum_up() {
    const std::span<const Element> elements = patch_.elements;
    for (std::size_t i = elements.size(); i-- > 0;) {
      if (!above_pieces(i)) continue;
      for (std::size_t c = elements[i].child; c < std::size_t(elements[i].child) + 2; ++c) {
        const double share = elements[c].area / elements[i].area;
        mean_[i] += share * mean_[c];
        variance_[i] += squared(share) * variance_[c];
      }
    }
  }

  // What is believed of the means, down to pieces.
  std::vector<Spectrum> tell() const {
    const std::span<const Element> elements = patch_.elements;
    std::vector<Spectrum> told(elements.size(), Spectrum{0});
    told[0] = believed(luminance(mean_[0]), variance_[0]) * mean_[0];
    for (std::size_t i = 0; i < elements.size(); ++i) {
      if (!above_pieces(i)) continue;
      const std::size_t c = elements[i].child;
      const Spectrum apart = mean_[c + 1] - mean_[c];
      const Spectrum step = believed(luminance(apart), variance_[c] + variance_[c + 1]) * apart;
      told[c] = told[i] - elements[c + 1].area / elements[i].area * step;
      told[c + 1] = told[i] + elements[c].area / elements[i].area * step;
    }
    return told;
  }

  // A piece's mean on a leaf of it. Where that is not the piece itself, light that is too much goes
  // in proportion to what is there, so that the dark side of an edge is left alone.
  void mend_leaf(std::size_t i, const Spectrum& told, std::vector<Spectrum>& out) const {
    const std::size_t piece = std::size_t(piece_of_[i]), first = out.size();
    out.insert(out.end(), k_, Spectrum{0});
    if (piece == i) {
      out[first] = told;
      for (std::size_t a = 1; a < k_; ++a) {
        const Spectrum& slope = slopes_[i * k_ + a];
        out[first + a] = believed(luminance(slope), slope_variance_[i * k_ + a]) * slope;
      }
      return;
    }
    const std::span<const double> all = patch_.e_of(std::int32_t(piece));
    const std::span<const double> own = patch_.e_of(std::int32_t(i));
    for (std::size_t c = 0; c < kChannels; ++c) {
      if (told[c] >= 0) {
        out[first][c] = told[c];
      } else if (all[c] > 0) {
        const double part = std::max(-1.0, told[c] / all[c]);
        for (std::size_t a = 0; a < k_; ++a) out[first + a][c] = part * own[a * kChannels + c];
      }
    }
  }

  const PatchView patch_;
  const std::size_t k_;
  const std::vector<std::int32_t> piece_of_;
  std::vector<Spectrum> mean_;
  std::vector<double> variance_;
  std::vector<Spectrum> slopes_;
  std::vector<double> slope_variance_;
};

// All patches' mends one after the other, those of inert ones empty.
std::vector<Spectrum> mends_of(const ClusterView& view, double piece_area,
                               std::span<const PieceNode> owners,
                               std::span<const GatherPoint> points,
                               std::span<const FreshIrradiance> fresh) {
  std::vector<Spectrum> mends;
  for (std::size_t first = 0, last = 0; first < owners.size(); first = last) {
    double pooled = 0;
    while (last < owners.size() && owners[last].patch == owners[first].patch)
      pooled += squared(luminance(fresh[last++].standard_error));
    pooled /= double(last - first);
    PatchResidual residual(view.patch(owners[first].patch), piece_area);
    for (std::size_t a = first, b = first; a < last; a = b) {
      while (b < last && owners[b].element == owners[a].element) ++b;
      residual.add_piece(owners[a].element, points.subspan(a, b - a), fresh.subspan(a, b - a),
                         pooled);
    }
    residual.mend(mends);
  }
  return mends;
}

}  // namespace

Result<double> mean_leaf_area(const Model& model, ClusterStore& store) {
  double area = 0, leaves = 0;
  const auto count = [&](ClusterId, const PatchView& patch) {
    area += patch.head->area;
    leaves += double(std::ranges::count_if(patch.elements, &Element::leaf));
  };
  ATRIUM_RETURN_IF_ERROR(each_receiver(store, all_clusters(model), count));
  return leaves > 0 ? area / leaves : 0.0;
}

Result<GatherReport> measure_mend(ClusterStore& store, FreshGather& fresh,
                                  const BrightSources& bright, ClusterId id,
                                  const LocalSettings& settings, Equilibrium& equilibrium) {
  GatherReport report;
  const RecordId record = record_id(RecordKind::kCluster, id.value);
  std::vector<PieceNode> owners;
  std::vector<GatherPoint> points;
  {
    const Result<ClusterPin> pin = store.read(record);
    if (!pin.ok()) return pin.status();
    const Result<ClusterView> view = ClusterView::parse(pin->bytes());
    if (!view.ok()) return view.status();
    add_points(*view, id, settings.piece, owners, points);
  }
  const FreshSettings gather{settings.directions, kReplicates, derived(settings.seed, id.value)};
  const auto found = fresh.gather(bright, points, gather);
  if (!found.ok()) return found.status();
  report.refined.rays = points.size() * std::uint64_t(settings.directions);

  const Result<ClusterPin> pin = store.read(record);
  if (!pin.ok()) return pin.status();
  const Result<ClusterView> view = ClusterView::parse(pin->bytes());
  if (!view.ok()) return view.status();
  const std::vector<Spectrum> mends = mends_of(*view, settings.piece, owners, points, *found);
  const PlacedLight pending = equilibrium.pending(id);
  std::vector<PatchGain> gains(view->size());
  std::size_t at = 0;
  for (std::size_t p = 0; p < view->size(); ++p) {
    const PatchView patch = view->patch(p);
    if (patch.head->inert) continue;
    std::vector<PlaceGain>& places = gains[p].places;
    places.resize(pending.by_place(p).size());
    for (const Element& x : patch.elements)
      if (x.leaf()) {
        const PlaceGain gain{x.area, x.area * mends[at]};
        gains[p].gained += gain.gained;
        if (!places.empty()) places[place_among(places.size(), x.place)].add(gain);
        at += std::size_t(patch.k());
      }
  }
  report.elements = view->head().elements;
  ATRIUM_RETURN_IF_ERROR(store.stream_out(mend_of(id), std::as_bytes(std::span(mends))));
  equilibrium.gathered(id, gains);
  return report;
}

Result<GatherReport> put_in_mend(ClusterStore& store, ClusterId id, Equilibrium& equilibrium) {
  Result<ClusterEdit> edit = store.edit(record_id(RecordKind::kCluster, id.value));
  if (!edit.ok()) return edit.status();
  const Result<ClusterView> before = ClusterView::parse(edit->bytes());
  if (!before.ok()) return before.status();
  const Result<std::span<const std::byte>> record = store.stream_in(mend_of(id));
  if (!record.ok()) return record.status();
  std::vector<Spectrum> all(record->size() / sizeof(Spectrum));
  if (!all.empty()) std::memcpy(all.data(), record->data(), all.size() * sizeof(Spectrum));
  if (all.size() != mend_count(*before))
    return Status(Code::kStore, "", to_string(mend_of(id)), "it is not of this cluster's elements",
                  "run atrium check on the run");
  const Relit relit = relight(*before, *edit, equilibrium.pending(id), all);
  equilibrium.gathered(id, relit.gains);
  GatherReport report;
  report.sums = relit.sums;
  report.elements = relit.elements;
  return report;
}

void drop_mend(ClusterStore& store, ClusterId id) {
  if (store.contains(mend_of(id))) store.drop_streamed(mend_of(id));
}

}  // namespace atrium
