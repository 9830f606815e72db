// atrium inspect SCENE|RUN: what is in it. A directory is a run, anything else a scene's file.
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "apps/command.h"
#include "apps/output.h"
#include "apps/report_json.h"
#include "engine/import/inspect.h"
#include "scheduler/solution.h"

namespace atrium {
namespace {

constexpr std::size_t kMostFiles = 4096;  // of one scene

struct Inspect {
  std::vector<std::string> words;
  ImportOptions scene;
  std::string visible, cells, portals;
};

void print_materials(const std::vector<MaterialReport>& materials) {
  constexpr int kName = 28, kColumn = 12;
  std::cout << '\n'
            << std::left << std::setw(kName) << "material" << std::right << std::setw(kColumn)
            << "faces" << std::setw(kColumn) << "area m2" << std::setw(kColumn) << "lumens"
            << "  reflectance\n";
  for (const MaterialReport& m : materials)
    std::cout << std::left << std::setw(kName) << m.name << std::right << std::setw(kColumn)
              << m.faces << std::setw(kColumn) << m.area << std::setw(kColumn) << m.lumens << "  "
              << m.reflectance.x << ' ' << m.reflectance.y << ' ' << m.reflectance.z << '\n';
}

void print_scene(const SceneReport& r) {
  std::cout << std::setprecision(5);
  for (const std::string& f : r.files) std::cout << f << '\n';
  const Vec3 extent = r.bounds.empty() ? Vec3(0) : r.bounds.extent();
  std::cout << "polygons    " << r.polygons << "\npatches     " << r.patches << "\nclusters    "
            << r.clusters << "\nlights      " << r.lights << "\nextent      " << extent.x << " x "
            << extent.y << " x " << extent.z << " m\narea        " << r.area << " m2\nlumens      "
            << r.lumens << '\n';
  print_materials(r.materials);
  for (const Warning& w : r.warnings) {
    std::cout << "\nwarning: " << w.what << " (" << w.count << ")\n";
    for (const std::string& e : w.examples) std::cout << "  " << e << '\n';
  }
}

Result<int> inspect_scene(Inspect& options, const Global& global) {
  if (!options.visible.empty() || !options.cells.empty() || !options.portals.empty())
    return usage_error("--visible, --cells and --portals are of a run", "give a run directory");
  options.scene.files = options.words;
  const Result<Scene> scene = import_scene(options.scene);
  if (!scene.ok()) return scene.status();
  const SceneReport report = inspect(*scene);
  if (global.json)
    std::cout << scene_json(report);
  else
    print_scene(report);
  return 0;
}

std::string visible_csv(const Model& model) {
  std::string rows = "receiver,source\n";
  for (std::size_t receiver = 0; receiver < model.visible.size(); ++receiver)
    for (const ClusterId source : model.visible[receiver])
      rows += std::to_string(receiver) + "," + std::to_string(source.value) + "\n";
  return rows;
}

// In the scene's units.
std::string cells_csv(const RunModel& run) {
  std::ostringstream rows;
  rows << std::setprecision(17) << "cell,room,lit,x0,y0,z0,x1,y1,z1\n";
  for (std::size_t i = 0; i < run.model.cells.size(); ++i) {
    const Cell& cell = run.model.cells[i];
    const Vec3 lo = run.frame.to_file(cell.bounds.lo), hi = run.frame.to_file(cell.bounds.hi);
    rows << i << ',' << cell.room << ',' << cell.lit << ',' << lo.x << ',' << lo.y << ',' << lo.z
         << ',' << hi.x << ',' << hi.y << ',' << hi.z << '\n';
  }
  return rows.str();
}

std::string portals_obj(const RunModel& run) {
  std::ostringstream obj;
  obj << std::setprecision(17);
  for (std::size_t i = 0; i < run.model.portals.size(); ++i) {
    const Portal& portal = run.model.portals[i];
    obj << "o portal_" << i << "_cells_" << portal.a.value << "_" << portal.b.value << '\n';
    for (std::uint32_t v = 0; v < portal.vertex_count; ++v) {
      const Vec3 x = run.frame.to_file(run.model.portal_vertices[portal.first_vertex + v]);
      obj << "v " << x.x << ' ' << x.y << ' ' << x.z << '\n';
    }
    obj << 'f';
    for (std::uint32_t v = 0; v < portal.vertex_count; ++v)
      obj << ' ' << portal.first_vertex + v + 1;
    obj << '\n';
  }
  return obj.str();
}

Result<int> inspect_run(const Inspect& options, const Global& global) {
  const auto solution = Solution::open(options.words.front(), kReadingArena);
  if (!solution.ok()) return solution.status();
  const RunModel& run = (*solution)->run();
  if (!options.visible.empty())
    ATRIUM_RETURN_IF_ERROR(write_output(options.visible, {visible_csv(run.model)}));
  if (!options.cells.empty()) ATRIUM_RETURN_IF_ERROR(write_output(options.cells, {cells_csv(run)}));
  if (!options.portals.empty())
    ATRIUM_RETURN_IF_ERROR(write_output(options.portals, {portals_obj(run)}));
  const std::string& summary = (*solution)->summary_json();
  if (global.json)
    std::cout << (summary.empty() ? run_json(run.model) : summary);
  else
    std::cout << listed(summary.empty() ? run_json(run.model) : summary);
  return 0;
}

}  // namespace

Command inspect_command() {
  auto options = std::make_shared<Inspect>();
  Command command{"inspect", "what is in a scene or in a run", {}, {}};
  command.options.argument("SCENE|RUN", "a run directory, or one or more scene files", 1,
                           kMostFiles, options->words);
  add_scene_options(command.options, options->scene);
  command.options.text("visible", "of a run: its pairs of clusters that may see each other, CSV",
                       options->visible);
  command.options.text("cells", "of a run: its cells, CSV", options->cells);
  command.options.text("portals", "of a run: its portals, OBJ", options->portals);
  command.run = [options](const Global& global, Console&) {
    std::error_code ignored;
    const bool run = options->words.size() == 1 &&
                     std::filesystem::is_directory(options->words.front(), ignored);
    return run ? inspect_run(*options, global) : inspect_scene(*options, global);
  };
  return command;
}

}  // namespace atrium
