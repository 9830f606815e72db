// Links and braids. A link carries light to an element of the receiver from an element of a source
// by a K×K matrix of coupling coefficients, visibility included; a thin link, for transfers too
// weak to matter in shape, by one number between means. A braid is the set of links between two
// clusters, sorted by the receiver's patches. [THFH94 §4]
//
// Where patches are numbered here, a cluster's face groups (engine/face_group.h) come after its
// patches: what is numbered patches + g is group g, and its only element is 0. Of the K×K
// coefficients of a link to or from a group those beyond its mean are 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/id.h"

namespace atrium {

struct Ends {
  std::uint32_t receiver = 0;      // element, local to the receiving patch
  std::uint32_t source_patch = 0;  // local to the source cluster
  std::uint32_t source = 0;        // element, local to that patch
};

// How unsure a form factor is, as its variance, is its doubt: what a row misses may be there, in
// proportion, and there at the element whose row it is.
struct LinkHead {
  Ends ends;
  float doubt = 0;
};

struct ThinLink {
  Ends ends;
  float coupling = 0;
  double doubt() const {  // one segment got through of one: the rule of succession
    constexpr double kVariance = 2.0 / 9;
    return kVariance * double(coupling) * double(coupling);
  }
};

// Of a transfer that no ray got through, so that it has no link.
struct Doubt {
  Ends ends;
  float doubt = 0;
};

// A pair of patches that was linked as a whole, or not at all, and what may be wrong of that,
// weighed as errors of links are (refine.h): as long as it is below the threshold, a finer level
// would decide the same, and the pair keeps what it has.
struct Verdict {
  std::uint32_t source_patch = 0;  // local to the source cluster
  float of_light = 0;              // error per lm/m² of the source's radiosity
  float of_detail = 0;             // the same of how that varies
  float at_least = 0;              // error, be the source as dark as may be
};

// The links of one receiving patch or group to one source cluster, while they are made.
struct LinkSet {
  std::vector<LinkHead> links;
  std::vector<float> couplings;  // links × K × K, row: receiver's function, column: source's
  std::vector<ThinLink> thin;
  std::vector<Doubt> doubts;
  std::vector<Verdict> verdicts;  // of patches that are in no group
  bool empty() const {
    return links.empty() && thin.empty() && doubts.empty() && verdicts.empty();
  }
  void append(const LinkSet& more);
};

// All links between two clusters, in one run of each kind.
struct Braid {
  // One receiving patch's or group's part.
  struct Strand {
    std::uint32_t patch = 0;  // local to the receiver
    std::uint32_t first_link = 0, links = 0;
    std::uint32_t first_thin = 0, thin = 0;
    std::uint32_t first_doubt = 0, doubts = 0;
    std::uint32_t first_verdict = 0, verdicts = 0;
  };
  ClusterId source;
  std::vector<Strand> strands;  // of the patches that have links, ascending
  std::vector<LinkHead> links;
  std::vector<float> couplings;
  std::vector<ThinLink> thin;
  std::vector<Doubt> doubts;
  std::vector<Verdict> verdicts;  // a strand's by source patch, ascending

  const Strand* strand_of(std::uint32_t patch) const;  // null: it has none
  std::size_t count() const { return links.size() + thin.size(); }
  // Has the receiver anything to gather across it, or does it hold verdicts alone?
  bool carries_light() const { return count() + doubts.size() > 0; }
  std::size_t bytes() const {
    return sizeof(Braid) + strands.size() * sizeof(Strand) + links.size() * sizeof(LinkHead) +
           couplings.size() * sizeof(float) + thin.size() * sizeof(ThinLink) +
           doubts.size() * sizeof(Doubt) + verdicts.size() * sizeof(Verdict);
  }
};

// One braid of the sets of a receiver's patches.
Braid plait(ClusterId source, std::span<const LinkSet> sets);

}  // namespace atrium
