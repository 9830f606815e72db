#include "solver/link.h"

#include <algorithm>

namespace atrium {

void LinkSet::append(const LinkSet& more) {
  links.insert(links.end(), more.links.begin(), more.links.end());
  couplings.insert(couplings.end(), more.couplings.begin(), more.couplings.end());
  thin.insert(thin.end(), more.thin.begin(), more.thin.end());
  doubts.insert(doubts.end(), more.doubts.begin(), more.doubts.end());
  verdicts.insert(verdicts.end(), more.verdicts.begin(), more.verdicts.end());
}

const Braid::Strand* Braid::strand_of(std::uint32_t patch) const {
  const auto at = std::ranges::lower_bound(strands, patch, {}, &Strand::patch);
  return at != strands.end() && at->patch == patch ? &*at : nullptr;
}

Braid plait(ClusterId source, std::span<const LinkSet> sets) {
  Braid b;
  b.source = source;
  std::size_t strands = 0, links = 0, couplings = 0, thin = 0, doubts = 0, verdicts = 0;
  for (const LinkSet& s : sets) {
    strands += !s.empty();
    links += s.links.size();
    couplings += s.couplings.size();
    thin += s.thin.size();
    doubts += s.doubts.size();
    verdicts += s.verdicts.size();
  }
  b.strands.reserve(strands);
  b.links.reserve(links);
  b.couplings.reserve(couplings);
  b.thin.reserve(thin);
  b.doubts.reserve(doubts);
  b.verdicts.reserve(verdicts);
  for (std::size_t p = 0; p < sets.size(); ++p) {
    const LinkSet& s = sets[p];
    if (s.empty()) continue;
    const auto n = [](const auto& items) { return static_cast<std::uint32_t>(items.size()); };
    b.strands.push_back({.patch = static_cast<std::uint32_t>(p),
                         .first_link = n(b.links),
                         .links = n(s.links),
                         .first_thin = n(b.thin),
                         .thin = n(s.thin),
                         .first_doubt = n(b.doubts),
                         .doubts = n(s.doubts),
                         .first_verdict = n(b.verdicts),
                         .verdicts = n(s.verdicts)});
    b.links.insert(b.links.end(), s.links.begin(), s.links.end());
    b.couplings.insert(b.couplings.end(), s.couplings.begin(), s.couplings.end());
    b.thin.insert(b.thin.end(), s.thin.begin(), s.thin.end());
    b.doubts.insert(b.doubts.end(), s.doubts.begin(), s.doubts.end());
    const auto mine = b.verdicts.insert(b.verdicts.end(), s.verdicts.begin(), s.verdicts.end());
    std::ranges::sort(mine, b.verdicts.end(), {}, &Verdict::source_patch);
  }
  return b;
}

}  // namespace atrium
