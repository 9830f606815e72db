#include <cstdio>

#include "apps/export/formats.h"
#include "apps/output.h"

namespace atrium {
namespace {

void append(std::string& row, double value) {
  char text[32];
  std::snprintf(text, sizeof text, ",%.17g", value);
  row += text;
}

void append(std::string& row, const Vec3& v) {
  for (int k = 0; k < 3; ++k) append(row, v[k]);
}

// Coefficient 0 is the mean: the basis is orthonormal and its first function is 1.
Spectrum mean_irradiance(const PatchView& patch, std::size_t element) {
  const std::span<const double> e = patch.e_of(element);
  return glm::max(Spectrum(e[0], e[1], e[2]), Spectrum(0));
}

std::uint64_t append_patch(std::string& rows, ClusterId cluster, const PatchView& patch,
                           const SceneFrame& frame) {
  std::uint64_t leaves = 0;
  for (std::size_t i = 0; i < patch.elements.size(); ++i) {
    const Element& element = patch.elements[i];
    if (!element.leaf()) continue;
    ++leaves;
    const Spectrum e = mean_irradiance(patch, i);
    rows += std::to_string(cluster.value) + "," + std::to_string(patch.head->patch);
    append(rows, frame.to_file(patch.point(element.centroid)));
    append(rows, patch.head->frame.n);
    append(rows, element.area);
    append(rows, e);
    append(rows, patch.head->exitance + patch.head->reflectance * e);
    rows += "\n";
  }
  return leaves;
}

}  // namespace

Result<Exported> write_csv(Solution& solution, const std::string& path) {
  std::string rows = "cluster,patch,x,y,z,nx,ny,nz,area,Er,Eg,Eb,Br,Bg,Bb\n";
  Exported exported;
  ATRIUM_RETURN_IF_ERROR(solution.for_each_cluster([&](ClusterId id, const ClusterView& cluster) {
    for (std::size_t p = 0; p < cluster.size(); ++p)
      exported.faces += append_patch(rows, id, cluster.patch(p), solution.run().frame);
  }));
  ATRIUM_RETURN_IF_ERROR(write_output(path, {rows}));
  exported.bytes = rows.size();
  return exported;
}

}  // namespace atrium
