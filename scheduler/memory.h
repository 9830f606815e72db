// Memory: what the parts of a solve that are no records take, counted and never asked of the
// system, and the habits of the heap they lie in. --memory is the sum of all parts: scene and
// model, arena and directory, ray worlds, coarse system, what a gather works with;
// links have the rest of it, and what they do not find room for streams from disk. What is of one
// size for every scene is no part of it: code, libraries, a batch of rays of an estimate.
#pragma once

#include <cstddef>

#include "engine/model.h"
#include "engine/scene.h"

namespace atrium {

std::size_t bytes_of(const Scene& scene);
std::size_t bytes_of(const Model& model);

// What is freed goes back to the system: the resident set is what is held, not the most that ever
// was. Once, before anything large is allocated.
void keep_heap_small();
// What is free but lies between what is not: after import, and between sweeps.
void give_back_free_memory();

}  // namespace atrium
