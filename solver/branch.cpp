#include "solver/branch.h"

#include <algorithm>

namespace atrium {

namespace {

constexpr std::size_t kMostBranches = 4;
// Elements that a branch is worth its stumps for.
constexpr std::int32_t kWorthwhile = 64;

// Elements below each, itself with them.
std::vector<std::int32_t> count_below(const PatchTree& tree) {
  std::vector<std::int32_t> below(tree.elements.size(), 1);
  for (std::size_t i = tree.elements.size(); i-- > 1;) below[tree.elements[i].parent] += below[i];
  return below;
}

// The feet: those with most below them go down to their children, until there are enough.
std::vector<std::int32_t> find_feet(const PatchTree& tree) {
  const std::vector<std::int32_t> below = count_below(tree);
  std::vector<std::int32_t> feet{0};
  while (feet.size() < kMostBranches) {
    const auto most = std::ranges::max_element(
        feet, {}, [&](std::int32_t foot) { return below[foot]; });
    if (below[*most] < 2 * kWorthwhile) break;
    const std::int32_t child = tree.elements[*most].child;
    *most = child;
    feet.push_back(child + 1);
  }
  std::ranges::sort(feet);
  return feet;
}

// Copies element i behind the last of `to`; its parent and child are still those of `from`.
void copy_element(const PatchTree& from, std::size_t i, PatchTree& to) {
  const PatchView v = from.view();
  const auto append = [](auto& list, const auto& more) {
    list.insert(list.end(), more.begin(), more.end());
  };
  Element x = from.elements[i];
  const std::span<const Vec2> outline = v.polygon(x);
  x.first_vertex = static_cast<std::uint32_t>(to.vertices.size());
  to.elements.push_back(x);
  append(to.vertices, outline);
  append(to.e, v.e_of(i));
  append(to.basis, v.basis_of(i));
}

Branch cut_branch(const PatchTree& tree, std::span<const std::int32_t> feet, std::size_t own) {
  constexpr std::int32_t kNotHere = -1;
  // Of each element of the tree: the foot that it hangs from, or is; none above the feet.
  std::vector<std::int32_t> foot_of(tree.elements.size(), kNotHere), at(foot_of);
  Branch branch;
  branch.first = own == 0;
  branch.tree.head = tree.head;
  branch.tree.order = tree.order;
  branch.tree.contacts = tree.contacts;
  const auto take = [&](std::size_t i) {
    at[i] = static_cast<std::int32_t>(branch.origin.size());
    branch.origin.push_back(static_cast<std::int32_t>(i));
    copy_element(tree, i, branch.tree);
  };
  for (const std::int32_t foot : feet) foot_of[foot] = foot;
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    const bool is_foot = foot_of[i] == static_cast<std::int32_t>(i);
    const std::int32_t parent = tree.elements[i].parent;
    if (!is_foot && parent >= 0) foot_of[i] = foot_of[parent];
    if (!is_foot && foot_of[i] != kNotHere) continue;
    take(i);
    branch.stumps.push_back(!is_foot                      ? Branch::Stump::kAbove
                            : foot_of[i] == feet[own] ? Branch::Stump::kOwn
                                                      : Branch::Stump::kOther);
  }
  branch.foot = at[feet[own]];
  for (std::size_t i = 0; i < tree.elements.size(); ++i)
    if (foot_of[i] == feet[own] && at[i] == kNotHere) take(i);
  for (Element& x : branch.tree.elements) {
    if (x.parent >= 0) x.parent = at[x.parent];
    if (x.child >= 0) x.child = at[x.child];  // none here of another's foot
  }
  return branch;
}

void renumber(LinkSet& links, std::span<const std::int32_t> origin) {
  const auto renumber_all = [&](auto& items) {
    for (auto& item : items)
      item.ends.receiver = static_cast<std::uint32_t>(origin[item.ends.receiver]);
  };
  renumber_all(links.links);
  renumber_all(links.thin);
  renumber_all(links.doubts);
}

}  // namespace

std::vector<Branch> cut_branches(const PatchTree& tree) {
  const std::vector<std::int32_t> feet = find_feet(tree);
  std::vector<Branch> branches;
  if (feet.size() > 1)
    for (std::size_t own = 0; own < feet.size(); ++own)
      branches.push_back(cut_branch(tree, feet, own));
  return branches;
}

void graft(PatchTree& tree, Branch& branch, std::span<LinkSet> links) {
  std::vector<std::int32_t>& origin = branch.origin;
  const std::size_t there = origin.size();
  for (std::size_t i = there; i < branch.tree.elements.size(); ++i) {
    origin.push_back(static_cast<std::int32_t>(tree.elements.size()));
    copy_element(branch.tree, i, tree);
  }
  for (std::size_t i = 0; i < branch.tree.elements.size(); ++i) {
    const Element& x = branch.tree.elements[i];
    if (i < there && x.child < static_cast<std::int32_t>(there)) continue;  // as it was
    Element& grafted = tree.elements[origin[i]];
    if (x.child >= 0) grafted.child = origin[x.child];
    if (i >= there) grafted.parent = origin[x.parent];
  }
  for (LinkSet& set : links) renumber(set, origin);
}

}  // namespace atrium
