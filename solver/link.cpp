#include "solver/link.h"

namespace atrium {

void LinkSet::append(const LinkSet& more) {
  links.insert(links.end(), more.links.begin(), more.links.end());
  couplings.insert(couplings.end(), more.couplings.begin(), more.couplings.end());
  thin.insert(thin.end(), more.thin.begin(), more.thin.end());
  doubts.insert(doubts.end(), more.doubts.begin(), more.doubts.end());
}

Braid plait(ClusterId source, std::span<const LinkSet> sets) {
  Braid b;
  b.source = source;
  std::size_t strands = 0, links = 0, couplings = 0, thin = 0, doubts = 0;
  for (const LinkSet& s : sets) {
    strands += !s.empty();
    links += s.links.size();
    couplings += s.couplings.size();
    thin += s.thin.size();
    doubts += s.doubts.size();
  }
  b.strands.reserve(strands);
  b.links.reserve(links);
  b.couplings.reserve(couplings);
  b.thin.reserve(thin);
  b.doubts.reserve(doubts);
  for (std::size_t p = 0; p < sets.size(); ++p) {
    const LinkSet& s = sets[p];
    if (s.empty()) continue;
    b.strands.push_back({static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(b.links.size()),
                         static_cast<std::uint32_t>(s.links.size()),
                         static_cast<std::uint32_t>(b.thin.size()),
                         static_cast<std::uint32_t>(s.thin.size()),
                         static_cast<std::uint32_t>(b.doubts.size()),
                         static_cast<std::uint32_t>(s.doubts.size())});
    b.links.insert(b.links.end(), s.links.begin(), s.links.end());
    b.couplings.insert(b.couplings.end(), s.couplings.begin(), s.couplings.end());
    b.thin.insert(b.thin.end(), s.thin.begin(), s.thin.end());
    b.doubts.insert(b.doubts.end(), s.doubts.begin(), s.doubts.end());
  }
  return b;
}

}  // namespace atrium
