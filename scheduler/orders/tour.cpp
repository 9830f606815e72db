// Tour order: as near to the least bytes read as a second of search comes. Finding the least is
// "computationally equivalent to finding a solution to the traveling salesman problem" [THFH94 §6],
// but for one thing: an arena holds more than the last gather's set, and an order that is best from
// each gather to the next is not the one that reads least. On gen floor 2-opt and Or-opt from cell
// order took half off the bytes in which neighbours differ, and a twenty-fifth off those that an
// arena of a third reads. So what is made less here is likely_bytes, over all of an iteration and
// into the next one: a third is off those that are read.
//
// It starts from the best of the constructed orders. A move takes a run of gathers out and puts it
// in elsewhere, beside one of those whose sets are nearest to its ends (Or-opt [Or 1976], with runs
// of up to kLongest). What a move brings is summed over the records that the run reads, and for all
// others over the places that it leaves and goes to, where those that are waited for lie a little
// closer or farther apart; that sum is brought up to date now and then, so a move's gain is nearly
// exact. What counts is likely_bytes itself, of the whole: the best sequence seen is kept, and the
// search ends where a round of moves does not make it less, or after kMostLooks.
#include <algorithm>
#include <array>
#include <utility>

#include "engine/check.h"
#include "scheduler/orders/cells.h"
#include "scheduler/orders/constructed.h"

namespace atrium {

namespace {

using Place = std::int32_t;  // in the sequence; beyond its ends, in the iterations before and after

constexpr Place kLongest = 32;
constexpr std::array<Place, 6> kLengths{1, kLongest, 16, 8, 4, 2};  // of the runs, in this order
constexpr std::size_t kNearest = 6;  // gathers beside each end of a run that it may be put next to
constexpr std::uint64_t kMostLooks = 40'000'000;  // at a record of a run in a place: about 1 s
constexpr Place kFresh = 32;  // waiting_ is summed anew after moves for a 32nd of the gathers

class Tour {
 public:
  Tour(const GatherSets& gathers, Sequence start);
  Sequence refine() &&;

 private:
  // A record that the run reads.
  struct Touched {
    std::uint32_t record;
    Place first, last;         // gathers of the run that read it
    std::uint32_t begin, end;  // of its readers: those in the run
    bool by_run_alone = false;  // it moves along, whole
  };
  struct Run {
    Place first, length;
  };
  struct Move {
    Place to = -1;  // before the gather that is there now
    double gain = 0;
  };

  Place size() const { return static_cast<Place>(sequence_.size()); }
  std::span<std::uint32_t> readers(std::uint32_t record) {
    return std::span(readers_.items)
        .subspan(readers_.starts[record],
                 readers_.starts[record + 1] - readers_.starts[record]);
  }
  double cost(std::uint32_t record, Place gap) const {
    return gathers_.bytes[record] * std::min(gap, reach_);
  }
  std::uint32_t first_reader_from(std::span<const std::uint32_t> readers, Place place) const;

  void find_nearest();
  void find_readers();
  void find_waiting();
  bool improve(Place length);
  void touch(const Run& run);
  double gain_of_taking_out(const Run& run);
  double cost_of_putting_in(const Run& run, Place to, double limit);
  Move best_move(const Run& run);
  void make(const Run& run, Place to);

  const GatherSets& gathers_;
  const Place reach_;
  Sequence sequence_;
  std::vector<Place> place_;                                  // by cluster
  std::vector<std::array<std::uint32_t, kNearest>> nearest_;  // by cluster; itself where none is
  Rows<std::uint32_t> readers_;                               // by record: clusters, by their place
  // By place: bytes of the records that the gather before it or an earlier one has read and it or a
  // later one will, if both are within reach.
  std::vector<double> waiting_;
  Place stale_ = 0;  // moves since waiting_ was summed up
  std::uint64_t looks_ = 0;
  // Of the run at hand.
  std::vector<Touched> touched_;
  std::vector<std::uint32_t> touched_at_;  // by record: its number in touched_, if it is there
  std::vector<Place> places_;
};

Tour::Tour(const GatherSets& gathers, Sequence start)
    : gathers_(gathers),
      reach_(static_cast<Place>(arena_reach(start.size()))),
      sequence_(std::move(start)),
      place_(gathers.size()),
      touched_at_(gathers.size(), 0) {
  for (Place p = 0; p < size(); ++p) place_[sequence_[std::size_t(p)].value] = p;
  find_nearest();
  find_readers();
  find_waiting();
}

void Tour::find_nearest() {
  std::vector<GatherSets::Neighbor> row;
  for (std::uint32_t c = 0; c < gathers_.size(); ++c) {
    row.assign(gathers_.neighbors[c].begin(), gathers_.neighbors[c].end());
    const std::size_t count = std::min(kNearest, row.size());
    std::partial_sort(row.begin(), row.begin() + std::ptrdiff_t(count), row.end(),
                      [](const auto& a, const auto& b) {
                        return std::pair(a.distance, a.cluster) < std::pair(b.distance, b.cluster);
                      });
    nearest_.emplace_back().fill(c);
    for (std::size_t i = 0; i < count; ++i) nearest_.back()[i] = row[i].cluster;
  }
}

// Sets are symmetric: a cluster reads those that read it.
void Tour::find_readers() {
  readers_ = gathers_.sets;
  for (std::uint32_t r = 0; r < gathers_.size(); ++r)
    std::ranges::sort(readers(r), {}, [&](std::uint32_t c) { return place_[c]; });
}

void Tour::find_waiting() {
  std::vector<double> change(sequence_.size() + 1, 0);
  const auto wait = [&](Place after, Place until, double bytes) {
    change[std::size_t(after + 1)] += bytes;
    if (until < size()) change[std::size_t(until + 1)] -= bytes;
  };
  for (std::uint32_t r = 0; r < gathers_.size(); ++r) {
    const auto row = readers(r);
    for (std::size_t i = 0; i + 1 < row.size(); ++i)
      if (place_[row[i + 1]] - place_[row[i]] < reach_)
        wait(place_[row[i]], place_[row[i + 1]], gathers_.bytes[r]);
    const Place last = place_[row.back()], first = place_[row.front()];
    if (first + size() - last >= reach_) continue;
    wait(last, size(), gathers_.bytes[r]);
    wait(-1, first, gathers_.bytes[r]);
  }
  waiting_.assign(change.size(), 0);
  double sum = 0;
  for (std::size_t p = 0; p < change.size(); ++p) waiting_[p] = sum += change[p];
  stale_ = 0;
}

std::uint32_t Tour::first_reader_from(std::span<const std::uint32_t> row, Place place) const {
  const auto found = std::ranges::lower_bound(row, place, {},
                                              [&](std::uint32_t c) { return place_[c]; });
  return static_cast<std::uint32_t>(found - row.begin());
}

void Tour::touch(const Run& run) {
  touched_.clear();
  for (Place p = run.first; p < run.first + run.length; ++p)
    for (const std::uint32_t r : gathers_.sets[sequence_[std::size_t(p)].value]) {
      const std::uint32_t at = touched_at_[r];
      if (at < touched_.size() && touched_[at].record == r) {
        touched_[at].last = p;
        ++touched_[at].end;
        continue;
      }
      touched_at_[r] = static_cast<std::uint32_t>(touched_.size());
      const std::uint32_t begin = first_reader_from(readers(r), run.first);
      touched_.push_back({r, p, p, begin, begin + 1});
    }
  for (Touched& t : touched_) t.by_run_alone = t.end - t.begin == readers(t.record).size();
  looks_ += touched_.size();
}

double Tour::gain_of_taking_out(const Run& run) {
  double gain = 0, waiting = waiting_[std::size_t(run.first)];
  for (const Touched& t : touched_) {
    if (t.by_run_alone) continue;
    const auto row = readers(t.record);
    const Place before = t.begin > 0 ? place_[row[t.begin - 1]] : place_[row.back()] - size();
    const Place after = t.end < row.size() ? place_[row[t.end]] : place_[row.front()] + size();
    gain += cost(t.record, t.first - before) + cost(t.record, after - t.last) -
            cost(t.record, after - before - run.length);
    if (t.first - before < reach_) waiting -= gathers_.bytes[t.record];
  }
  return gain + run.length * waiting;
}

// Beyond `limit` it may be more than what is returned.
double Tour::cost_of_putting_in(const Run& run, Place to, double limit) {
  const Place rest = size() - run.length;  // gathers without the run
  const Place gap_at = to <= run.first ? to : to - run.length;
  const auto without = [&](std::uint32_t c) {
    return place_[c] < run.first ? place_[c] : place_[c] - run.length;
  };
  double sum = 0, waiting = waiting_[std::size_t(to)];
  for (const Touched& t : touched_) {
    if (t.by_run_alone) continue;
    ++looks_;
    const auto row = readers(t.record);
    const std::uint32_t next = first_reader_from(row, to);
    // The run's own readers are not there.
    const std::uint32_t end = next > t.begin && next <= t.end ? t.begin : next;
    const std::uint32_t begin = next >= t.begin && next < t.end ? t.end : next;
    const std::uint32_t last = t.end == row.size() ? row[t.begin - 1] : row.back();
    const std::uint32_t first = t.begin == 0 ? row[t.end] : row.front();
    const Place before = end > 0 ? without(row[end - 1]) : without(last) - rest;
    const Place after = begin < row.size() ? without(row[begin]) : without(first) + rest;
    sum += cost(t.record, gap_at + (t.first - run.first) - before) +
           cost(t.record, after + run.length - gap_at - (t.last - run.first)) -
           cost(t.record, after - before);
    if (sum > limit) return sum;
    const Place now_before = next > 0 ? place_[row[next - 1]] : place_[row.back()] - size();
    const Place now_after = next < row.size() ? place_[row[next]] : place_[row.front()] + size();
    if (now_after - now_before < reach_) waiting -= gathers_.bytes[t.record];
  }
  return sum + run.length * waiting;
}

Tour::Move Tour::best_move(const Run& run) {
  places_.clear();
  for (const Place end : {run.first, run.first + run.length - 1})
    for (const std::uint32_t c : nearest_[sequence_[std::size_t(end)].value])
      for (const Place to : {place_[c], place_[c] + 1})
        if (to < run.first || to > run.first + run.length) places_.push_back(to);
  std::ranges::sort(places_);
  places_.erase(std::unique(places_.begin(), places_.end()), places_.end());
  Move best;
  if (places_.empty()) return best;
  touch(run);
  const double gain = gain_of_taking_out(run);
  for (const Place to : places_) {
    const double limit = gain - best.gain;
    const double paid = limit > 0 ? cost_of_putting_in(run, to, limit) : limit;
    if (paid < limit) best = {to, gain - paid};
  }
  return best;
}

void Tour::make(const Run& run, Place to) {
  for (const Touched& t : touched_) {
    const auto row = readers(t.record);
    const std::uint32_t next = first_reader_from(row, to);
    const auto at = [&](std::uint32_t i) { return row.begin() + i; };
    if (next < t.begin) std::rotate(at(next), at(t.begin), at(t.end));
    if (next > t.end) std::rotate(at(t.begin), at(t.end), at(next));
  }
  const Place end = run.first + run.length;
  const auto at = [&](Place p) { return sequence_.begin() + p; };
  if (to < run.first) std::rotate(at(to), at(run.first), at(end));
  if (to > end) std::rotate(at(run.first), at(end), at(to));
  for (Place p = std::min(to, run.first); p < std::max(to, end); ++p)
    place_[sequence_[std::size_t(p)].value] = p;
  if (++stale_ > size() / kFresh) find_waiting();
}

// Every run of this length, half of it apart. False when enough was looked at.
bool Tour::improve(Place length) {
  for (Run run{0, length}; run.first + length <= size(); run.first += std::max(1, length / 2)) {
    if (looks_ >= kMostLooks) return false;
    const Move move = best_move(run);
    if (move.to >= 0) make(run, move.to);
  }
  return true;
}

Sequence Tour::refine() && {
  Sequence best = sequence_;
  double least = likely_bytes(gathers_, best);
  for (bool better = true, more = true; better && more;) {
    better = false;
    for (const Place length : kLengths) {
      more = more && improve(length);
      const double bytes = likely_bytes(gathers_, sequence_);
      if (bytes >= least) continue;
      better = true;
      least = bytes;
      best = sequence_;
    }
  }
  return best;
}

}  // namespace

Sequence tour_order(const OrderTask& task) {
  const GatherSets gathers = find_gather_sets(task.model);
  const CellWalk walk = walk_cells(task.model);
  std::vector<Sequence> starts{cell_by_cell(task.model, gathers, walk.entered),
                               cell_by_cell(task.model, gathers, walk.left),
                               by_nearest(gathers), by_tree(gathers), hilbert_order(task)};
  const auto best = std::ranges::min_element(
      starts, {}, [&](const Sequence& s) { return likely_bytes(gathers, s); });
  return Tour(gathers, std::move(*best)).refine();
}

}  // namespace atrium
