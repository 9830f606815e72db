// Branch: a part of a patch's tree, cut out so that one large patch is refined by several threads.
// A tree is cut at a few elements, the feet, of which each branch has one as its own. Beside what
// hangs below its foot it holds as stumps what is above all feet, and the other feet. All branches
// of a tree meet the same pairs above the feet, where little is to be done, and decide alike; then
// each goes down to its own. Links that end above the feet are the first branch's.
//
// Invariants:
//  1. Where a tree is cut is a function of the tree alone.
//  2. Stumps come first, and nothing is appended below one that is not the branch's own.
//  3. Grafted in their order, the branches leave the tree and the links that refining it whole
//     would have left, but for the order in which elements were appended and links made.
// Plain data; different branches may be worked on at the same time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "solver/link.h"

namespace atrium {

struct Branch {
  enum class Stump : std::uint8_t { kAbove, kOwn, kOther };

  PatchTree tree;
  std::vector<Stump> stumps;         // of the first elements
  std::vector<std::int32_t> origin;  // in the whole tree, of the elements that were there
  std::int32_t foot = 0;
  bool first = false;

  bool goes_down_to(std::int32_t element) const {
    return std::size_t(element) >= stumps.size() || stumps[element] != Stump::kOther;
  }
  bool links(std::int32_t element) const {
    if (std::size_t(element) >= stumps.size() || stumps[element] == Stump::kOwn) return true;
    return first && stumps[element] == Stump::kAbove;
  }
};

// Nothing where the tree is too small to be worth it.
std::vector<Branch> cut_branches(const PatchTree& tree);

// Puts what was appended to the branch into the tree it was cut from, and renumbers its links, a
// set a source.
void graft(PatchTree& tree, Branch& branch, std::span<LinkSet> links);

}  // namespace atrium
