// Links and braids. A link carries light to an element of the receiver from an element of a source
// by a K×K matrix of coupling coefficients, visibility included; a thin link, for transfers too weak
// to matter in shape, by one number between means. A braid is the set of links between two
// clusters, sorted by the receiver's patches. [THFH94 §4]
#pragma once

#include <cstdint>
#include <vector>

#include "engine/id.h"

namespace atrium {

struct LinkHead {
  std::uint32_t receiver = 0;      // element, local to the receiving patch
  std::uint32_t source_patch = 0;  // local to the source cluster
  std::uint32_t source = 0;        // element, local to that patch
};

struct ThinLink {
  LinkHead ends;
  float coupling = 0;
};

// The links of one receiving patch to one source cluster.
struct LinkSet {
  std::vector<LinkHead> links;
  std::vector<float> couplings;  // links × K × K, row: receiver's function, column: source's
  std::vector<ThinLink> thin;

  std::size_t count() const { return links.size() + thin.size(); }
  std::size_t bytes() const {
    return links.size() * sizeof(LinkHead) + couplings.size() * sizeof(float) +
           thin.size() * sizeof(ThinLink);
  }
};

struct Braid {
  ClusterId source;
  std::vector<LinkSet> sets;  // one a patch of the receiver
  std::size_t count() const {
    std::size_t n = 0;
    for (const LinkSet& s : sets) n += s.count();
    return n;
  }
  std::size_t bytes() const {
    std::size_t n = sizeof(Braid) + sets.size() * sizeof(LinkSet);
    for (const LinkSet& s : sets) n += s.bytes();
    return n;
  }
};

}  // namespace atrium
