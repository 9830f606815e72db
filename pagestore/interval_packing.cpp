// The packing as a flow: `capacity` bytes flow along the line from its first place to its last.
// What flows from a place to the next one is room left free; an interval is an arc past the places
// it covers, as wide as its bytes, that earns worth / bytes a byte. The dearest flow is found by
// the primal network simplex method. [Berger, Beckmann, Harchol-Balter, SIGMETRICS 2018; Ahuja,
// Magnanti, Orlin, Network Flows, 1993, §11]
//
// Invariants of Line:
//  1. The flow is one of `capacity` bytes; each arc carries between 0 and its width.
//  2. Tree arcs span the places, rooted at the last one; any other arc is empty or full.
//  3. Strongly feasible: from every place, bytes can be sent to the root along the tree. It is what
//     keeps degenerate pivots from going round in circles.
//  4. The cost of a tree arc is the price of its end less that of its start.
//
// It starts from a greedy packing, which is a basis at once, with the line itself as the tree, and
// within a few per cent of the best: most pivots of a start from nothing are saved.
#include "pagestore/interval_packing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/check.h"

namespace atrium {
namespace {

using Place = std::uint32_t;
using ArcNumber = std::uint32_t;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::int64_t kUnbounded = std::numeric_limits<std::int64_t>::max();
constexpr int kPriceBits = 61;  // of a price, leaving room to add and compare

// Free bytes over each place of the line: a tree of minima.
class Room {
 public:
  Room(std::size_t places, std::int64_t capacity)
      : leaves_(std::bit_ceil(places)), least_(2 * leaves_, capacity), added_(2 * leaves_, 0) {}

  // Takes `bytes` over [begin, end); false, and nothing taken, if there are too few somewhere.
  bool take(Place begin, Place end, std::int64_t bytes) {
    const Span all{1, 0, leaves_};
    if (least(all, begin, end) < bytes) return false;
    add(all, begin, end, -bytes);
    return true;
  }

 private:
  struct Span {
    std::size_t node, begin, end;
    bool within(Place from, Place to) const { return from <= begin && end <= to; }
    bool apart(Place from, Place to) const { return end <= from || to <= begin; }
    Span left() const { return {2 * node, begin, (begin + end) / 2}; }
    Span right() const { return {2 * node + 1, (begin + end) / 2, end}; }
  };

  std::int64_t least(const Span& span, Place from, Place to) const {
    if (span.apart(from, to)) return kUnbounded;
    if (span.within(from, to)) return least_[span.node];
    const std::int64_t below =
        std::min(least(span.left(), from, to), least(span.right(), from, to));
    return below == kUnbounded ? below : below + added_[span.node];
  }

  void add(const Span& span, Place from, Place to, std::int64_t bytes) {
    if (span.apart(from, to)) return;
    if (span.within(from, to)) {
      least_[span.node] += bytes;
      added_[span.node] += bytes;
      return;
    }
    add(span.left(), from, to, bytes);
    add(span.right(), from, to, bytes);
    least_[span.node] =
        added_[span.node] + std::min(least_[2 * span.node], least_[2 * span.node + 1]);
  }

  std::size_t leaves_;
  std::vector<std::int64_t> least_, added_;  // added_: to all below, beyond what their own say
};

enum class ArcState : std::int8_t { kFull = -1, kTree = 0, kEmpty = 1 };

struct Arc {
  Place from, to;
  std::int64_t cost;   // of a byte; -worth / bytes of the interval, in units of 1 / scale
  std::int64_t width;  // bytes
  std::int64_t flow;   // bytes
  ArcState state;

  std::int64_t room_towards(Place place) const {
    if (place == from) return flow;
    return width == kUnbounded ? kUnbounded : width - flow;
  }
  void push_towards(Place place, std::int64_t bytes) { flow += place == to ? bytes : -bytes; }
};

class Line {
 public:
  // intervals: over places below `places`, none wider than the capacity.
  Line(const std::vector<PackedInterval>& intervals, Place places, std::int64_t capacity);
  void solve();
  double kept() const;

 private:
  struct Node {
    Place parent, first_child, next, previous;  // kNone where there is none
    ArcNumber arc;                              // to the parent
    std::uint32_t size;                         // places in the subtree
    std::int64_t price;
  };
  // The cycle that an entering arc closes: flow goes from `join` down to `tail`, over the arc to
  // `head`, and up again.
  struct Cycle {
    Place tail, head, join;
    std::int64_t room;         // bytes that can go round
    Place cut = kNone;         // the place whose tree arc allows no more; kNone: the entering arc
    bool cut_at_tail = false;  // on which side of the cycle
  };

  void keep_greedily(std::int64_t capacity);
  std::int64_t reduced_cost(const Arc& arc) const {
    return arc.cost + nodes_[arc.from].price - nodes_[arc.to].price;
  }
  ArcNumber entering();
  void pivot(ArcNumber entering);
  Cycle close_cycle(const Arc& arc) const;
  Place common_ancestor(Place a, Place b) const;
  void send(const Cycle& cycle);
  void exchange(ArcNumber entering, const Cycle& cycle);
  void hang_subtree(Place top, Place cut, Place parent, ArcNumber arc);
  void shift_prices(Place top, std::int64_t by);
  void link(Place place, Place parent);
  void unlink(Place place);

  std::vector<Node> nodes_;
  std::vector<Arc> arcs_;  // those of the line first, then the intervals
  std::size_t block_;      // arcs looked at before the best of them enters
  ArcNumber next_ = 0;     // the arc to look at next
  std::int64_t scale_;
};

// Costs are whole multiples of 1 / scale: the finest unit in which prices, which are sums of at
// most one cost a place, do not overflow.
std::int64_t cost_scale(const std::vector<PackedInterval>& intervals, Place places) {
  std::uint64_t fewest = std::numeric_limits<std::uint64_t>::max();  // bytes a worth
  for (const PackedInterval& interval : intervals)
    fewest = std::min(fewest, interval.bytes / interval.worth);
  const int bits = kPriceBits - std::bit_width(places) + std::bit_width(fewest) - 1;
  return std::int64_t{1} << std::min(bits, kPriceBits);
}

Line::Line(const std::vector<PackedInterval>& intervals, Place places, std::int64_t capacity)
    : nodes_(places, {kNone, kNone, kNone, kNone, kNone, 0, 0}),
      scale_(cost_scale(intervals, places)) {
  arcs_.reserve(places + intervals.size());
  for (Place place = 0; place + 1 < places; ++place)
    arcs_.push_back({place, place + 1, 0, kUnbounded, capacity, ArcState::kTree});
  for (const PackedInterval& interval : intervals) {
    const auto width = static_cast<std::int64_t>(interval.bytes);
    const auto worth = static_cast<std::int64_t>(interval.worth);
    const std::int64_t earns =  // worth * scale / width, rounded up: the bound stays one
        scale_ / width * worth + (scale_ % width * worth + width - 1) / width;
    arcs_.push_back({interval.begin, interval.end, -earns, width, 0, ArcState::kEmpty});
  }
  block_ = static_cast<std::size_t>(std::sqrt(static_cast<double>(arcs_.size()))) + 1;
  for (Place place = places; place-- > 0;) {
    nodes_[place].size = place + 1;
    nodes_[place].arc = place;
    if (place + 1 < places) link(place, place + 1);
  }
  keep_greedily(capacity);
}

// Those that take the fewest places for what they earn a byte first, as long as there is room.
void Line::keep_greedily(std::int64_t capacity) {
  std::vector<ArcNumber> order(arcs_.size() - (nodes_.size() - 1));
  std::iota(order.begin(), order.end(), static_cast<ArcNumber>(nodes_.size() - 1));
  const auto taken = [this](ArcNumber number) {
    const Arc& arc = arcs_[number];
    return static_cast<double>(arc.to - arc.from) / static_cast<double>(-arc.cost);
  };
  std::sort(order.begin(), order.end(), [&](ArcNumber a, ArcNumber b) {
    return std::pair(taken(a), a) < std::pair(taken(b), b);
  });
  Room room(nodes_.size(), capacity);
  std::vector<std::int64_t> change(nodes_.size(), 0);  // of kept bytes, from a place to the next
  for (const ArcNumber number : order) {
    Arc& arc = arcs_[number];
    if (!room.take(arc.from, arc.to, arc.width)) continue;
    arc.flow = arc.width;
    arc.state = ArcState::kFull;
    change[arc.from] += arc.width;
    change[arc.to] -= arc.width;
  }
  std::int64_t kept = 0;
  for (Place place = 0; place + 1 < nodes_.size(); ++place) {
    kept += change[place];
    arcs_[place].flow -= kept;
  }
}

void Line::solve() {
  for (ArcNumber arc = entering(); arc != kNone; arc = entering()) pivot(arc);
}

double Line::kept() const {
  double sum = 0;
  for (const Arc& arc : arcs_)
    sum += static_cast<double>(arc.flow) * static_cast<double>(-arc.cost) /
           static_cast<double>(scale_);
  return sum;
}

// Block search: the arc of a block that earns the most a byte; kNone if no arc of all earns any.
ArcNumber Line::entering() {
  std::int64_t most = 0;
  ArcNumber best = kNone;
  for (std::size_t looked = 1; looked <= arcs_.size(); ++looked) {
    const Arc& arc = arcs_[next_];
    const std::int64_t earned = -static_cast<std::int64_t>(arc.state) * reduced_cost(arc);
    if (earned > most) {
      most = earned;
      best = next_;
    }
    if (++next_ == arcs_.size()) next_ = 0;
    if (best != kNone && looked % block_ == 0) break;
  }
  return best;
}

void Line::pivot(ArcNumber entering) {
  const Cycle cycle = close_cycle(arcs_[entering]);
  Arc& arc = arcs_[entering];
  arc.push_towards(cycle.head, cycle.room);
  send(cycle);
  if (cycle.cut != kNone) {
    exchange(entering, cycle);
  } else {
    arc.state = arc.state == ArcState::kFull ? ArcState::kEmpty : ArcState::kFull;
  }
}

// Of the arcs that allow no more, the last one round the cycle from its join is cut: it keeps the
// tree strongly feasible.
Line::Cycle Line::close_cycle(const Arc& arc) const {
  const bool forward = arc.state == ArcState::kEmpty;
  const Place tail = forward ? arc.from : arc.to, head = forward ? arc.to : arc.from;
  Cycle cycle{tail, head, common_ancestor(tail, head), arc.width};
  for (Place place = tail; place != cycle.join; place = nodes_[place].parent) {
    const std::int64_t room = arcs_[nodes_[place].arc].room_towards(place);
    if (room >= cycle.room) continue;
    cycle.room = room;
    cycle.cut = place;
    cycle.cut_at_tail = true;
  }
  for (Place place = head; place != cycle.join; place = nodes_[place].parent) {
    const std::int64_t room = arcs_[nodes_[place].arc].room_towards(nodes_[place].parent);
    if (room > cycle.room) continue;
    cycle.room = room;
    cycle.cut = place;
    cycle.cut_at_tail = false;
  }
  return cycle;
}

Place Line::common_ancestor(Place a, Place b) const {
  while (a != b) {
    const bool raise_a = nodes_[a].size <= nodes_[b].size;
    const bool raise_b = nodes_[b].size <= nodes_[a].size;
    if (raise_a) a = nodes_[a].parent;
    if (raise_b) b = nodes_[b].parent;
  }
  return a;
}

void Line::send(const Cycle& cycle) {
  if (cycle.room == 0) return;
  for (Place place = cycle.tail; place != cycle.join; place = nodes_[place].parent)
    arcs_[nodes_[place].arc].push_towards(place, cycle.room);
  for (Place place = cycle.head; place != cycle.join; place = nodes_[place].parent)
    arcs_[nodes_[place].arc].push_towards(nodes_[place].parent, cycle.room);
}

// The cut arc leaves the tree; the subtree it held hangs by the entering arc from now on.
void Line::exchange(ArcNumber entering, const Cycle& cycle) {
  Arc& leaving = arcs_[nodes_[cycle.cut].arc];
  leaving.state = leaving.flow == 0 ? ArcState::kEmpty : ArcState::kFull;
  const Place top = cycle.cut_at_tail ? cycle.tail : cycle.head;
  const Place parent = cycle.cut_at_tail ? cycle.head : cycle.tail;
  const std::uint32_t moved = nodes_[cycle.cut].size;
  for (Place place = nodes_[cycle.cut].parent; place != cycle.join; place = nodes_[place].parent)
    nodes_[place].size -= moved;
  for (Place place = parent; place != cycle.join; place = nodes_[place].parent)
    nodes_[place].size += moved;
  Arc& arc = arcs_[entering];
  const std::int64_t reduced = reduced_cost(arc);
  arc.state = ArcState::kTree;
  hang_subtree(top, cycle.cut, parent, entering);
  shift_prices(top, top == arc.to ? reduced : -reduced);
}

// Turns the subtree under `cut` over, so that `top` is its root, and hangs it under `parent`.
void Line::hang_subtree(Place top, Place cut, Place parent, ArcNumber arc) {
  const std::uint32_t whole = nodes_[cut].size;
  std::uint32_t turned = 0;  // places in the subtree of `place` that stays behind when it turns
  for (Place place = top;;) {
    const Node old = nodes_[place];
    unlink(place);
    link(place, parent);
    nodes_[place].arc = arc;
    nodes_[place].size = whole - turned;
    if (place == cut) return;
    turned = old.size;
    parent = place;
    place = old.parent;
    arc = old.arc;
  }
}

void Line::shift_prices(Place top, std::int64_t by) {
  for (Place place = top;;) {
    nodes_[place].price += by;
    if (nodes_[place].first_child != kNone) {
      place = nodes_[place].first_child;
      continue;
    }
    while (place != top && nodes_[place].next == kNone) place = nodes_[place].parent;
    if (place == top) return;
    place = nodes_[place].next;
  }
}

void Line::link(Place place, Place parent) {
  Node& node = nodes_[place];
  node.parent = parent;
  node.previous = kNone;
  node.next = nodes_[parent].first_child;
  if (node.next != kNone) nodes_[node.next].previous = place;
  nodes_[parent].first_child = place;
}

void Line::unlink(Place place) {
  const Node& node = nodes_[place];
  if (node.next != kNone) nodes_[node.next].previous = node.previous;
  if (node.previous != kNone) {
    nodes_[node.previous].next = node.next;
  } else {
    nodes_[node.parent].first_child = node.next;
  }
}

// Numbers the places anew, so that only those are left where the intervals over a place may take
// more room than over its neighbours: where, after some have begun, one ends. Returns their count,
// with the one after the last.
Place contract(std::vector<PackedInterval>& intervals) {
  Place places = 0;
  for (const PackedInterval& interval : intervals) places = std::max(places, interval.end + 1);
  std::vector<bool> begins(places), ends(places);
  for (const PackedInterval& interval : intervals) {
    begins[interval.begin] = true;
    ends[interval.end] = true;
  }
  std::vector<Place> renumbered(places);
  Place number = 0;
  bool begun = false;
  for (Place place = 0; place < places; ++place) {
    if (ends[place] && begun) {
      ++number;
      begun = false;
    }
    begun = begun || begins[place];
    renumbered[place] = number;
  }
  for (PackedInterval& interval : intervals) {
    interval.begin = renumbered[interval.begin];
    interval.end = renumbered[interval.end];
  }
  return number + 1;
}

}  // namespace

double largest_packing(const std::vector<PackedInterval>& intervals, std::uint64_t capacity) {
  std::vector<PackedInterval> packed;
  std::uint64_t bytes = 0;
  double free_of_charge = 0;
  for (const PackedInterval& interval : intervals) {
    ATRIUM_CHECK(interval.begin < interval.end);
    if (interval.worth == 0) continue;
    if (interval.bytes == 0) {
      free_of_charge += static_cast<double>(interval.worth);
    } else if (interval.bytes <= capacity) {
      ATRIUM_CHECK(interval.worth <= interval.bytes);
      packed.push_back(interval);
      bytes += interval.bytes;
    }
  }
  if (packed.empty()) return free_of_charge;
  const Place places = contract(packed);
  Line line(packed, places, static_cast<std::int64_t>(std::min(capacity, bytes)));
  line.solve();
  return free_of_charge + line.kept();
}

}  // namespace atrium
