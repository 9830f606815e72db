// atrium inspect SCENE|RUN: what is in it. A directory is a run, anything else a scene's file.
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "apps/leak_report.h"
#include "apps/output.h"
#include "apps/picture/floor_plan.h"
#include "apps/report_json.h"
#include "apps/solve_options.h"
#include "engine/import/inspect.h"
#include "scheduler/run_files.h"
#include "scheduler/solution.h"
#include "visibility/leaks.h"
#include "visibility/partition.h"

namespace atrium {
namespace {

constexpr std::uint64_t kMostStoreys = 1000;

struct Inspect {
  std::vector<std::string> words;
  ImportOptions scene;
  PartitionOptions partition;
  std::string visible, cells, portals, leaks_csv, floor_plan;
  FloorPlanOptions floor;
  bool leaks = false;
  double leak_size = 0.05;  // m

  bool wants_subdivision() const { return !visible.empty() || !cells.empty() || !portals.empty(); }
  bool wants_leaks() const { return leaks || !leaks_csv.empty(); }
  bool wants_rooms() const { return wants_leaks() || !floor_plan.empty(); }
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

std::string visible_csv(const Model& model) {
  std::string rows = "receiver,source\n";
  for (std::size_t receiver = 0; receiver < model.visible.size(); ++receiver)
    for (const ClusterId source : model.visible[receiver])
      rows += std::to_string(receiver) + "," + std::to_string(source.value) + "\n";
  return rows;
}

// In the scene's units.
std::string cells_csv(const Model& model, const SceneFrame& frame) {
  std::ostringstream rows;
  rows << std::setprecision(17) << "cell,room,lit,x0,y0,z0,x1,y1,z1\n";
  for (std::size_t i = 0; i < model.cells.size(); ++i) {
    const Cell& cell = model.cells[i];
    const Vec3 lo = frame.to_file(cell.bounds.lo), hi = frame.to_file(cell.bounds.hi);
    rows << i << ',' << cell.room << ',' << cell.lit << ',' << lo.x << ',' << lo.y << ',' << lo.z
         << ',' << hi.x << ',' << hi.y << ',' << hi.z << '\n';
  }
  return rows.str();
}

std::string portals_obj(const Model& model, const SceneFrame& frame) {
  std::ostringstream obj;
  obj << std::setprecision(17);
  for (std::size_t i = 0; i < model.portals.size(); ++i) {
    const Portal& portal = model.portals[i];
    obj << "o portal_" << i << "_cells_" << portal.a.value << "_" << portal.b.value << '\n';
    for (std::uint32_t v = 0; v < portal.vertex_count; ++v) {
      const Vec3 x = frame.to_file(model.portal_vertices[portal.first_vertex + v]);
      obj << "v " << x.x << ' ' << x.y << ' ' << x.z << '\n';
    }
    obj << 'f';
    for (std::uint32_t v = 0; v < portal.vertex_count; ++v)
      obj << ' ' << portal.first_vertex + v + 1;
    obj << '\n';
  }
  return obj.str();
}

Status write_subdivision(const Inspect& options, const Model& model, const SceneFrame& frame) {
  if (!options.visible.empty())
    ATRIUM_RETURN_IF_ERROR(write_output(options.visible, {visible_csv(model)}));
  if (!options.cells.empty())
    ATRIUM_RETURN_IF_ERROR(write_output(options.cells, {cells_csv(model, frame)}));
  if (!options.portals.empty())
    ATRIUM_RETURN_IF_ERROR(write_output(options.portals, {portals_obj(model, frame)}));
  return {};
}

Status write_leaks(const Inspect& options, const Scene& scene, const RoomPlan& plan,
                   const Global& global) {
  const std::vector<LeakRow> rows = leak_rows(scene, find_leaks(scene, plan, options.leak_size));
  if (!options.leaks_csv.empty())
    ATRIUM_RETURN_IF_ERROR(write_output(options.leaks_csv, {leak_csv(rows)}));
  if (global.json)
    std::cout << leaks_json(rows);
  else if (options.leaks)
    std::cout << leak_table(rows, plan.rooms, options.leak_size);
  return {};
}

// What is asked for of the scene's rooms; told in place of what is in the scene.
Status inspect_rooms(const Inspect& options, const Scene& scene, const Global& global) {
  const RoomPlan plan = find_room_plan(scene);
  if (options.wants_leaks()) ATRIUM_RETURN_IF_ERROR(write_leaks(options, scene, plan, global));
  if (options.floor_plan.empty()) return {};
  const Result<std::string> svg = floor_plan_svg(scene, plan, options.floor);
  if (!svg.ok()) return svg.status();
  return write_output(options.floor_plan, {*svg});
}

Result<int> inspect_scene(Inspect& options, const Global& global) {
  options.scene.files = options.words;
  const Result<Scene> scene = import_scene(options.scene);
  if (!scene.ok()) return scene.status();
  if (options.wants_subdivision()) {
    const Result<Model> model = partition(*scene, options.partition);
    if (!model.ok()) return model.status();
    ATRIUM_RETURN_IF_ERROR(write_subdivision(options, *model, scene->frame));
  }
  if (options.wants_rooms()) {
    ATRIUM_RETURN_IF_ERROR(inspect_rooms(options, *scene, global));
    return 0;
  }
  const SceneReport report = inspect(*scene);
  if (global.json)
    std::cout << scene_json(report);
  else
    print_scene(report);
  return 0;
}

// The scene that a run was begun with, read again.
Result<Scene> scene_of_run(const std::string& run) {
  SolveOptions options;
  ATRIUM_RETURN_IF_ERROR(read_run_toml(run + "/" + RunFiles::name(RunFile::kToml), options));
  return import_scene(options.scene);
}

Result<int> inspect_run(const Inspect& options, const Global& global) {
  const std::string& directory = options.words.front();
  const auto solution = Solution::open(directory, kReadingArena);
  if (!solution.ok()) return solution.status();
  const RunModel& run = (*solution)->run();
  ATRIUM_RETURN_IF_ERROR(write_subdivision(options, run.model, run.frame));
  if (options.wants_rooms()) {
    const Result<Scene> scene = scene_of_run(directory);
    if (!scene.ok()) return scene.status();
    ATRIUM_RETURN_IF_ERROR(inspect_rooms(options, *scene, global));
    return 0;
  }
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
  OptionSet& o = command.options;
  o.argument("SCENE|RUN", "a run directory, or one or more scene files", 1, kMostFiles,
             options->words);
  add_scene_options(o, options->scene);
  add_partition_options(o, options->partition);
  o.text("visible", "its pairs of clusters that may see each other, CSV", options->visible);
  o.text("cells", "its cells, CSV", options->cells);
  o.text("portals", "its portals, OBJ", options->portals);
  o.flag("leaks", "cracks that join two rooms or a room and the outdoors, the widest first",
         options->leaks);
  o.text("leaks-csv", "the same as CSV, to a file", options->leaks_csv);
  o.length("leak-size", "openings narrower than this are leaks (5cm)", options->leak_size);
  o.text("floor-plan", "a level section of its rooms, cells and portals, SVG", options->floor_plan);
  o.length("height", "of that section above the storey's floor (1.2m)", options->floor.height);
  o.count("storey", "which storey it cuts, 1 is the lowest (1)", 1, kMostStoreys,
          [options](std::uint64_t n) { options->floor.storey = n; });
  command.run = [options](const Global& global, Console&) -> Result<int> {
    if (!(options->leak_size > 0))
      return usage_error("--leak-size is nothing", "give it a length, as in 5cm");
    std::error_code ignored;
    const bool run = options->words.size() == 1 &&
                     std::filesystem::is_directory(options->words.front(), ignored);
    return run ? inspect_run(*options, global) : inspect_scene(*options, global);
  };
  return command;
}

}  // namespace atrium
