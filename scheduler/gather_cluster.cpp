#include "scheduler/gather_cluster.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "engine/stopwatch.h"
#include "solver/face_groups.h"
#include "solver/form_factor.h"

namespace atrium {

namespace {

// R as installed into the working set.
struct Receiver {
  std::vector<PatchTree> trees;
  GroupTree groups;
  std::vector<Element> as_elements;  // the groups, of which only their area counts
  std::vector<GatherSlots> slots;    // of the patches, then of the groups; so all that follow
  std::vector<RowMean> means;
  std::vector<PatchGain> gains;      // of the patches
  RefineCounters refined;
  std::vector<std::vector<SentDetail>> details;  // of the braid at hand; empty: nobody asks

  Receiver(const ClusterView& view, bool asks_for_details)
      : trees(read_record(view)),
        groups(read_groups(view)),
        as_elements(groups.groups.size()),
        slots(trees.size() + groups.groups.size()),
        means(slots.size()),
        gains(trees.size()),
        details(asks_for_details ? slots.size() : 0) {
    for (std::size_t p = 0; p < trees.size(); ++p)
      slots[p].reset(trees[p].elements.size(), trees[p].view().k());
    for (std::size_t g = 0; g < as_elements.size(); ++g) {
      slots[trees.size() + g].reset(1, trees[0].view().k());
      as_elements[g].area = groups.groups[g].area;
    }
  }
  std::span<const Element> elements_of(std::uint32_t patch) const {
    if (patch < trees.size()) return trees[patch].elements;
    return std::span(as_elements).subspan(patch - trees.size(), 1);
  }
  std::uint64_t elements() const {
    std::uint64_t n = 0;
    for (const PatchTree& t : trees) n += t.elements.size();
    return n;
  }
};

int count_escapes(const PatchTree& tree, const Site& root, const RayScene& rays, int count,
                  double tolerance) {
  int escaped = 0;
  for (int first = 0; first < count; first += kRayLanes) {
    RayPacket packet;
    HitPacket hits;
    for (int i = first; i < first + kRayLanes; ++i)
      packet.set(i - first, root.x[i % root.nodes], cosine_direction(tree.head.frame, i, count),
                 tolerance);
    rays.closest_hit16(packet, hits);
    escaped += kRayLanes - std::popcount(hits.found);
  }
  return escaped;
}

// Share of the patch's cosine-weighted directions that leave the scene. Origins go round the
// nodes of the root; a patch that sees an opening is looked at again, closer.
double measure_escape(const PatchTree& tree, const RayScene& rays, double tolerance) {
  constexpr int kFirstLook = 256, kSecondLook = 2048;
  static_assert(kFirstLook % kRayLanes == 0 && kSecondLook % kRayLanes == 0);
  const Site root = make_site(tree.view(), 0);
  if (count_escapes(tree, root, rays, kFirstLook, tolerance) == 0) return 0;
  return double(count_escapes(tree, root, rays, kSecondLook, tolerance)) / kSecondLook;
}

// The same where nothing can stand between: exact at the root's nodes.
double escape_past(std::span<const BlockerPolygon> outlines, const PatchTree& tree) {
  constexpr double kClosed = 1e-7;  // below it, what is left of the sum is the form factors' noise
  const Site root = make_site(tree.view(), 0);
  double escape = 0;
  for (int k = 0; k < root.nodes; ++k) {
    double met = 0;
    for (const BlockerPolygon& b : outlines)
      met += point_to_polygon_in_sum(root.x[k], root.normal, b.polygon);
    escape += root.weight[k] * (1 - met);
  }
  return escape > kClosed ? escape : 0;
}

void measure_escapes(Receiver& receiver, const RayWorld& world, double tolerance) {
  const Surroundings around = world.surroundings();
  tbb::parallel_for(std::size_t(0), receiver.trees.size(), [&](std::size_t p) {
    PatchTree& tree = receiver.trees[p];
    if (!tree.head.inert && tree.head.escape < 0)
      tree.head.escape = around.rays ? measure_escape(tree, *around.rays, tolerance)
                                     : escape_past(world.outlines(), tree);
  });
}

void cut_at_contacts(const GatherTask& task, Receiver& receiver) {
  tbb::parallel_for(std::size_t(0), receiver.trees.size(), [&](std::size_t p) {
    PatchTree& tree = receiver.trees[p];
    if (tree.head.inert) return;
    Refiner(task.refine, Surroundings{}).cut_at_contacts(tree);
    receiver.slots[p].grow(tree.elements.size(), tree.view().k());
  });
}

// Where receiving begins: groups that are part of no other, and patches in no group.
std::vector<std::uint32_t> receiving_roots(const Receiver& receiver) {
  std::vector<bool> grouped(receiver.trees.size(), false);
  for (const GroupMember& m : receiver.groups.members) grouped[m.patch] = true;
  std::vector<std::uint32_t> roots;
  for (std::size_t p = 0; p < grouped.size(); ++p)
    if (!grouped[p] && !receiver.trees[p].head.inert) roots.push_back(std::uint32_t(p));
  for (std::size_t g = 0; g < receiver.groups.groups.size(); ++g)
    if (!receiver.groups.groups[g].inner) roots.push_back(std::uint32_t(grouped.size() + g));
  return roots;
}

// S as installed into the working set.
struct Source {
  ClusterId id;
  ClusterPin pin;               // its record is used in place, or
  std::vector<std::byte> copy;  // from a small arena, with others; R's own is held already
  ClusterView view;
  PlacedLight pending;
};

// Records of sources that are installed together, bytes: enough for all threads to have work. Which
// they are does not depend on the arena.
constexpr std::size_t kMostInstalled = std::size_t{2} << 20;
// More than one is pinned where the arena holds so many times as much: R may grow beside them.
constexpr std::size_t kRoomy = 16;

// 3(a), (b) Read S and install it: one where links are kept, a few where they are to be made.
Result<std::vector<Source>> read_sources(const GatherTask& task, ClusterStore& store,
                                         const ClusterView& before,
                                         std::span<const ClusterId> sources) {
  std::vector<Source> installed;
  std::size_t bytes = 0;
  bool alone = task.linking == Linking::kUseKept;
  const RecordId own = record_id(RecordKind::kCluster, task.receiver.value);
  const bool roomy = store.arena_bytes() / kRoomy >= kMostInstalled + store.size(own);
  for (const ClusterId s : sources) {
    const RecordId id = record_id(RecordKind::kCluster, s.value);
    if (s != task.receiver && !alone) bytes += store.size(id);
    alone |= bytes > kMostInstalled;
    if (alone && !installed.empty()) break;
    Source& source = installed.emplace_back(s, ClusterPin{}, std::vector<std::byte>{}, before,
                                            task.equilibrium->pending(s));
    if (s != task.receiver) {
      Result<ClusterPin> read = store.read(id);
      if (!read.ok()) return read.status();
      source.pin = std::move(read).value();
      std::span<const std::byte> record = source.pin.bytes();
      if (!alone && !roomy) {
        source.copy.assign(record.begin(), record.end());
        record = source.copy;
        source.pin = {};
      }
      const Result<ClusterView> view = ClusterView::parse(record);
      if (!view.ok()) return view.status();
      source.view = *view;
    }
    if (alone) break;
  }
  return installed;
}

using Stays = std::vector<bool>;  // by the source's patches: is it linked as it is to be already?

// What one thread links: some of the roots, or a branch of one.
struct LinkingTask {
  std::vector<std::size_t> roots;  // positions among the receiving roots
  Branch* branch = nullptr;
  std::vector<LinkSet> sets;  // of the branch, by source
  RefineCounters refined;
};

// Large patches are cut into branches; small ones share a refiner, and with it packets of rays. How
// many is for the receiver alone to say, not for the threads.
std::vector<LinkingTask> share_out(std::span<std::vector<Branch>> branches) {
  constexpr std::size_t kTasks = 16, kMost = 32;
  const std::size_t step = std::clamp(branches.size() / kTasks, std::size_t(1), kMost);
  std::vector<LinkingTask> tasks;
  for (std::size_t r = 0; r < branches.size(); ++r)
    for (Branch& b : branches[r]) tasks.push_back({{r}, &b, {}, {}});
  std::size_t small = step;  // in the last task
  for (std::size_t r = 0; r < branches.size(); ++r) {
    if (!branches[r].empty()) continue;
    if (small == step) {
      tasks.emplace_back();
      small = 0;
    }
    tasks.back().roots.push_back(r);
    ++small;
  }
  return tasks;
}

// 3(c), (d) Tubes and Install( links in Braid(R, S, T) ) for each S: R's patches are shared out,
// and each meets the sources in their order. What the level before decided as it would be decided
// now stays; `before` has its braids with the same sources, or is empty.
std::vector<Braid> make_braids(const GatherTask& task, const Surroundings& around,
                               std::span<const Source> installed, std::span<const Braid> before,
                               Receiver& receiver) {
  const std::size_t patches = receiver.trees.size();
  const std::vector<std::uint32_t> roots = receiving_roots(receiver);
  std::vector<SourceRoots> from(installed.size());
  std::vector<std::vector<LinkSet>> sets(installed.size());
  tbb::parallel_for(std::size_t(0), installed.size(), [&](std::size_t i) {
    from[i] = SourceRoots(installed[i].view, task.refine.ambient, installed[i].pending.means());
    sets[i].resize(receiver.slots.size());
  });
  std::vector<std::vector<Branch>> branches(roots.size());
  std::vector<std::vector<Stays>> stays(roots.size());  // by source; those of groups are empty
  tbb::parallel_for(std::size_t(0), roots.size(), [&](std::size_t r) {
    stays[r].resize(installed.size());
    if (roots[r] >= patches) return;
    branches[r] = cut_branches(receiver.trees[roots[r]]);
    Refiner refiner(task.refine, around);
    for (std::size_t i = 0; i < before.size(); ++i)
      if (const Braid::Strand* s = before[i].strand_of(roots[r]))
        stays[r][i] = refiner.take_over(before[i], *s, from[i], sets[i][roots[r]]);
  });

  std::vector<LinkingTask> tasks = share_out(branches);
  tbb::parallel_for(std::size_t(0), tasks.size(), [&](std::size_t t) {
    LinkingTask& mine = tasks[t];
    Refiner refiner(task.refine, around);
    if (mine.branch) mine.sets.resize(installed.size());
    for (const std::size_t r : mine.roots) {
      const std::uint32_t root = roots[r];
      for (std::size_t i = 0; i < installed.size(); ++i) {
        if (mine.branch)
          refiner.link(*mine.branch, from[i], mine.sets[i], stays[r][i]);
        else if (root < patches)
          refiner.link(receiver.trees[root], from[i], sets[i][root], stays[r][i]);
        else
          refiner.link({receiver.trees, receiver.groups.view(), sets[i]},
                       root - std::uint32_t(patches), from[i]);
      }
    }
    refiner.flush();
    mine.refined = refiner.counters();
  });

  for (LinkingTask& t : tasks) {
    receiver.refined.add(t.refined);
    if (!t.branch) continue;
    const std::uint32_t root = roots[t.roots[0]];
    graft(receiver.trees[root], *t.branch, t.sets);
    for (std::size_t i = 0; i < installed.size(); ++i) sets[i][root].append(t.sets[i]);
  }
  for (std::size_t p = 0; p < patches; ++p)
    receiver.slots[p].grow(receiver.trees[p].elements.size(), receiver.trees[p].view().k());
  std::vector<Braid> braids(installed.size());
  tbb::parallel_for(std::size_t(0), installed.size(),
                    [&](std::size_t i) { braids[i] = plait(installed[i].id, sets[i]); });
  return braids;
}

void gather_strand(const GatherTask& task, const SourceLight& source, const Braid& braid,
                   const Braid::Strand& s, Receiver& receiver) {
  if (s.links + s.thin + s.doubts == 0) return;  // verdicts alone
  gather(braid, s, source, receiver.trees[0].order, receiver.elements_of(s.patch), task.lamp_cap,
         receiver.slots[s.patch], receiver.means[s.patch],
         receiver.details.empty() ? nullptr : &receiver.details[s.patch]);
}

// What a braid has brought of its source, by its units. Of faces that groups stand for as well,
// what links bring is not all.
void note_sent(const Equilibrium& equilibrium, const SourceLight& light, const Braid& braid,
               Receiver& receiver, std::vector<UnitDetail>& sent) {
  if (receiver.details.empty()) return;
  const std::span<const std::uint32_t> units = equilibrium.units_of(braid.source);
  for (const Braid::Strand& s : braid.strands) {
    std::vector<SentDetail>& details = receiver.details[s.patch];
    for (const SentDetail& d : details) {
      if (d.source_patch >= units.size()) continue;  // a group
      const std::uint32_t unit = units[d.source_patch];
      if (light.grouped() && unit == equilibrium.rest_unit(braid.source)) continue;
      if (sent.empty() || sent.back().unit != unit) sent.push_back({unit});
      const double mean = luminance(light.of(d.source_patch).mean_radiosity(0));
      sent.back().sent += d.sent;
      sent.back().missed += mean * d.factors - d.sent;
      sent.back().left_out += d.left_out;
    }
    details.clear();
  }
}

// Does what is independent one after the other where it is too little to be worth sharing: waking
// the other threads takes longer than a hundred links.
template <class Do>
void each_of(std::size_t count, bool worth_sharing, const Do& one) {
  if (worth_sharing)
    tbb::parallel_for(std::size_t(0), count, one);
  else
    for (std::size_t i = 0; i < count; ++i) one(i);
}

// 3(e) Gather( each patch of R ) across the braid with one source.
void transfer(const GatherTask& task, const SourceLight& source, const Braid& braid,
              Receiver& receiver) {
  constexpr std::size_t kWorthSharing = 512;  // links
  each_of(braid.strands.size(), braid.count() >= kWorthSharing, [&](std::size_t i) {
    gather_strand(task, source, braid, braid.strands[i], receiver);
  });
}

// A row sums to what does not leave the scene. Where nothing does that holds for every leaf; where
// little does, for the patch as a whole, of which it was measured; an open patch's row is left as
// it is. Rows far beyond would let light grow from bounce to bounce: they are scaled.
Closing closing_of(const PatchTree& tree, const RowMean& mean) {
  constexpr double kOpen = 0.1;   // share of directions that leave
  constexpr double kMost = 1.05;  // what the doubts may take off, of what stays
  Closing c;
  const double row = mean.form_factors / tree.head.area;
  c.whole = 1 - tree.head.escape;
  c.missing = c.whole - row;
  if (!(mean.doubts.weight > 0)) return c;
  c.mean_radiosity = mean.doubts.light / mean.doubts.weight;
  if (row > kMost)
    c.how = tree.head.escape == 0 ? Closing::How::kNoMoreNorLess : Closing::How::kNoMore;
  else if (tree.head.escape <= kOpen)
    c.how = tree.head.escape == 0 ? Closing::How::kEachLeaf : Closing::How::kWholePatch;
  return c;
}

// What is pending becomes part of R; inert patches, which no unit is of, have no light.
void take_pending(const Equilibrium& equilibrium, ClusterId id, Receiver& receiver) {
  const PlacedLight pending = equilibrium.pending(id);
  for (std::size_t p = 0; p < receiver.trees.size(); ++p)
    if (!receiver.trees[p].head.inert) add_placed(receiver.trees[p], pending, p);
}

// 4. Invoke solver PushPull( each patch of R )
PushPullSums push_pull_patch(const GatherTask& task, const PlacedLight& pending,
                             Receiver& receiver, std::size_t p) {
  PatchTree& tree = receiver.trees[p];
  if (tree.head.inert) return {};
  // What groups gather is a sweep behind, and going beyond it would not settle.
  const double over = receiver.groups.groups.empty() ? task.over : 1;
  PatchGain& gain = receiver.gains[p];
  gain.places.resize(pending.by_place(p).size());
  const PushPullSums sums = push_pull(tree, receiver.slots[p],
                                      closing_of(tree, receiver.means[p]), over, gain.places);
  gain.gained = sums.gained;
  gain.beyond = sums.beyond;
  return sums;
}

// 3(e) across the cluster's braid with itself, and 4. A patch that sees others of its cluster
// gathers from what they hold by then, in the order of their units: so light that goes round inside
// of a cluster settles as it does between clusters. Groups, whose light is not at hand before their
// patches', gather from the record as they do from other clusters.
std::vector<PushPullSums> gather_within(const GatherTask& task, const ClusterView& before,
                                        const Braid* own, Receiver& receiver,
                                        std::vector<UnitDetail>& sent) {
  const std::size_t patches = receiver.trees.size();
  const PlacedLight pending = task.equilibrium->pending(task.receiver);
  const std::vector<double> shares = task.equilibrium->detail_shares(task.receiver);
  const SourceLight as_read(before, pending, shares);
  const SourceLight by_now(before, pending, shares, receiver.trees);
  std::vector<const Braid::Strand*> strand_of(patches, nullptr);
  for (const Braid::Strand& s : own ? own->strands : std::span<const Braid::Strand>()) {
    if (s.patch < patches)
      strand_of[s.patch] = &s;
    else
      gather_strand(task, as_read, *own, s, receiver);
  }
  push_groups(receiver.groups.view(), receiver.trees, receiver.slots, receiver.means);

  constexpr std::size_t kWorthSharing = 1024;  // elements
  std::vector<PushPullSums> sums(patches);
  each_of(patches, receiver.elements() >= kWorthSharing, [&](std::size_t p) {
    if (!strand_of[p]) sums[p] = push_pull_patch(task, pending, receiver, p);
  });
  for (const std::uint32_t p : task.equilibrium->by_unit(task.receiver)) {
    if (!strand_of[p]) continue;
    gather_strand(task, by_now, *own, *strand_of[p], receiver);
    sums[p] = push_pull_patch(task, pending, receiver, p);
  }
  if (own) note_sent(*task.equilibrium, by_now, *own, receiver, sent);
  return sums;
}

// The receiver's part of the coarse system, and what this gather has changed.
void tell(Equilibrium& equilibrium, ClusterId id, const Receiver& receiver,
          std::span<const UnitDetail> sent, CoarseRows* rows) {
  equilibrium.gathered(id, receiver.gains);
  if (rows) {
    for (std::size_t p = 0; p < receiver.trees.size(); ++p)
      rows->close(p, receiver.trees[p], closing_of(receiver.trees[p], receiver.means[p]));
    equilibrium.set_rows(*rows);
  }
  equilibrium.sent(sent);
}

}  // namespace

Result<GatherReport> gather_cluster(const Model& model, ClusterStore& store, RayWorlds& worlds,
                                    const GatherTask& task) {
  GatherReport report;
  const RecordId id = record_id(RecordKind::kCluster, task.receiver.value);

  // 1. Read R. The record keeps what it held until 5, so R can be a source to itself.
  Result<ClusterEdit> edit = store.edit(id);
  if (!edit.ok()) return edit.status();
  const Result<ClusterView> before = ClusterView::parse(edit->bytes());
  if (!before.ok()) return before.status();

  // 2. Install R into working set.
  Receiver receiver(*before, task.equilibrium->learns());
  Surroundings around;
  std::size_t blocker_bytes = 0;
  if (task.linking != Linking::kUseKept) {
    const RayWorld& world = worlds.of(task.receiver);
    around = world.surroundings();
    blocker_bytes = world.bytes();
    measure_escapes(receiver, world, task.refine.tolerance);
  }
  take_pending(*task.equilibrium, task.receiver, receiver);
  if (task.linking != Linking::kUseKept) cut_at_contacts(task, receiver);

  // 3. For each source cluster S visible to R
  const std::span<const ClusterId> sources = model.visible[task.receiver.value];
  std::vector<Braid> made(task.linking == Linking::kUseKept ? 0 : sources.size());
  const Braid* own = nullptr;
  std::vector<Braid>* kept = &made;
  if (task.linking == Linking::kUseKept) {
    const Result<std::vector<Braid>*> braids = task.links->of(task.receiver);
    if (!braids.ok()) return braids.status();
    kept = *braids;
  }
  std::span<const Braid> last_level;  // of the level before, with the same sources
  if (task.linking == Linking::kMakeAndKeep) {
    const Result<std::span<const Braid>> past = task.links->past(task.receiver);
    if (!past.ok()) return past.status();
    last_level = *past;
    ATRIUM_CHECK(last_level.empty() || last_level.size() == sources.size());
  }
  std::optional<CoarseRows> rows;
  if (task.linking != Linking::kUseKept)
    rows.emplace(task.equilibrium->coarse_units(), task.receiver);
  std::uint64_t most_source_elements = 0;  // installed at once
  std::vector<UnitDetail> sent;
  const double start = now(), io_before = store.counters().io_seconds;
  for (std::size_t first = 0; first < sources.size();) {
    if (task.linking == Linking::kUseKept && !task.links->carries_light(task.receiver, first)) {
      report.link_bytes += (*kept)[first++].bytes();
      continue;
    }
    const Result<std::vector<Source>> installed =
        read_sources(task, store, *before, sources.subspan(first));
    if (!installed.ok()) return installed.status();
    const auto part_of = [&](std::span<const Braid> of_all) {
      return of_all.empty() ? of_all : of_all.subspan(first, installed->size());
    };
    if (task.linking != Linking::kUseKept)
      std::ranges::move(make_braids(task, around, *installed, part_of(last_level), receiver),
                        kept->begin() + first);
    std::uint64_t source_elements = 0;
    for (std::size_t i = 0; i < installed->size(); ++i) {
      const Source& source = (*installed)[i];
      Braid& braid = (*kept)[first + i];
      // (e) Gather; from itself when all others have sent.
      if (source.id == task.receiver) {
        own = &braid;
      } else {
        const std::vector<double> shares = task.equilibrium->detail_shares(source.id);
        const SourceLight light(source.view, source.pending, shares);
        transfer(task, light, braid, receiver);
        note_sent(*task.equilibrium, light, braid, receiver, sent);
      }
      if (rows) rows->add(braid, source.view, receiver.trees, receiver.groups.view());
      report.links += braid.count();
      report.link_bytes += braid.bytes();
      source_elements += source.view.head().elements;
      // (f) Discard links where they are not kept.
      if (task.linking == Linking::kMakeAndDiscard && source.id != task.receiver) braid = {};
    }
    report.source_elements += source_elements;
    most_source_elements = std::max(most_source_elements, source_elements);
    first += installed->size();
    // (g) to (j) Release S.
  }

  const std::vector<PushPullSums> sums = gather_within(task, *before, own, receiver, sent);
  pull_groups(receiver.trees, receiver.groups);
  for (const PushPullSums& s : sums) report.sums.add(s);
  report.refined = receiver.refined;
  report.solver_seconds = now() - start - (store.counters().io_seconds - io_before);

  // What may fail comes before R changes: a gather is done wholly or not at all.
  // 5. Extract R, 6. SetDirty, 7. Release.
  report.elements = receiver.elements();
  const std::size_t bytes = record_bytes(receiver.trees, receiver.groups);
  const std::size_t bytes_before = edit->bytes().size();
  ATRIUM_RETURN_IF_ERROR(edit->resize(bytes));
  if (task.linking == Linking::kMakeAndKeep) {
    const Status kept_all = task.links->keep(task.receiver, std::move(made));
    if (!kept_all.ok()) {
      ATRIUM_RETURN_IF_ERROR(edit->resize(bytes_before));
      return kept_all;
    }
  }
  write_record(task.receiver.value, receiver.trees, edit->bytes(), receiver.groups);
  tell(*task.equilibrium, task.receiver, receiver, sent, rows ? &*rows : nullptr);

  report.working_set_elements = report.elements + most_source_elements;
  report.working_set_bytes =
      bytes + most_source_elements * sizeof(Element) + report.link_bytes + blocker_bytes;
  return report;
}

}  // namespace atrium
