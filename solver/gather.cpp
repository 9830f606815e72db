#include "solver/gather.h"

#include <algorithm>
#include <array>

namespace atrium {

namespace {

using Radiosity = std::array<Spectrum, kMaxCoefficients>;

// B = M + ρE of an element, coefficient by coefficient.
Radiosity radiosity_of(const PatchView& patch, std::size_t element, const Spectrum& pending) {
  Radiosity b;
  const std::span<const double> e = patch.e_of(element);
  for (int i = 0; i < patch.k(); ++i)
    b[i] = patch.head->reflectance * Spectrum{e[3 * i], e[3 * i + 1], e[3 * i + 2]};
  b[0] += patch.head->exitance + patch.head->reflectance * pending;
  return b;
}

Radiosity radiosity_of(const GroupView& groups, std::size_t group,
                       std::span<const Spectrum> pending) {
  const FaceGroup& g = groups.groups[group];
  Radiosity b{};
  b[0] = g.radiosity;
  if (!pending.empty()) b[0] += g.reflectance * pending[groups.any_patch(g)];
  return b;
}

// Light that a link from a coarse element leaves out, of the colour of what it brings.
void add_detail(const SourceLight& source, const LinkHead& link, double detail, Spectrum& b) {
  const double share = source.detail_share(link.source_patch) * detail, bright = luminance(b);
  if (share != 0 && bright > 0) b *= std::max(0.0, 1 + share / bright);
}

void note(std::vector<SentDetail>& details, std::uint32_t patch, double factor, double sent,
          double detail) {
  if (details.empty() || details.back().source_patch != patch) details.push_back({patch});
  details.back().factors += factor;
  details.back().sent += sent;
  details.back().left_out += factor * detail;
}

}  // namespace

std::array<Spectrum, kMaxCoefficients> SourceLight::radiosity(std::uint32_t p,
                                                              std::uint32_t element) const {
  if (p >= record_.size()) return radiosity_of(record_.groups(), p - record_.size(), pending_);
  const bool waits = installed_.empty() && !pending_.empty();
  return radiosity_of(patch(p), element, waits ? pending_[p] : Spectrum{0});
}

double SourceLight::detail(std::uint32_t p, std::uint32_t element) const {
  if (p >= record_.size()) return 0;
  const PatchView source = patch(p);
  if (source.head->escape != 0) return 0;
  return luminance(source.head->reflectance) * source.elements[element].detail;
}

void gather(const Braid& braid, const Braid::Strand& strand, const SourceLight& source, int order,
            std::span<const Element> receiver, double cap, GatherSlots& slots, RowMean& mean,
            std::vector<SentDetail>& details) {
  const int k = coefficient_count(order);
  const std::size_t stride = std::size_t(k) * kGatherChannels;
  const float* coupling = braid.couplings.data() + std::size_t(strand.first_link) * k * k;
  for (const LinkHead& link : std::span(braid.links).subspan(strand.first_link, strand.links)) {
    Radiosity b = source.radiosity(link.source_patch, link.source);
    const double detail = source.detail(link.source_patch, link.source);
    const double area = receiver[link.receiver].area;
    double sent = 0;
    for (int j = 0; j < k; ++j) sent += coupling[j] * luminance(b[j]);
    note(details, link.source_patch, coupling[0] * area, sent * area, detail);
    add_detail(source, link, detail, b[0]);
    double* g = &slots.g[link.receiver * stride];
    mean.form_factors += coupling[0] * area;
    for (int i = 0; i < k; ++i, g += kGatherChannels) {
      g[kRowSum] += coupling[i * k];
      for (int j = 0; j < k; ++j) {
        const double f = coupling[i * k + j];
        for (int c = 0; c < kChannels; ++c) g[c] += f * b[j][c];
      }
    }
    coupling += k * k;
  }
  for (const ThinLink& link : std::span(braid.thin).subspan(strand.first_thin, strand.thin)) {
    Spectrum b = source.radiosity(link.ends.source_patch, link.ends.source)[0];
    const double detail = source.detail(link.ends.source_patch, link.ends.source);
    const double factor = link.coupling * receiver[link.ends.receiver].area;
    note(details, link.ends.source_patch, factor, factor * luminance(b), detail);
    add_detail(source, link.ends, detail, b);
    double* g = &slots.g[link.ends.receiver * stride];
    mean.form_factors += factor;
    g[kRowSum] += link.coupling;
    for (int c = 0; c < kChannels; ++c) g[c] += double(link.coupling) * b[c];
  }
  for (const Doubt& doubt : std::span(braid.doubts).subspan(strand.first_doubt, strand.doubts)) {
    const Spectrum b = source.radiosity(doubt.source_patch, 0)[0];
    const double bright = luminance(b);
    mean.light += double(doubt.weight) * (bright > cap ? b * (cap / bright) : b);
    mean.weight += doubt.weight;
  }
}

}  // namespace atrium
