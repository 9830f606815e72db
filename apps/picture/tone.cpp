#include "apps/picture/tone.h"

#include <algorithm>
#include <cmath>

namespace atrium {
namespace {

constexpr double kMiddle = 0.30;      // of white, where the typical luminance goes
constexpr double kBrightShare = 0.9;  // of the picture is not to be brighter than ...
constexpr double kBright = 0.95;      // ... this much of white
constexpr double kDarkest = 1e-3;     // of the median; what is darker is taken for black paint
constexpr double kShoulder = 0.8;     // of white, where the scale stops being linear

double at_share(const std::vector<Weighted>& sorted, double total, double share) {
  double sum = 0;
  for (const Weighted& v : sorted) {
    sum += v.weight;
    if (sum >= share * total) return v.luminance;
  }
  return sorted.back().luminance;
}

float rolled_off(double x) {
  if (x <= kShoulder) return static_cast<float>(std::max(x, 0.0));
  const double room = 1 - kShoulder;
  return static_cast<float>(1 - room * std::exp(-(x - kShoulder) / room));
}

std::uint8_t srgb_byte(float linear) {
  const double x = std::clamp(static_cast<double>(linear), 0.0, 1.0);
  const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

}  // namespace

double automatic_exposure(std::vector<Weighted> values) {
  std::erase_if(values, [](const Weighted& v) { return !(v.luminance > 0 && v.weight > 0); });
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end(),
            [](const Weighted& a, const Weighted& b) { return a.luminance < b.luminance; });
  double total = 0;
  for (const Weighted& v : values) total += v.weight;
  const double median = at_share(values, total, 0.5);
  double logs = 0, counted = 0;
  for (const Weighted& v : values) {
    if (v.luminance < kDarkest * median) continue;
    logs += v.weight * std::log2(v.luminance);
    counted += v.weight;
  }
  const double typical = std::exp2(logs / counted);
  const double bright = at_share(values, total, kBrightShare);
  return std::log2(std::min(kMiddle / typical, kBright / bright));
}

Pixel tone_mapped(const Pixel& luminance, double exposure_ev) {
  const double scale = std::exp2(exposure_ev);
  return {rolled_off(scale * luminance[0]), rolled_off(scale * luminance[1]),
          rolled_off(scale * luminance[2])};
}

std::vector<std::uint8_t> srgb_bytes(const Image& image) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * image.pixels.size());
  for (const Pixel& p : image.pixels)
    for (const float c : p) bytes.push_back(srgb_byte(c));
  return bytes;
}

}  // namespace atrium
