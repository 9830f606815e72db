// What a run's page store tells of who may see whom, in the order in which it gathers.
#pragma once

#include <optional>
#include <string>

#include "apps/report/interaction_matrix.h"

namespace atrium {

struct RunInteractions {
  std::string order;  // its name
  std::optional<InteractionMatrix> matrix;
  std::string why_not;  // there is no matrix
};

// A run of which only the texts are there, or that has not partitioned its scene yet, has none.
RunInteractions read_interactions(const std::string& run_directory);

}  // namespace atrium
