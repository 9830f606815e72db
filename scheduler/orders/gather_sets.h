// Gather sets: what each complete gather reads, its receiver and all that this may see, and how far
// such sets are from one another in bytes: what orders go by that mean to read little.
//
// A record's bytes are not known before the solve. It begins with about so much a patch, and grows
// with the area that elements have to cover: on gen floor at 10% records end at .86 of correlation
// with their area alone, .21 with their first bytes, .89 with both taken as here. How much they
// grow in all goes with the error asked for, and hardly matters to an order.
//
// Distances are known of pairs that may see each other, no others: the visible lists are sparse.
// Where they are long they are compared by a sample of the records, drawn by a hash of their
// numbers. Pure functions, plain data.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scheduler/orders/orders.h"

namespace atrium {

struct GatherSets {
  std::vector<double> bytes;  // by record, which goes by its cluster's number; guessed
  Rows<std::uint32_t> sets;   // by receiver: records, ascending

  // Of the sets, what they are compared by.
  Rows<std::uint32_t> compared;
  double share = 1;  // of all records

  struct Neighbor {
    std::uint32_t cluster = 0;
    float distance = 0;  // bytes that one of the two sets holds and the other one does not
  };
  Rows<Neighbor> neighbors;  // by cluster: those it may see, ascending

  std::size_t size() const { return bytes.size(); }
};

GatherSets find_gather_sets(const Model& model, bool with_neighbors = true);

// Between any two sets: the bytes that one of them holds and the other one does not.
double distance(const GatherSets& gathers, std::uint32_t a, std::uint32_t b);

// The bytes that the iterations of an order are likely to read, each after the first. A record that
// is asked for again after g gathers has left the arena with a chance of g ÷ (a third of all
// gathers), or 1: what an arena of a third of the data would keep if every gather brought in as
// much as any other.
double likely_bytes(const GatherSets& gathers, std::span<const ClusterId> order);
std::uint32_t arena_reach(std::size_t gathers);  // that third

}  // namespace atrium
