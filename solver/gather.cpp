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

}  // namespace

std::array<Spectrum, kMaxCoefficients> SourceLight::radiosity(std::uint32_t patch,
                                                              std::uint32_t element) const {
  if (patch >= record_.size())
    return radiosity_of(record_.groups(), patch - record_.size(), pending_);
  if (!installed_.empty()) return radiosity_of(installed_[patch].view(), element, Spectrum{0});
  return radiosity_of(record_.patch(patch), element,
                      pending_.empty() ? Spectrum{0} : pending_[patch]);
}

void gather(const Braid& braid, const Braid::Strand& strand, const SourceLight& source, int order,
            std::span<const Element> receiver, double cap, GatherSlots& slots, RowMean& mean) {
  const int k = coefficient_count(order);
  const std::size_t stride = std::size_t(k) * kGatherChannels;
  const float* coupling = braid.couplings.data() + std::size_t(strand.first_link) * k * k;
  for (const LinkHead& link : std::span(braid.links).subspan(strand.first_link, strand.links)) {
    const Radiosity b = source.radiosity(link.source_patch, link.source);
    double* g = &slots.g[link.receiver * stride];
    mean.form_factors += coupling[0] * receiver[link.receiver].area;
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
    const Radiosity b = source.radiosity(link.ends.source_patch, link.ends.source);
    double* g = &slots.g[link.ends.receiver * stride];
    mean.form_factors += link.coupling * receiver[link.ends.receiver].area;
    g[kRowSum] += link.coupling;
    for (int c = 0; c < kChannels; ++c) g[c] += double(link.coupling) * b[0][c];
  }
  for (const Doubt& doubt : std::span(braid.doubts).subspan(strand.first_doubt, strand.doubts)) {
    const Spectrum b = source.radiosity(doubt.source_patch, 0)[0];
    const double bright = luminance(b);
    mean.light += double(doubt.weight) * (bright > cap ? b * (cap / bright) : b);
    mean.weight += doubt.weight;
  }
}

}  // namespace atrium
