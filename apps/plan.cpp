// atrium plan SCENE: what solve would do, and what it leaves out for this scene and why.
#include <iostream>
#include <memory>

#include "apps/report_json.h"
#include "apps/solve_options.h"
#include "engine/quantity.h"
#include "scheduler/warm_start.h"

namespace atrium {
namespace {

void print_plan(const Plan& p) {
  std::cout << "clusters        " << p.clusters << " of " << p.patches << " patches\n"
            << "cells           " << p.cells << " in " << p.rooms << " rooms, " << p.portals
            << " portals\n"
            << "lights          " << p.lights << '\n'
            << "visible         " << format_share(p.visible_share) << " of all cluster pairs\n"
            << "memory          " << format_size(p.memory) << ", at least "
            << format_size(p.smallest_memory) << '\n'
            << "arena           " << format_size(p.arena) << ", at least "
            << format_size(p.smallest_arena) << '\n'
            << "disk            about " << format_size(p.estimated.disk_bytes) << ", at least "
            << format_size(p.smallest_disk) << '\n'
            << "estimated       " << p.estimated.links << " links of " << p.estimated.elements
            << " elements, " << format_size(p.estimated.memory_bytes) << " of memory, "
            << format_time(p.estimated.cpu_seconds) << " of CPU\n"
            << "irradiance      about " << p.mean_irradiance_guess << " lx\n"
            << "smallest edge   " << format_length(p.min_edge) << '\n';
  if (p.warm) std::cout << "start           " << in_words(*p.warm, p) << '\n';
  for (const LeftOut& l : p.left_out)
    std::cout << "left out        " << l.feature << ": " << l.why << '\n';
  for (const NamedGap& g : p.closed_gaps) std::cout << "closed gap      " << gap_words(g) << '\n';
  for (const std::string& w : p.warnings) std::cout << "warning         " << w << '\n';
}

}  // namespace

Command plan_command() {
  auto options = std::make_shared<SolveOptions>();
  Command command{"plan", "what solve would do, and what it leaves out and why", {}, {}};
  add_solve_options(command.options, *options);
  command.run = [options](const Global& global, Console&) -> Result<int> {
    options->threads = global.threads;
    const Result<Plan> made = plan(*options);
    if (!made.ok()) return made.status();
    if (global.json)
      std::cout << plan_json(*made);
    else
      print_plan(*made);
    return 0;
  };
  return command;
}

}  // namespace atrium
