#include "apps/report/interaction_matrix.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "engine/check.h"

namespace atrium {
namespace {

// A cell in which a single pair interacts still shows, and few look different from many.
constexpr double kFaintest = 0.12;  // of black
constexpr double kShade = 0.5;      // power of the share
constexpr double kGamma = 2.2;      // from what is seen to light

float light_of(double share) {
  if (share == 0) return 1;
  const double dark = kFaintest + (1 - kFaintest) * std::pow(share, kShade);
  return static_cast<float>(std::pow(1 - dark, kGamma));
}

double common_sources(const Rows<ClusterId>& visible, std::span<const ClusterId> order) {
  std::size_t common = 0, all = 0;
  std::vector<ClusterId> both;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const auto before = visible[order[i - 1].value], now = visible[order[i].value];
    both.clear();
    std::ranges::set_intersection(before, now, std::back_inserter(both));
    common += both.size();
    all += now.size();
  }
  return all > 0 ? double(common) / double(all) : 0;
}

}  // namespace

InteractionMatrix interaction_matrix(const Rows<ClusterId>& visible,
                                     std::span<const ClusterId> order, std::size_t most_cells) {
  const std::size_t n = order.size();
  ATRIUM_CHECK(n > 0 && visible.size() == n);
  InteractionMatrix m;
  m.clusters = n;
  m.pairs = visible.items.size();
  m.side = std::min(n, most_cells);
  m.share.resize(m.side * m.side);
  std::vector<std::size_t> place(n), width(m.side);
  for (std::size_t i = 0; i < n; ++i) place[order[i].value] = i;
  const auto cell_of = [&](std::size_t i) { return i * m.side / n; };
  for (std::size_t i = 0; i < n; ++i) ++width[cell_of(i)];
  for (std::size_t receiver = 0; receiver < n; ++receiver)
    for (const ClusterId source : visible[receiver]) {
      const std::size_t row = cell_of(place[receiver]), column = cell_of(place[source.value]);
      m.share[row * m.side + column] += 1;
    }
  for (std::size_t i = 0; i < m.share.size(); ++i)
    m.share[i] /= double(width[i / m.side]) * double(width[i % m.side]);
  m.common = common_sources(visible, order);
  return m;
}

Image matrix_image(const InteractionMatrix& matrix) {
  const int side = static_cast<int>(matrix.side);
  Image image(side, side);
  auto share = matrix.share.begin();
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const float light = light_of(*share++);
      image.at(column, side - 1 - row) = {light, light, light};
    }
  return image;
}

}  // namespace atrium
