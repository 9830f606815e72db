// The paper's Tables 2 to 5, its columns as printed there, ours under its own; and what was solved,
// in README's columns.
// Functions of their arguments.
#pragma once

#include <span>

#include "bench/paper_report/figures.h"
#include "bench/paper_report/text_table.h"

namespace atrium {

// Tables 2 and 3: of the models named, those that are among ours.
TextTable models_table(std::span<const std::string> names, std::span<const SolvedModel> ours);
// Table 4: the paper's orders that are among ours, then our others.
TextTable orders_table(std::span<const OrderFigures> ours);
// Table 5: the paper's rows by ours; what ours have more follows.
TextTable iterations_table(std::span<const IterationFigures> ours);
TextTable results_table(std::span<const SolvedModel> ours);

}  // namespace atrium
