#include "solver/gather.h"

#include <algorithm>
#include <array>

namespace atrium {

namespace {

using Radiosity = std::array<Spectrum, kMaxCoefficients>;

// B = M + ρE of an element, coefficient by coefficient.
Radiosity radiosity_of(const PatchView& patch, std::size_t element) {
  Radiosity b;
  const std::span<const double> e = patch.e_of(element);
  for (int i = 0; i < patch.k(); ++i)
    b[i] = patch.head->reflectance * Spectrum{e[3 * i], e[3 * i + 1], e[3 * i + 2]};
  b[0] += patch.head->exitance;
  return b;
}

// Weight of a link of full size in the mean that closes a row; a thin one's is 1.
constexpr double kSure = 0.01;

void add_to_mean(const Element& receiver, const Spectrum& b, double form_factor, double unsure,
                 double cap, RowMean& mean) {
  const double flow = form_factor * receiver.area, bright = luminance(b);
  mean.form_factors += flow;
  mean.light += unsure * flow * (bright > cap ? b * (cap / bright) : b);
  mean.weight += unsure * flow;
}

}  // namespace

void gather(const Braid& braid, const Braid::Strand& strand, const ClusterView& source, int order,
            std::span<const Element> receiver, double cap, GatherSlots& slots, RowMean& mean) {
  const int k = coefficient_count(order);
  const std::size_t stride = std::size_t(k) * kGatherChannels;
  const float* coupling = braid.couplings.data() + std::size_t(strand.first_link) * k * k;
  for (const LinkHead& link : std::span(braid.links).subspan(strand.first_link, strand.links)) {
    const Radiosity b = radiosity_of(source.patch(link.source_patch), link.source);
    double* g = &slots.g[link.receiver * stride];
    add_to_mean(receiver[link.receiver], b[0], coupling[0], kSure, cap, mean);
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
    const Radiosity b = radiosity_of(source.patch(link.ends.source_patch), link.ends.source);
    double* g = &slots.g[link.ends.receiver * stride];
    add_to_mean(receiver[link.ends.receiver], b[0], link.coupling, 1, cap, mean);
    g[kRowSum] += link.coupling;
    for (int c = 0; c < kChannels; ++c) g[c] += double(link.coupling) * b[0][c];
  }
}

}  // namespace atrium
