#include "scheduler/coarse_rows.h"

#include <algorithm>
#include <cmath>

namespace atrium {

namespace {

// Half of a building's entries are below this and hold a quarter percent of their rows. What they
// bring is brought by the others, so that a row still sums to what it did.
constexpr double kWeak = 1e-4;

void leave_out_weak(std::vector<CoarseEntry>& row) {
  const auto is_weak = [](const CoarseEntry& e) { return std::abs(e.form_factor) < kWeak; };
  Spectrum all{0}, strong{0};
  double all_factors = 0, strong_factors = 0;
  for (const CoarseEntry& e : row) {
    all += share_of(e);
    all_factors += e.form_factor;
    if (!is_weak(e)) strong += share_of(e), strong_factors += e.form_factor;
  }
  if (!(strong_factors > 0.5 * all_factors)) return;  // all of it is weak
  std::erase_if(row, is_weak);
  for (CoarseEntry& e : row) {
    for (int c = 0; c < kChannels; ++c) {
      float& share = e.share[std::size_t(c)];
      if (strong[c] > 0) share = float(share * (all[c] / strong[c]));
    }
    e.form_factor = float(e.form_factor * (all_factors / strong_factors));
  }
  row.shrink_to_fit();
}

}  // namespace

CoarseRows::CoarseRows(const CoarseUnits& units, ClusterId receiver)
    : units_(units),
      receiver_(receiver),
      rows_(units.slots(receiver)),
      begun_(rows_.size(), false) {}

void CoarseRows::Entry::add(double by, const Entry& e) {
  share += by * e.share;
  doubt += by * e.doubt;
  factors += by * e.factors;
  doubts += by * e.doubts;
}

// A line by slots of the source, as entries by its units: what comes from elements larger than a
// part does so from all parts that they hold, by area.
void CoarseRows::hand_to_units(std::span<Entry> line, ClusterId source, Row& row) const {
  for (std::uint32_t u = units_.first(source); u < units_.end(source);) {
    const std::size_t parts = units_.parts(u);
    Entry* const places = line.data() + units_.slot(u, 1) - 1;  // from 1 on
    if (parts > 1) {
      const std::vector<double> areas = units_.place_areas(u);
      for (std::size_t q = 1; q < parts; ++q)
        for (const std::size_t half : {2 * q, 2 * q + 1})
          if (!places[q].none()) places[half].add(areas[half] / areas[q], places[q]);
    }
    for (std::size_t i = 0; i < parts; ++i, ++u) {
      places[parts + i].unit = u;
      if (!places[parts + i].none()) row.entries.push_back(places[parts + i]);
    }
  }
}

void CoarseRows::add(const Braid& braid, const ClusterView& source,
                     std::span<const PatchTree> receiver, const GroupView& groups) {
  if (!braid.carries_light()) return;
  const std::span<const std::uint32_t> to = units_.of(receiver_);
  const std::span<const std::uint32_t> from = units_.of(braid.source);
  const std::size_t width = units_.slots(braid.source);
  block_.resize(std::max(block_.size(), rows_.size() * width));
  const auto line_of = [&](std::size_t row) {
    const std::span<Entry> line = std::span(block_).subspan(row * width, width);
    if (!begun_[row]) std::ranges::fill(line, Entry{});
    begun_[row] = true;
    return line;
  };
  // A group is of the unit that its patches are of.
  const auto row_of = [&](const Braid::Strand& s, std::uint32_t element) {
    if (s.patch < to.size())
      return units_.slot(to[s.patch], receiver[s.patch].elements[element].place);
    return units_.slot(to[groups.any_patch(groups.groups[s.patch - to.size()])], 1);
  };
  const auto column_of = [&](std::uint32_t source_patch, std::uint32_t element) {
    const GroupView of = source.groups();
    if (source_patch >= from.size())
      return units_.slot(from[of.any_patch(of.groups[source_patch - from.size()])], 1);
    const std::uint32_t unit = from[source_patch];
    if (!units_.divided(unit)) return units_.slot(unit, 1);
    return units_.slot(unit, source.patch(source_patch).elements[element].place);
  };
  const auto area_of = [&](const Braid::Strand& s, const Ends& ends) {
    return s.patch < to.size() ? receiver[s.patch].elements[ends.receiver].area
                               : groups.groups[s.patch - to.size()].area;
  };
  const auto reflectance_of = [&](std::uint32_t source_patch) -> const Spectrum& {
    return source_patch < from.size()
               ? source.patch_head(source_patch).reflectance
               : source.groups().groups[source_patch - from.size()].reflectance;
  };
  const auto put = [&](const Braid::Strand& s, const Ends& ends, double coupling, double doubt) {
    const double area = area_of(s, ends), f = coupling * area, d = doubt * area;
    const std::size_t row = row_of(s, ends.receiver);
    const Spectrum& reflectance = reflectance_of(ends.source_patch);
    line_of(row)[column_of(ends.source_patch, ends.source)].add(
        1, {.share = f * reflectance, .doubt = d * reflectance, .factors = f, .doubts = d});
    rows_[row].linked += f;
    rows_[row].doubt += d;
  };
  const int order = receiver.front().order;
  const std::size_t k2 = std::size_t(coefficient_count(order)) * coefficient_count(order);
  for (const Braid::Strand& s : braid.strands) {
    for (std::size_t i = s.first_link; i < s.first_link + s.links; ++i)
      put(s, braid.links[i].ends, braid.couplings[i * k2], braid.links[i].doubt);
    for (const ThinLink& t : std::span(braid.thin).subspan(s.first_thin, s.thin))
      put(s, t.ends, t.coupling, t.doubt());
    for (const Doubt& d : std::span(braid.doubts).subspan(s.first_doubt, s.doubts))
      put(s, d.ends, 0, d.doubt);
  }
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (begun_[r]) hand_to_units(line_of(r), braid.source, rows_[r]);
    begun_[r] = false;
  }
}

void CoarseRows::close(std::size_t patch, const PatchTree& tree, const Closing& closing) {
  Row& row = rows_[units_.slot(units_.of(receiver_)[patch], 1)];
  row.closing = closing;
  if (too_much(closing))
    row.too_much -= closing.missing * tree.head.area;
  else if (closing.how != Closing::How::kOpen)
    row.missing += closing.missing * tree.head.area;
}

// As its leaves are closed (solver/push_pull.h).
void CoarseRows::close_part(const Closing& closing, double area, Row& row) {
  const double less = area - row.linked;
  switch (closing.how) {
    case Closing::How::kOpen: break;
    case Closing::How::kEachLeaf: row.missing = less; break;
    case Closing::How::kWholePatch: row.missing = closing.missing * area; break;
    case Closing::How::kNoMoreNorLess: row.missing = std::max(0.0, less); [[fallthrough]];
    case Closing::How::kNoMore: row.too_much = std::max(0.0, row.linked - closing.whole * area);
  }
}

// What is linked to it, and its share by area of what is linked to larger elements.
CoarseRows::Row CoarseRows::row_of_part(std::uint32_t unit) const {
  const std::uint32_t first = units_.first_part(unit);
  const Row* const places = rows_.data() + units_.slot(first, 1) - 1;  // from 1 on
  const std::vector<double> areas = units_.place_areas(first);
  const double area = units_.areas()[unit];
  Row row;
  std::vector<Entry>& all = row.entries;
  for (std::size_t q = units_.parts(unit) + unit - first; q > 0; q /= 2) {
    const double share = area / areas[q];
    row.doubt += share * places[q].doubt;
    row.linked += share * places[q].linked;
    const auto before = std::ptrdiff_t(all.size());
    for (const Entry& e : places[q].entries) {
      all.push_back({e.unit});
      all.back().add(share, e);
    }
    std::ranges::inplace_merge(all, all.begin() + before, {}, &Entry::unit);
  }
  std::size_t kept = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (all[i].unit == all[kept].unit)
      all[kept].add(1, all[i]);
    else
      all[++kept] = all[i];
  }
  if (!all.empty()) all.resize(kept + 1);
  close_part(places[1].closing, area, row);
  return row;
}

std::vector<CoarseEntry> CoarseRows::row(std::uint32_t unit) const {
  Row part;
  if (units_.divided(unit)) part = row_of_part(unit);
  const Row& sums = units_.divided(unit) ? part : rows_[units_.slot(unit, 1)];
  const double area = units_.areas()[unit];
  const double kept = sums.linked > 0 ? 1 - sums.too_much / sums.linked : 1;
  const double made_up = sums.doubt > 0 ? sums.missing / sums.doubt : 0;
  std::vector<CoarseEntry> row;
  row.reserve(sums.entries.size());
  for (const Entry& e : sums.entries) {
    const Spectrum share = (kept * e.share + made_up * e.doubt) / area;
    const double factor = (kept * e.factors + made_up * e.doubts) / area;
    row.push_back({e.unit, {float(share[0]), float(share[1]), float(share[2])}, float(factor)});
  }
  leave_out_weak(row);
  return row;
}

}  // namespace atrium
