// PlacedLight: light of a cluster's patches, lx, that is the same all over a patch, or all over
// each of its first places (engine/element.h). Of no patches: there is none anywhere.
// Plain data: to be read by any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engine/spectrum.h"

namespace atrium {

class PlacedLight {
 public:
  // by_place: 2^(d+1), of the places d deep and those above them, which hold their means. Empty: it
  // is the same all over the patch.
  void add_patch(const Spectrum& mean, std::span<const Spectrum> by_place = {}) {
    means_.push_back(mean);
    places_.emplace_back(std::uint32_t(by_place_.size()), std::uint32_t(by_place.size()));
    by_place_.insert(by_place_.end(), by_place.begin(), by_place.end());
  }
  // By patch.
  std::span<const Spectrum> means() const { return means_; }
  Spectrum operator[](std::size_t patch) const {
    return means_.empty() ? Spectrum{0} : means_[patch];
  }
  std::span<const Spectrum> by_place(std::size_t patch) const {
    if (places_.empty()) return {};
    const auto& [first, count] = places_[patch];
    return std::span(by_place_).subspan(first, count);
  }

 private:
  std::vector<Spectrum> means_, by_place_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> places_;  // by patch: first, count
};

}  // namespace atrium
