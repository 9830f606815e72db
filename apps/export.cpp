// atrium export RUN -o FILE: the solution for other programs.
#include <filesystem>
#include <iostream>
#include <memory>

#include "apps/command.h"
#include "apps/export/formats.h"
#include "apps/report_json.h"

namespace atrium {
namespace {

struct Export {
  std::vector<std::string> run;
  std::string output;
};

Result<Exported> write_mesh(Solution& solution, const std::string& kind, const std::string& path) {
  const Result<SurfaceMesh> mesh = surface_mesh(solution);
  if (!mesh.ok()) return mesh.status();
  return kind == ".glb" ? write_glb(*mesh, path) : write_ply(*mesh, path);
}

Result<int> run_export(const Export& e, const Global& global, Console& console) {
  if (e.output.empty())
    return usage_error("export needs -o FILE", "name a .glb, .ply or .csv file");
  const std::string kind = std::filesystem::path(e.output).extension().string();
  if (kind != ".glb" && kind != ".ply" && kind != ".csv")
    return Status(Code::kUsage, e.output, "", "no exports of kind '" + kind + "'",
                  "name a .glb, .ply or .csv file; pictures are made by `atrium render`");
  const auto solution = Solution::open(e.run.front(), kReadingArena);
  if (!solution.ok()) return solution.status();
  const Result<Exported> done =
      kind == ".csv" ? write_csv(**solution, e.output) : write_mesh(**solution, kind, e.output);
  if (!done.ok()) return done.status();
  console.say(e.output + ": " + std::to_string(done->faces) + " faces");
  if (global.json) std::cout << export_json(e.output, done->bytes, done->vertices, done->faces);
  return 0;
}

}  // namespace

Command export_command() {
  auto options = std::make_shared<Export>();
  Command command{"export", "the solution for other programs", {}, {}};
  command.options.argument("RUN", "a run directory", 1, 1, options->run);
  command.options.output("what to write: .glb, .ply or .csv", options->output);
  command.run = [options](const Global& global, Console& console) {
    return run_export(*options, global, console);
  };
  return command;
}

}  // namespace atrium
