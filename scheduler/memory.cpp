#include "scheduler/memory.h"

#include <malloc.h>

namespace atrium {

namespace {

template <class T>
std::size_t bytes_in(const std::vector<T>& items) {
  return items.capacity() * sizeof(T);
}

template <class T>
std::size_t bytes_in(const Rows<T>& rows) {
  return bytes_in(rows.starts) + bytes_in(rows.items);
}

}  // namespace

std::size_t bytes_of(const Scene& scene) {
  std::size_t names = 0;
  for (const Object& o : scene.objects) names += o.name.capacity();
  for (const Material& m : scene.materials) names += m.name.capacity();
  return names + bytes_in(scene.materials) + bytes_in(scene.objects) + bytes_in(scene.surfaces) +
         bytes_in(scene.vertices) + bytes_in(scene.faces_of_material);
}

std::size_t bytes_of(const Model& model) {
  return bytes_in(model.vertices) + bytes_in(model.patches) + bytes_in(model.clusters) +
         bytes_in(model.contacts) + bytes_in(model.cells) + bytes_in(model.portals) +
         bytes_in(model.portal_vertices) + bytes_in(model.cells_of_cluster) +
         bytes_in(model.visible);
}

// The GNU C library's heap otherwise has one part a thread, each as large as that thread's largest
// gather, and learns from the first large block that is freed to keep all that are smaller.
void keep_heap_small() {
#ifdef __GLIBC__
  constexpr int kHeaps = 2, kOwnPages = 256 << 10, kKeptOnTop = 1 << 20;
  mallopt(M_ARENA_MAX, kHeaps);
  mallopt(M_MMAP_THRESHOLD, kOwnPages);
  mallopt(M_TRIM_THRESHOLD, kKeptOnTop);
#endif
}

void give_back_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace atrium
