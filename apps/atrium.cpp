// The program: its commands, and nothing else.
#include "apps/command.h"

int main(int argc, char** argv) {
  const std::vector<atrium::Command> commands{
      atrium::gen_command(),    atrium::inspect_command(),  atrium::plan_command(),
      atrium::solve_command(),  atrium::resume_command(),   atrium::status_command(),
      atrium::stop_command(),   atrium::check_command(),    atrium::probe_command(),
      atrium::render_command(), atrium::export_command(),   atrium::formfactor_command(),
      atrium::trace_command(),  atrium::validate_command(), atrium::report_command(),
      atrium::reference_command()};
  return atrium::run_command_line(argc, argv, commands, atrium::version_text());
}
