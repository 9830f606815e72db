#include "visibility/segment_words.h"

#include <iomanip>
#include <sstream>

namespace atrium {

namespace {

constexpr int kDigits = 17;  // as many as bring the same double back

std::string end_words(const Scene& scene, const Model& model, PatchId patch, const Vec3& x) {
  const ClusterId cluster = model.patches[patch.value].cluster;
  return "'" + scene.objects[model.clusters[cluster.value].object.value].name + "' (cluster " +
         std::to_string(cluster.value) + ") at " + place_words(scene, x) + " ";
}

}  // namespace

std::string place_words(const Scene& scene, const Vec3& x) {
  const Vec3 place = scene.frame.to_file(x);
  std::ostringstream out;
  out << std::setprecision(kDigits) << '(' << place.x << ' ' << place.y << ' ' << place.z << ')';
  return out.str();
}

std::string segment_words(const Scene& scene, const Model& model, PatchId p, const Vec3& x,
                          PatchId q, const Vec3& y) {
  return "from " + end_words(scene, model, p, x) + "to " + end_words(scene, model, q, y);
}

}  // namespace atrium
