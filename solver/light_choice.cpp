#include "solver/light_choice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "solver/sample_sequence.h"

namespace atrium {
namespace {

// Of the choices in a region that has learnt, so many go by the tree all the same: a light that the
// pilot missed is at most four times noisier than by the tree alone.
constexpr double kTreeShare = 0.25;

// So many of the pilot's records for a region: a dozen lights are told apart.
constexpr double kRecordsARegion = 64;

constexpr LightChoice::Region kNothingLearnt = ~std::uint32_t{0};

constexpr int kCoordinateBits = 20;                      // of a region's key, for each axis
constexpr std::uint64_t kUsed = std::uint64_t{1} << 63;  // no key is 0

// Which of the six directions along the axes the normal is nearest to.
std::uint64_t facing(const Vec3& n) {
  const Vec3 a = glm::abs(n);
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  return static_cast<std::uint64_t>(2 * axis + (n[axis] < 0));
}

}  // namespace

std::uint64_t LightChoice::key(const Vec3& x, const Vec3& n) const {
  constexpr double kMost = (1 << kCoordinateBits) - 1;
  std::uint64_t key = kUsed >> (3 * kCoordinateBits) | facing(n);
  for (int k = 0; k < 3; ++k)
    key = key << kCoordinateBits |
          static_cast<std::uint64_t>(std::clamp((x[k] - origin_[k]) / edge_, 0.0, kMost));
  return key;
}

// The slot with this key, or the free one where it would stand.
std::size_t LightChoice::slot_of(std::uint64_t key) const {
  std::size_t i = mixed(key) & (slots_.size() - 1);
  while (slots_[i].count != 0 && slots_[i].key != key) i = (i + 1) & (slots_.size() - 1);
  return i;
}

void LightChoice::learn(std::span<const LightRecord> records, double area) {
  if (tree_.size() < 2 || records.empty()) return;
  Box box;
  for (const LightRecord& r : records) box.extend(r.x);
  origin_ = box.lo;
  edge_ = std::sqrt(area * kRecordsARegion / static_cast<double>(records.size()));
  std::map<std::uint64_t, std::map<std::uint32_t, double>> given;
  for (const LightRecord& r : records)
    if (r.given > 0) given[key(r.x, r.n)][r.light] += r.given;
  slots_.assign(std::bit_ceil(2 * given.size() + 1), {});
  for (const auto& [region_key, lights] : given) {
    double sum = 0;
    for (const auto& [light, amount] : lights) sum += amount;
    slots_[slot_of(region_key)] = {region_key, static_cast<std::uint32_t>(shares_.size()),
                                   static_cast<std::uint32_t>(lights.size())};
    double before = 0;
    for (const auto& [light, amount] : lights) {
      shares_.push_back({light, amount / sum, before});
      before += amount / sum;
    }
  }
}

LightChoice::Region LightChoice::region(const Vec3& x, const Vec3& n) const {
  if (slots_.empty()) return kNothingLearnt;
  const std::size_t slot = slot_of(key(x, n));
  return slots_[slot].count == 0 ? kNothingLearnt : static_cast<Region>(slot);
}

double LightChoice::learnt(Region region, std::uint32_t light) const {
  const Slot& slot = slots_[region];
  const auto shares = std::span(shares_).subspan(slot.first, slot.count);
  const auto at = std::lower_bound(shares.begin(), shares.end(), light,
                                   [](const Share& s, std::uint32_t l) { return s.light < l; });
  return at == shares.end() || at->light != light ? 0 : at->share;
}

std::optional<ChosenLight> LightChoice::choose(Region region, const Vec3& x, const Vec3& n,
                                               double u) const {
  if (region == kNothingLearnt) return tree_.choose(x, n, u);
  if (u < kTreeShare) {
    auto chosen = tree_.choose(x, n, u / kTreeShare);
    if (chosen)
      chosen->probability =
          kTreeShare * chosen->probability + (1 - kTreeShare) * learnt(region, chosen->light);
    return chosen;
  }
  const Slot& slot = slots_[region];
  const auto shares = std::span(shares_).subspan(slot.first, slot.count);
  const double at = (u - kTreeShare) / (1 - kTreeShare);
  const auto next = std::upper_bound(shares.begin() + 1, shares.end(), at,
                                     [](double v, const Share& s) { return v < s.before; });
  const Share& share = *(next - 1);
  return ChosenLight{share.light, (1 - kTreeShare) * share.share +
                                      kTreeShare * tree_.probability(x, n, share.light)};
}

double LightChoice::probability(Region region, const Vec3& x, const Vec3& n,
                                std::uint32_t light) const {
  const double by_tree = tree_.probability(x, n, light);
  if (region == kNothingLearnt) return by_tree;
  return kTreeShare * by_tree + (1 - kTreeShare) * learnt(region, light);
}

}  // namespace atrium
