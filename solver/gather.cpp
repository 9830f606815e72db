#include "solver/gather.h"

#include <algorithm>
#include <array>
#include <optional>

namespace atrium {

namespace {

using Radiosity = std::array<Spectrum, kMaxCoefficients>;

// Light that a link from a coarse element leaves out, of the colour of what it brings.
void add_detail(const Sender& from, double detail, Spectrum& b) {
  const double share = from.detail_share() * detail, bright = luminance(b);
  if (share != 0 && bright > 0) b *= std::max(0.0, 1 + share / bright);
}

void note(std::vector<SentDetail>& details, std::uint32_t patch, double factor, double sent,
          double detail) {
  if (details.empty() || details.back().source_patch != patch) details.push_back({patch});
  details.back().factors += factor;
  details.back().sent += sent;
  details.back().left_out += factor * detail;
}

// Of a source of radiosity b.
DoubtSlot doubt_of(double doubt, const Spectrum& b, double cap) {
  const double bright = luminance(b);
  return {doubt, doubt * (bright > cap ? b * (cap / bright) : b)};
}

void add_doubt(const DoubtSlot& doubt, double area, DoubtSlot& slot, RowMean& mean) {
  slot.add(doubt);
  mean.doubts.add(doubt, area);
}

// The patch that the last link came from, which the next one mostly comes from too.
class LastSender {
 public:
  explicit LastSender(const SourceLight& source) : source_(source) {}
  const Sender& of(std::uint32_t patch) {
    if (!sender_ || patch != patch_) sender_.emplace(source_.of(patch_ = patch));
    return *sender_;
  }

 private:
  const SourceLight& source_;
  std::uint32_t patch_ = 0;
  std::optional<Sender> sender_;
};

// Across links of K×K coefficients. K is known when this is compiled: it is the innermost loop of
// a sweep over kept links.
template <int K>
void gather_links(const Braid& braid, const Braid::Strand& strand, LastSender& senders,
                  std::span<const Element> receiver, double cap, GatherSlots& slots,
                  RowMean& mean, std::vector<SentDetail>* details) {
  constexpr std::size_t kStride = std::size_t(K) * kGatherChannels;
  const float* coupling = braid.couplings.data() + std::size_t(strand.first_link) * K * K;
  for (const LinkHead& link : std::span(braid.links).subspan(strand.first_link, strand.links)) {
    const Ends& ends = link.ends;
    const Sender& from = senders.of(ends.source_patch);
    Radiosity b = from.radiosity(ends.source);
    const double detail = from.detail(ends.source);
    const double area = receiver[ends.receiver].area;
    add_doubt(doubt_of(link.doubt, b[0], cap), area, slots.doubts[ends.receiver], mean);
    if (details) {
      double sent = 0;
      for (int j = 0; j < K; ++j) sent += coupling[j] * luminance(b[j]);
      note(*details, ends.source_patch, coupling[0] * area, sent * area, detail);
    }
    add_detail(from, detail, b[0]);
    double* g = &slots.g[ends.receiver * kStride];
    mean.form_factors += coupling[0] * area;
    for (int i = 0; i < K; ++i, g += kGatherChannels) {
      g[kRowSum] += coupling[i * K];
      for (int j = 0; j < K; ++j) {
        const double f = coupling[i * K + j];
        for (int c = 0; c < kChannels; ++c) g[c] += f * b[j][c];
      }
    }
    coupling += K * K;
  }
}

}  // namespace

Sender::Sender(const PatchView& patch, const Spectrum& pending, std::span<const Spectrum> by_place,
               double detail_share)
    : elements_(patch.elements),
      e_(patch.e.data()),
      pending_(by_place),
      k_(patch.k()),
      reflectance_(patch.head->reflectance),
      constant_(patch.head->exitance +
                (by_place.empty() ? reflectance_ * pending : Spectrum{0})),
      detail_sent_(patch.head->escape == 0 ? luminance(patch.head->reflectance) : 0),
      detail_share_(detail_share) {}

Sender::Sender(const FaceGroup& group, const Spectrum& pending)
    : constant_(group.radiosity + group.reflectance * pending) {}

std::array<Spectrum, kMaxCoefficients> Sender::radiosity(std::uint32_t element) const {
  Radiosity b;
  if (elements_.empty()) {
    b.fill(Spectrum{0});
  } else {
    const double* e = e_ + std::size_t(element) * k_ * kChannels;
    for (int i = 0; i < k_; ++i)
      b[i] = reflectance_ * Spectrum{e[3 * i], e[3 * i + 1], e[3 * i + 2]};
  }
  b[0] += constant(element);
  return b;
}

Spectrum Sender::mean_radiosity(std::uint32_t element) const {
  if (elements_.empty()) return constant_;
  const double* e = e_ + std::size_t(element) * k_ * kChannels;
  return reflectance_ * Spectrum{e[0], e[1], e[2]} + constant(element);
}

double Sender::detail(std::uint32_t element) const {
  return elements_.empty() ? 0 : detail_sent_ * elements_[element].detail;
}

Sender SourceLight::of(std::uint32_t p) const {
  if (p >= record_.size()) {
    const GroupView groups = record_.groups();
    const FaceGroup& g = groups.groups[p - record_.size()];
    return Sender(g, pending_[groups.any_patch(g)]);
  }
  const double share = p < detail_share_.size() ? detail_share_[p] : 0;
  if (!installed_.empty()) return Sender(installed_[p].view(), Spectrum{0}, {}, share);
  return Sender(record_.patch(p), pending_[p], pending_.by_place(p), share);
}

void gather(const Braid& braid, const Braid::Strand& strand, const SourceLight& source, int order,
            std::span<const Element> receiver, double cap, GatherSlots& slots, RowMean& mean,
            std::vector<SentDetail>* details) {
  LastSender senders(source);
  static_assert(kMaxOrder == 3);
  const auto links = order == 1   ? gather_links<coefficient_count(1)>
                     : order == 2 ? gather_links<coefficient_count(2)>
                                  : gather_links<coefficient_count(3)>;
  links(braid, strand, senders, receiver, cap, slots, mean, details);

  const std::size_t stride = std::size_t(coefficient_count(order)) * kGatherChannels;
  for (const ThinLink& link : std::span(braid.thin).subspan(strand.first_thin, strand.thin)) {
    const Sender& from = senders.of(link.ends.source_patch);
    Spectrum b = from.mean_radiosity(link.ends.source);
    const double detail = from.detail(link.ends.source);
    const double area = receiver[link.ends.receiver].area, factor = link.coupling * area;
    add_doubt(doubt_of(link.doubt(), b, cap), area, slots.doubts[link.ends.receiver], mean);
    if (details) note(*details, link.ends.source_patch, factor, factor * luminance(b), detail);
    add_detail(from, detail, b);
    double* g = &slots.g[link.ends.receiver * stride];
    mean.form_factors += factor;
    g[kRowSum] += link.coupling;
    for (int c = 0; c < kChannels; ++c) g[c] += double(link.coupling) * b[c];
  }
  for (const Doubt& d : std::span(braid.doubts).subspan(strand.first_doubt, strand.doubts)) {
    const Spectrum b = senders.of(d.ends.source_patch).mean_radiosity(d.ends.source);
    add_doubt(doubt_of(d.doubt, b, cap), receiver[d.ends.receiver].area,
              slots.doubts[d.ends.receiver], mean);
  }
}

}  // namespace atrium
